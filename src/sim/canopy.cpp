#include "sim/canopy.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>

#include "furrow/base/parallel.h"
#include "furrow/geom/angles.h"
#include "sim/noise.h"

namespace furrow::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using geom::deg_to_rad;
using geom::kPi;

// Where the look of a vineyard is set. None of these enters the mean silhouette, which fit_level() brings to
// the scene's numbers.
constexpr double kLeafSizeLow = 0.75, kLeafSizeHigh = 1.2;  // leaf size over the mean one
constexpr double kLeafTilt = 0.55;    // one-sigma of a leaf's tilt against the envelope, as a slope
constexpr double kInnerLayers = 1.3;  // leaf area inside the envelope, per envelope area
constexpr double kInnerLow = 0.45, kInnerHigh = 0.8;  // where, as a part of the envelope's half width
constexpr double kInnerSize = 1.5;
constexpr double kCoarsestWithInner = 4;  // from afar nothing is seen between the leaves
constexpr double kCoarsestWithWood = 8;
constexpr double kGapRamp_m = 0.25;                       // foliage thins over this length at a gap
constexpr double kShortWave_m = 0.45, kLongWave_m = 1.7;  // of the envelope's roughness along the row
constexpr double kTransmitted = 0.45;                     // light through a leaf over light back from it
constexpr double kExtinction_per_m = 4.0;                 // of the sun inside the canopy
constexpr int kShadowSteps = 5;
constexpr double kShadowEdge_m = 0.12;  // softness of a row's outline in its shadow
constexpr double kFitLength_m = 40.0;   // row length on which a silhouette is measured
constexpr double kSunwards_m = 0.06;    // from a wall to its sunward side
constexpr double kHiddenFrom = 0.25;    // depth from which a far wall is out of sight
constexpr int kFewestBlades = 6;        // of a young corn plant
constexpr int kBladeCuts = 6;           // straight pieces of a blade seen from near
constexpr double kCornExtinction_per_m = 1.5;
constexpr double kBelowOne = 0.999999;
constexpr std::uint64_t kLightSalt = 0x116870000000000ULL;  // parts a leaf's light from its place
constexpr double kOpenReach = 4.0;                          // sigmas to which open_above() is tabulated
constexpr int kFitRounds = 3;
constexpr int kFitRow = 1021;  // a row number that no field has, yet small enough for float coordinates

double smoothstep(double q) {
  q = std::clamp(q, 0.0, 1.0);
  return q * q * (3.0 - 2.0 * q);
}

double rough(std::uint64_t key, double s) {
  return 0.8 * line_noise(key, s, kShortWave_m) + 0.6 * line_noise(key ^ 0x5151, s, kLongWave_m);
}

/// Probability that a standard normal exceeds x.
double normal_above(double x) {
  return 0.5 * std::erfc(x / std::sqrt(2.0));
}

/// In [0, 1) by one 32-bit draw: enough for looks, at half the price of uniform().
double small_uniform(base::Random& random) {
  return static_cast<double>(random.bits()) * 0x1.0p-32;
}

/// Mean 0, one-sigma 1, within +-3.5, nearly normal: the sum of four 16-bit parts, whose variances are 1 / 12
/// each.
double soft_normal(base::Random& random) {
  const std::uint32_t a = random.bits(), b = random.bits();
  const double sum = static_cast<double>((a & 0xffffU) + (a >> 16U) + (b & 0xffffU) + (b >> 16U));
  return (sum / 65536.0 - 2.0 + 2.0 / 65536.0) * 1.7320508075688772;
}

Vector3f rgb(const std::vector<double>& c) {
  return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
}

}  // namespace

std::array<Eigen::Vector2f, kHexagonCorners> hexagon_outline() {
  std::array<Eigen::Vector2f, kHexagonCorners> outline;
  for (int i = 0; i < kHexagonCorners; ++i) {
    const double angle = 2.0 * kPi * i / kHexagonCorners;
    outline[static_cast<std::size_t>(i)] = {static_cast<float>(std::cos(angle)),
                                            static_cast<float>(std::sin(angle))};
  }
  return outline;
}

std::array<Eigen::Vector2f, kLobedCorners> lobed_outline() {
  // Five lobes of a vine leaf, the one at the stalk shortest; about the hexagon's area.
  constexpr std::array<double, kLobedCorners> kReach = {1.22, 0.78, 1.12, 0.72, 1.0,
                                                        0.45, 1.0,  0.72, 1.12, 0.78};
  std::array<Eigen::Vector2f, kLobedCorners> outline;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const double angle = 2.0 * kPi * static_cast<double>(i) / kLobedCorners;
    outline[i] = {static_cast<float>(kReach[i] * std::cos(angle)),
                  static_cast<float>(kReach[i] * std::sin(angle))};
  }
  return outline;
}

/// Stretching leaves along the row leaves its cross-section as it is: the finest level whose fit serves this
/// one too.
int Canopy::alike(int level) {
  if (level == 0) return 0;
  const int widening = level / kStretches * kStretches;
  for (int other = widening + 1; other < level; ++other) {
    if (has_inner(other) == has_inner(level)) return other;
  }
  return level;
}

bool Canopy::has_inner(int level) {
  return stretch_of(level) * widen_of(level) <= kCoarsestWithInner;
}

std::array<Eigen::Vector2f, 4> rectangle_outline() {
  // A hexagon of circumradius 1 has the area 3 sqrt(3) / 2, and reaches sqrt(3) / 2 across: so does this.
  const float along = 0.75F, across = std::sqrt(3.0F) / 2.0F;
  return {Eigen::Vector2f(-along, -across), Eigen::Vector2f(along, -across), Eigen::Vector2f(along, across),
          Eigen::Vector2f(-along, across)};
}

std::array<Eigen::Vector2f, 4> blade_outline(float taper) {
  return {Eigen::Vector2f(-1, -1), Eigen::Vector2f(1, -taper), Eigen::Vector2f(1, taper),
          Eigen::Vector2f(-1, 1)};
}

Canopy::Canopy(const Scene& scene, bool fitted) : scene_(scene) {
  for (int i = 0; i < kOpenNodes; ++i) {
    const double outside = kOpenReach * (2.0 * i / (kOpenNodes - 1) - 1.0);
    open_[static_cast<std::size_t>(i)] = std::exp(-scene.field.leaf_layers * normal_above(outside));
  }
  if (!fitted) return;
  base::parallel_for(kLevels, 0, [this](std::size_t i) {
    const int level = static_cast<int>(i);
    if (alike(level) == level) fits_[i] = fit_level(level);
  });
  for (int level = 0; level < kLevels; ++level) {
    fits_[static_cast<std::size_t>(level)] = fits_[static_cast<std::size_t>(alike(level))];
  }
}

std::uint64_t Canopy::key(std::uint64_t salt, std::int64_t a, std::int64_t b) const {
  return base::mix_bits(base::mix_bits(base::mix_bits(scene_.seed ^ salt) + static_cast<std::uint64_t>(a)) +
                        static_cast<std::uint64_t>(b));
}

bool Canopy::plant_missing(int row, std::int64_t plant) const {
  return unit_hash(key(21, row, plant)) < scene_.field.gap_probability;
}

double Canopy::even_density(int row, double s) const {
  return 1.0 + scene_.field.density_variation * std::clamp(line_noise(key(22, row), s, 0.8), -2.0, 2.0);
}

double Canopy::density(int row, double s) const {
  const Field& f = scene_.field;
  const double even = even_density(row, s);
  const double at = s / f.plant_spacing_m;
  const auto plant = static_cast<std::int64_t>(std::floor(at));
  if (plant_missing(row, plant)) {
    const double from_left_m = (at - static_cast<double>(plant)) * f.plant_spacing_m;
    const double ramp_m = std::min(kGapRamp_m, 0.5 * f.plant_spacing_m);
    const double left = plant_missing(row, plant - 1) ? 0.0 : 1.0 - smoothstep(from_left_m / ramp_m);
    const double right =
        plant_missing(row, plant + 1) ? 0.0 : 1.0 - smoothstep((f.plant_spacing_m - from_left_m) / ramp_m);
    return even * std::max(left, right);
  }
  return even;
}

double Canopy::envelope_half_width(double height_m) const {
  const Field& f = scene_.field;
  if (height_m < f.foliage_bottom_m || height_m > f.row_height_m) return 0.0;
  const double q = (height_m - f.foliage_bottom_m) / (f.row_height_m - f.foliage_bottom_m);
  return f.base_half_width_m + q * (f.half_width_m - f.base_half_width_m);
}

Vector3d Canopy::to_sun(double direction_rad) const {
  const double elevation = deg_to_rad(scene_.sun.elevation_deg);
  // Angle of the sun to the left of the row there.
  const double left = deg_to_rad(scene_.field.azimuth_deg - scene_.sun.azimuth_deg) - direction_rad;
  return {std::cos(elevation) * std::cos(left), std::cos(elevation) * std::sin(left), std::sin(elevation)};
}

double Canopy::sunlight(double s, double l, double height_m, double direction_rad) const {
  const Field& f = scene_.field;
  const double low = std::max(height_m + 0.02, f.foliage_bottom_m);
  if (low >= f.row_height_m) return 1.0;
  const Vector3d sun = to_sun(direction_rad);
  const double step_m = (f.row_height_m - low) / kShadowSteps;
  double depth = 0.0;
  for (int i = 0; i < kShadowSteps; ++i) {
    const double h = low + (i + 0.5) * step_m;
    const double rise = (h - height_m) / sun.z();
    const double at_l = l + sun.y() * rise, at_s = s + sun.x() * rise;
    const double row = std::round(at_l / f.spacing_m);
    if (std::abs(row) > f.rows_each_side) continue;
    const double inside_m = envelope_half_width(h) - std::abs(at_l - row * f.spacing_m);
    const double edge = smoothstep(inside_m / kShadowEdge_m + 0.5);
    if (edge > 0.0) depth += edge * density(static_cast<int>(row), at_s) * step_m / sun.z();
  }
  return std::exp(-(f.crop == Crop::corn ? kCornExtinction_per_m : kExtinction_per_m) * depth);
}

double Canopy::sunlight_under_even_rows(const Vector3d& sun, double l, double height_m) const {
  const Field& f = scene_.field;
  const double low = std::max(height_m + 0.02, f.foliage_bottom_m);
  if (low >= f.row_height_m) return 1.0;
  const double step_m = (f.row_height_m - low) / kShadowSteps;
  double depth = 0.0;
  for (int i = 0; i < kShadowSteps; ++i) {
    const double h = low + (i + 0.5) * step_m;
    const double at_l = l + sun.y() * (h - height_m) / sun.z();
    const double off_row = at_l - f.spacing_m * std::floor(at_l / f.spacing_m + 0.5);
    depth +=
        smoothstep((envelope_half_width(h) - std::abs(off_row)) / kShadowEdge_m + 0.5) * step_m / sun.z();
  }
  return std::exp(-(f.crop == Crop::corn ? kCornExtinction_per_m : kExtinction_per_m) * depth);
}

/// Chance that no leaf of the envelope's own layer stands above one that is `outside` sigmas out.
double Canopy::open_above(double outside) const {
  const double at = (std::clamp(outside / kOpenReach, -1.0, 1.0) + 1.0) * 0.5 * (kOpenNodes - 1);
  return open_[static_cast<std::size_t>(at + 0.5)];
}

Course Canopy::course_of(const Piece& piece, const Fit& fit) const {
  const Field& f = scene_.field;
  const int row = piece.row;
  Course course{};
  course.sun = to_sun(piece.direction_rad);
  // Roughness has mean 0: the shape is fitted without it, so that no one stretch's bumps enter the fit.
  const double width_rough = piece.calibrating ? 0.0 : f.width_roughness_m;
  const double height_rough = piece.calibrating ? 0.0 : f.height_roughness_m;
  for (std::size_t i = 0; i < Course::kNodes; ++i) {
    const double part = static_cast<double>(i) / (Course::kNodes - 1);
    const double s = (piece.number + part) * kPiece_m;
    course.top[i] = f.row_height_m - fit.drop_m + height_rough * rough(key(23, row), s);
    course.left[i] = std::max(0.02, f.half_width_m - fit.inset_m + width_rough * rough(key(24, row), s));
    course.right[i] = std::max(0.02, f.half_width_m - fit.inset_m + width_rough * rough(key(25, row), s));
    course.density[i] = piece.calibrating ? even_density(row, s) : density(row, s);
    if (piece.calibrating) continue;
    course.tone[i] = line_noise(key(26, row), s, f.plant_spacing_m);
    const double wall_l = f.half_width_m + part * (f.base_half_width_m - f.half_width_m);
    const double wall_h = f.row_height_m + part * (f.foliage_bottom_m - f.row_height_m);
    const double lean = kSunwards_m * course.sun.y();  // leaves of the wall do not shade themselves
    course.sun_left[i] = sunlight_under_even_rows(course.sun, wall_l + lean, wall_h);
    course.sun_right[i] = sunlight_under_even_rows(course.sun, -wall_l + lean, wall_h);
  }
  return course;
}

Canopy::Surface Canopy::pick_surface(const Course& course, double part, bool with_inner,
                                     base::Random& random) const {
  const Field& f = scene_.field;
  const double top = course.at(course.top, part);
  const bool left = small_uniform(random) < 0.5;
  const double edge = course.at(left ? course.left : course.right, part);
  const double base_edge = std::min(edge, f.base_half_width_m);
  const double bottom = std::min(f.foliage_bottom_m + 0.4 * f.leaf_m, top);
  const double wall = std::sqrt((top - bottom) * (top - bottom) + (edge - base_edge) * (edge - base_edge));
  Surface at{};
  at.inner = with_inner && small_uniform(random) < kInnerLayers / (kInnerLayers + f.leaf_layers);
  at.left = left;
  const double side = left ? 1.0 : -1.0;
  const bool on_top = small_uniform(random) * (edge + wall) < edge;
  const double q = small_uniform(random);  // from the middle to the edge, or from the top down
  if (on_top) {
    at.point = {0.0, side * q * edge, top};
    at.normal = {0.0, side * 0.25 * q, 1.0};
  } else {
    at.point = {0.0, side * (edge + q * (base_edge - edge)), top + q * (bottom - top)};
    at.normal = {0.0, side * (top - bottom), 0.4 * (top - bottom) - (edge - base_edge)};
    at.depth = q;
  }
  at.normal.normalize();
  at.outside = soft_normal(random);
  if (at.inner) {
    const double shrink = (kInnerLow + (kInnerHigh - kInnerLow) * small_uniform(random));
    at.point.y() *= shrink;
    at.point.z() -= (1.0 - at.depth) * (0.5 + 1.5 * small_uniform(random)) * f.leaf_m;
  } else {
    at.point += f.surface_roughness_m * at.outside * at.normal;
  }
  return at;
}

Vector3f Canopy::light(const Leaf& leaf, const Course& course) const {
  if (leaf.shape == Shape::blade) return leaf.colour;
  const Field& f = scene_.field;
  const Vector3d& sun = course.sun;
  base::Random random(leaf.seed);
  const auto depth = static_cast<double>(leaf.depth), part = static_cast<double>(leaf.part);
  double lit = small_uniform(random) < open_above(static_cast<double>(leaf.outside)) + 0.25 ? 1.0 : 0.25;
  if (leaf.inner) lit *= 0.35;
  lit *= course.at(leaf.left ? course.sun_left : course.sun_right, std::min(depth, kBelowOne));
  const double facing = leaf.normal.cast<double>().dot(sun);
  const double front = std::max(0.0, facing), back = std::max(0.0, -facing);
  const double sky = (leaf.inner ? 0.45 : 1.0) * (0.35 + 0.65 * (1.0 - 0.7 * depth));
  const double direct = lit * (front + kTransmitted * back) / sun.z();
  // Leaves differ in age: young ones are lighter and yellower, vines differ from each other.
  const double vine = course.at(course.tone, std::min(part, kBelowOne));
  const auto tone = static_cast<float>(std::clamp(1.0 + 0.17 * soft_normal(random) + 0.08 * vine, 0.5, 1.7));
  const auto yellow =
      static_cast<float>(std::clamp(0.12 * soft_normal(random) + 0.05 * vine + 0.05, -0.25, 0.6));
  const Vector3f colour =
      rgb(f.leaf_rgb).cwiseProduct(Vector3f(1.0F + yellow, 1.0F + 0.35F * yellow, 1.0F)) * tone;
  Vector3f falling =
      kSunColour * static_cast<float>(direct) + kSkyColour * static_cast<float>(scene_.sun.diffuse * sky);
  if (back > 0.0) falling = falling.cwiseProduct(Vector3f(1.15F, 1.05F, 0.7F));
  return colour.cwiseProduct(falling);
}

Course Canopy::append_vines(const Piece& piece, const Fit& fit, std::vector<Leaf>& out) const {
  const Field& f = scene_.field;
  const double stretch = stretch_of(piece.level), widen = widen_of(piece.level);
  const bool with_inner = has_inner(piece.level);
  const double wall = std::hypot(f.row_height_m - f.foliage_bottom_m, f.half_width_m - f.base_half_width_m);
  const double densest = 1.0 + 2.0 * f.density_variation;
  const double leaf_area = 0.25 * kPi * f.leaf_m * f.leaf_m;
  const double layers = f.leaf_layers + (with_inner ? kInnerLayers : 0.0);
  const double wanted =
      layers * 2.0 * (f.half_width_m + wall) * kPiece_m * densest / (leaf_area * stretch * widen);
  const Course course = course_of(piece, fit);
  const std::uint64_t piece_key = key(27 + static_cast<std::uint64_t>(piece.level), piece.row, piece.number);
  const int count = static_cast<int>(wanted + unit_hash(piece_key));
  for (int i = 0; i < count; ++i) {
    const std::uint64_t leaf_key = piece_key + static_cast<std::uint64_t>(i);
    base::Random random(leaf_key);
    const double part = small_uniform(random);
    if (small_uniform(random) * densest >= course.at(course.density, part)) continue;
    const Surface at = pick_surface(course, part, with_inner, random);
    if (at.depth > kHiddenFrom && piece.hidden_side == (at.left ? 1 : -1)) continue;
    const double half = 0.5 * f.leaf_m *
                        (kLeafSizeLow + (kLeafSizeHigh - kLeafSizeLow) * small_uniform(random)) *
                        (at.inner ? kInnerSize : 1.0);
    Leaf leaf;
    Vector3d normal, along, across;
    if (piece.level == 0) {
      const double tilt_s = soft_normal(random), tilt_l = soft_normal(random), tilt_h = soft_normal(random);
      normal = (at.normal + kLeafTilt * Vector3d(tilt_s, tilt_l, tilt_h)).normalized();
      const double turn = 2.0 * kPi * small_uniform(random);
      const Vector3d a = normal.unitOrthogonal(), b = normal.cross(a);
      along = std::cos(turn) * a + std::sin(turn) * b;
      across = std::cos(turn) * b - std::sin(turn) * a;
    } else {
      // Longer leaves lie along the row, and tilt about it.
      const double tilt_l = soft_normal(random), tilt_h = soft_normal(random);
      normal = (at.normal + kLeafTilt * Vector3d(0.0, tilt_l, tilt_h)).normalized();
      along = Vector3d::UnitX();
      across = normal.cross(along);
    }
    const Vector3d centre((piece.number + part) * kPiece_m, piece.row * f.spacing_m + at.point.y(),
                          at.point.z());
    leaf.centre = centre.cast<float>();
    leaf.along = (half * stretch * along).cast<float>();
    leaf.across = (half * widen * across).cast<float>();
    leaf.normal = normal.cast<float>();
    leaf.part = static_cast<float>(part);
    leaf.depth = static_cast<float>(at.depth);
    leaf.outside = static_cast<float>(at.outside);
    leaf.inner = at.inner;
    leaf.left = at.left;
    leaf.seed = leaf_key ^ kLightSalt;
    out.push_back(leaf);
  }
  return course;
}

void Canopy::append_corn(const Piece& piece, const Fit& fit, std::vector<Leaf>& out) const {
  const Field& f = scene_.field;
  const double reach = std::max(0.01, f.half_width_m - fit.inset_m);
  const double top = std::max(0.02, f.row_height_m - fit.drop_m);
  const auto first = static_cast<std::int64_t>(std::ceil(piece.number * kPiece_m / f.plant_spacing_m));
  const Vector3d sun = to_sun(piece.direction_rad);
  const int cuts = std::max(2, kBladeCuts / static_cast<int>(stretch_of(piece.level)));
  for (std::int64_t plant = first;
       static_cast<double>(plant) * f.plant_spacing_m < (piece.number + 1) * kPiece_m; ++plant) {
    if (!piece.calibrating && plant_missing(piece.row, plant)) continue;
    base::Random random(key(40, piece.row, plant));
    const double s = (static_cast<double>(plant) + 0.15 * soft_normal(random)) * f.plant_spacing_m;
    const Vector3d foot(s, piece.row * f.spacing_m + 0.08 * f.half_width_m * soft_normal(random), 0.0);
    const double size = std::clamp(1.0 + 0.12 * soft_normal(random), 0.6, 1.4);
    const int blades = kFewestBlades + static_cast<int>(random.below(4));
    double turn = random.uniform(0.0, 2.0 * kPi);
    for (int i = 0; i < blades; ++i) {
      turn += kPi + random.uniform(-0.6, 0.6);  // blades stand on alternate sides
      const double age = (i + 0.5) / blades;    // the lowest, oldest blades are the longest and droop most
      const double length = reach * size * (1.35 - 0.6 * age) * random.uniform(0.85, 1.15);
      const double rise = top * size * (0.45 + 0.65 * age) * random.uniform(0.9, 1.1);
      append_blade(foot, turn, length, rise, 0.5 * f.leaf_m * random.uniform(0.8, 1.2), cuts, sun, out);
    }
  }
}

void Canopy::append_blade(const Vector3d& foot, double turn, double length, double rise, double half_width,
                          int cuts, const Vector3d& sun, std::vector<Leaf>& out) const {
  const Vector3d forth(std::cos(turn), std::sin(turn), 0.0);
  const Vector3d wide(-std::sin(turn), std::cos(turn), 0.0);
  // Rises from the stalk, turns over at two thirds of its reach, and hangs.
  const auto spine = [&](double t) -> Vector3d {
    const double over = t / 0.66;
    return foot + length * t * t * (1.5 - 0.5 * t) * forth +
           Vector3d(0, 0, rise * (0.15 + 0.85 * over * (2.0 - over)));
  };
  const auto width = [&](double t) {
    return half_width * std::sqrt(std::max(0.0, (0.25 + 3.0 * t) * (1.0 - t))) / 1.06;
  };
  for (int k = 0; k < cuts; ++k) {
    const double t0 = static_cast<double>(k) / cuts, t1 = (k + 1.0) / cuts;
    const Vector3d from = spine(t0), to = spine(t1);
    Vector3d normal = (to - from).cross(wide).normalized();
    if (normal.z() < 0.0) normal = -normal;
    const double facing = normal.dot(sun) / sun.z();
    const double direct = std::clamp(facing > 0.0 ? facing : -kTransmitted * facing, 0.0, 1.6);
    const double open =
        0.45 + 0.55 * std::clamp(0.5 * (from.z() + to.z()) / scene_.field.row_height_m, 0.0, 1.0);
    Leaf leaf;
    leaf.shape = Shape::blade;
    leaf.centre = (0.5 * (from + to)).cast<float>();
    leaf.along = (0.5 * (to - from)).cast<float>();
    leaf.across = (std::max(width(t0), 1e-4) * wide).cast<float>();
    leaf.taper = static_cast<float>(width(t1) / std::max(width(t0), 1e-4));
    leaf.colour = rgb(scene_.field.leaf_rgb)
                      .cwiseProduct(kSunColour * static_cast<float>(direct) +
                                    kSkyColour * static_cast<float>(scene_.sun.diffuse * open));
    out.push_back(leaf);
  }
}

void Canopy::append_wood(int row, int piece, double direction_rad, std::vector<Leaf>& out) const {
  const Field& f = scene_.field;
  const Vector3d sun = to_sun(direction_rad);
  // Round wood as two crossed boards, cut into short lengths so that one depth serves each.
  const auto stand = [&](double s, double l, double low, double high, double half_m, const Vector3f& colour) {
    constexpr double kCut_m = 0.2;
    const int cuts = std::max(1, static_cast<int>((high - low) / kCut_m));
    const double half_cut = 0.5 * (high - low) / cuts;
    for (int i = 0; i < cuts; ++i) {
      const double h = low + (2 * i + 1) * half_cut;
      const double lit = 0.6 * sunlight(s, row * f.spacing_m + l, h, direction_rad) / std::max(0.3, sun.z());
      for (const Vector3f& wide : {Vector3f(0, 1, 0), Vector3f(1, 0, 0)}) {
        Leaf leaf;
        leaf.shape = Shape::blade;
        leaf.centre = Vector3d(s, row * f.spacing_m + l, h).cast<float>();
        leaf.along = Vector3f(0, 0, static_cast<float>(half_cut));
        leaf.across = static_cast<float>(half_m) * wide;
        leaf.colour = colour * static_cast<float>(lit + scene_.sun.diffuse * 0.7);
        out.push_back(leaf);
      }
    }
  };
  const double from = piece * kPiece_m, to = from + kPiece_m;
  for (auto i = static_cast<std::int64_t>(std::ceil(from / f.plant_spacing_m - 0.5));
       (static_cast<double>(i) + 0.5) * f.plant_spacing_m < to; ++i) {
    if (plant_missing(row, i)) continue;
    const double s =
        (static_cast<double>(i) + 0.5) * f.plant_spacing_m + 0.06 * (unit_hash(key(30, row, i)) - 0.5);
    stand(s, 0.05 * (unit_hash(key(31, row, i)) - 0.5), 0.0, f.foliage_bottom_m + 0.15, 0.028,
          {0.10F, 0.075F, 0.05F});
  }
  if (f.post_spacing_m <= 0.0) return;
  for (auto i = static_cast<std::int64_t>(std::ceil(from / f.post_spacing_m));
       static_cast<double>(i) * f.post_spacing_m < to; ++i) {
    stand(static_cast<double>(i) * f.post_spacing_m, 0.0, 0.0, f.post_height_m, 0.035, {0.30F, 0.28F, 0.25F});
  }
}

Course Canopy::append_piece(int row, int piece, int level, double direction_rad, int hidden_side,
                            std::vector<Leaf>& out) const {
  const Fit& fit = fits_[static_cast<std::size_t>(std::clamp(level, 0, kLevels - 1))];
  if (scene_.field.crop == Crop::corn) {
    append_corn({row, piece, level, hidden_side, false, direction_rad}, fit, out);
    return {};
  }
  const Course course = append_vines({row, piece, level, hidden_side, false, direction_rad}, fit, out);
  if (stretch_of(level) * widen_of(level) <= kCoarsestWithWood) append_wood(row, piece, direction_rad, out);
  return course;
}

Canopy::Fit Canopy::fit_level(int level) const {
  const Field& f = scene_.field;
  constexpr int kBeyond =
      3;  // pieces at both ends, so that long leaves cover the ends as they cover the middle
  Fit fit;
  for (int round = 0; round < kFitRounds; ++round) {
    std::vector<Leaf> leaves;
    for (int piece = -kBeyond; piece < static_cast<int>(kFitLength_m / kPiece_m) + kBeyond; ++piece) {
      if (f.crop == Crop::corn) {
        append_corn({kFitRow, piece, level, 0, true, 0.0}, fit, leaves);
      } else {
        append_vines({kFitRow, piece, level, 0, true, 0.0}, fit, leaves);
      }
    }
    for (Leaf& leaf : leaves) leaf.centre.y() -= static_cast<float>(kFitRow * f.spacing_m);
    const Silhouette seen = measure_silhouette(leaves, kFitLength_m, f.half_width_m);
    fit.inset_m += seen.half_width_m - f.half_width_m;
    fit.drop_m += seen.top_m - f.row_height_m;
  }
  return fit;
}

namespace {

constexpr double kGridAlong_m = 0.1, kGridAcross_m = 0.01;

/// Heights of the first hit from above on a grid; NaN-free: 0 where nothing is hit.
struct HeightGrid {
  int along, across;
  double half_extent_m;
  std::vector<float> top;
};

void drop_leaf(const Leaf& leaf, HeightGrid& grid) {
  static const auto kHexagon = hexagon_outline();
  const std::array<Eigen::Vector2f, 4> blade = blade_outline(leaf.taper);
  const Eigen::Vector2f* outline = leaf.shape == Shape::leaf ? kHexagon.data() : blade.data();
  const int corners = leaf.shape == Shape::leaf ? kHexagonCorners : 4;
  // The leaf's plane seen from above: invert (s, l) = centre + a along + b across.
  Eigen::Matrix2f axes;
  axes << leaf.along.x(), leaf.across.x(), leaf.along.y(), leaf.across.y();
  const float det = axes.determinant();
  if (std::abs(det) < 1e-9F) return;
  const Eigen::Matrix2f back = axes.inverse();
  const Eigen::Vector3d centre = leaf.centre.cast<double>();
  const double reach_s = static_cast<double>(std::abs(leaf.along.x()) + std::abs(leaf.across.x()));
  const double reach_l = static_cast<double>(std::abs(leaf.along.y()) + std::abs(leaf.across.y()));
  const auto index = [](double x, double step) { return static_cast<int>(std::floor(x / step)); };
  const int i0 = std::max(0, index(centre.x() - reach_s, kGridAlong_m));
  const int i1 = std::min(grid.along - 1, index(centre.x() + reach_s, kGridAlong_m));
  const int j0 = std::max(0, index(centre.y() - reach_l + grid.half_extent_m, kGridAcross_m));
  const int j1 = std::min(grid.across - 1, index(centre.y() + reach_l + grid.half_extent_m, kGridAcross_m));
  for (int i = i0; i <= i1; ++i) {
    for (int j = j0; j <= j1; ++j) {
      const Eigen::Vector2f at(static_cast<float>((i + 0.5) * kGridAlong_m),
                               static_cast<float>((j + 0.5) * kGridAcross_m - grid.half_extent_m));
      const Eigen::Vector2f ab = back * (at - leaf.centre.head<2>());
      bool inside = true;
      for (int k = 0; k < corners && inside; ++k) {
        const Eigen::Vector2f p = outline[k], q = outline[(k + 1) % corners];
        inside = (q.x() - p.x()) * (ab.y() - p.y()) - (q.y() - p.y()) * (ab.x() - p.x()) >= 0.0F;
      }
      if (!inside) continue;
      const float height = leaf.centre.z() + ab.x() * leaf.along.z() + ab.y() * leaf.across.z();
      float& top = grid.top[static_cast<std::size_t>(i) * static_cast<std::size_t>(grid.across) +
                            static_cast<std::size_t>(j)];
      top = std::max(top, height);
    }
  }
}

/// Where coverage, going outwards, falls through half of its middle value for the last time.
double half_cover_edge(const std::vector<double>& cover, bool left) {
  const int count = static_cast<int>(cover.size());
  const int middle = count / 2;
  double inside = 0.0;
  const int core = std::max(1, count / 16);
  for (int j = middle - core; j < middle + core; ++j)
    inside += cover[static_cast<std::size_t>(j)] / (2.0 * core);
  const int step = left ? 1 : -1;
  int j = left ? count - 1 : 0;
  while (j != middle && cover[static_cast<std::size_t>(j)] < 0.5 * inside) j -= step;
  const double here = cover[static_cast<std::size_t>(j)];
  const int next_index = std::clamp(j + step, 0, count - 1);
  const double next = cover[static_cast<std::size_t>(next_index)];
  const double part = here > next ? (here - 0.5 * inside) / (here - next) : 0.0;
  return std::abs((j + step * std::clamp(part, 0.0, 1.0) + 0.5) - 0.5 * count) * kGridAcross_m;
}

}  // namespace

Silhouette measure_silhouette(const std::vector<Leaf>& leaves, double length_m, double nominal_half_width_m) {
  HeightGrid grid;
  grid.half_extent_m = 2.0 * nominal_half_width_m + 0.3;
  grid.along = static_cast<int>(length_m / kGridAlong_m);
  grid.across = 2 * static_cast<int>(grid.half_extent_m / kGridAcross_m);
  grid.half_extent_m = 0.5 * grid.across * kGridAcross_m;
  grid.top.assign(static_cast<std::size_t>(grid.along) * static_cast<std::size_t>(grid.across), 0.0F);
  for (const Leaf& leaf : leaves) drop_leaf(leaf, grid);

  std::vector<double> cover(static_cast<std::size_t>(grid.across), 0.0);
  double sum = 0.0;
  std::size_t hits = 0;
  for (int i = 0; i < grid.along; ++i) {
    for (int j = 0; j < grid.across; ++j) {
      const float top = grid.top[static_cast<std::size_t>(i) * static_cast<std::size_t>(grid.across) +
                                 static_cast<std::size_t>(j)];
      if (top <= 0.0F) continue;
      cover[static_cast<std::size_t>(j)] += 1.0 / grid.along;
      const double l = (j + 0.5) * kGridAcross_m - grid.half_extent_m;
      if (std::abs(l) < 0.8 * nominal_half_width_m) {
        sum += static_cast<double>(top);
        ++hits;
      }
    }
  }
  Silhouette seen;
  seen.half_width_m = 0.5 * (half_cover_edge(cover, true) + half_cover_edge(cover, false));
  seen.top_m = hits > 0 ? sum / static_cast<double>(hits) : 0.0;
  return seen;
}

}  // namespace furrow::sim
