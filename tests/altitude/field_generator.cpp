#include "field_generator.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Core>

#include "furrow/geom/angles.h"

namespace furrow::altitude::testing {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kRowStepPx = 10.0;

/// One long edge of a prism: lateral offset and drop below the camera, and which way is out of the canopy.
struct LongEdge {
  double y = 0.0, drop = 0.0;
  double out_y = 0.0, out_down = 0.0;
};

struct Scene {
  const World& world;
  const Camera& camera;
  Eigen::Matrix3d cam_from_row;
};

/// Pixel of the edge's point at angle phi along the row, or nothing behind the camera.
std::optional<Eigen::Vector2d> pixel_at(const Scene& scene, const LongEdge& edge, double phi) {
  const double x = edge.drop * std::tan(phi);
  const double y = edge.y + 0.5 * scene.world.curvature_per_m * x * x;
  // A path that slants along the row is longer by 1 / cos of its angle to the cross-section.
  const double longer = std::hypot(x, y, edge.drop) / std::hypot(y, edge.drop);
  const double out = scene.world.softness_m * std::log(longer);
  const Eigen::Vector3d point(x, y + out * edge.out_y, -edge.drop - out * edge.out_down);
  return camera::project(scene.camera, scene.cam_from_row * point);
}

/// How far below picture row v the edge is at phi; nothing behind the camera.
std::optional<double> below(const Scene& scene, const LongEdge& edge, double v, double phi) {
  const auto px = pixel_at(scene, edge, phi);
  // A distorted lens means nothing far outside the picture.
  if (!px || px->y() > 3.0 * scene.camera.height) return std::nullopt;
  return px->y() - v;
}

/// u where the edge crosses picture row v. Farther means higher in the picture: halve until both ends can be
/// seen, then the Illinois variant of the false position.
double crossing(const Scene& scene, const LongEdge& edge, double v) {
  double near = -1.55, far = 1.5695;
  std::optional<double> at_near = below(scene, edge, v, near), at_far = below(scene, edge, v, far);
  if (!at_far || *at_far > 0.0) return kNone;
  for (int i = 0; i < 60 && !at_near; ++i) {
    const double middle = 0.5 * (near + far);
    const auto f = below(scene, edge, v, middle);
    if (!f || *f > 0.0) {
      near = middle, at_near = f;
    } else {
      far = middle, at_far = f;
    }
  }
  if (!at_near || *at_near < 0.0) return kNone;
  double phi = far;
  for (int i = 0; i < 60; ++i) {
    phi = far - *at_far * (far - near) / (*at_far - *at_near);
    const auto f = below(scene, edge, v, phi);
    if (!f) return kNone;
    if (std::abs(*f) < 1e-9) break;
    if (*f > 0.0) {
      near = phi, at_near = f, at_far = 0.5 * *at_far;
    } else {
      far = phi, at_far = f, at_near = 0.5 * *at_near;
    }
  }
  const auto px = pixel_at(scene, edge, phi);
  return px && std::abs(px->y() - v) < 1e-6 ? px->x() : kNone;
}

struct Interval {
  double left = kNone, right = kNone;
};

Interval silhouette(const Scene& scene, const std::vector<LongEdge>& edges, double v) {
  Interval all{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const LongEdge& edge : edges) {
    const double u = crossing(scene, edge, v);
    if (std::isnan(u)) return {};
    all.left = std::min(all.left, u);
    all.right = std::max(all.right, u);
  }
  return all;
}

struct PrismRow {
  int index = 0;
  double y = 0.0;
  std::vector<LongEdge> edges;
  double left_error = 0.0, right_error = 0.0;  ///< running AR(1) states
  double top_error = 0.0;                      ///< one for the row
  rows::RowLine line;
};

/// The corners of a row's cross-section: its top, flat or as many chords of half an ellipse, and the feet of
/// its walls, which run straight from where the row is widest to its base; what shows of a wall may end on
/// the way.
std::vector<LongEdge> cross_section(const World& world, const Noise& noise, double y, double grow_left,
                                    double grow_right, base::Random& random) {
  constexpr int kChords = 12;
  const double h = world.height_above_canopy_m, w = world.half_width_m, r = world.rounding_m;
  std::vector<LongEdge> corners = {{y + w + grow_left, h + r, 1.0, r > 0.0 ? 0.0 : -1.0},
                                   {y - w - grow_right, h + r, -1.0, r > 0.0 ? 0.0 : -1.0}};
  for (int i = 1; r > 0.0 && i < kChords; ++i) {
    const double angle = geom::kPi * i / kChords, half = w * std::cos(angle);
    const double share = half / w, grow = share > 0.0 ? share * grow_left : share * grow_right;
    corners.push_back({y + half + grow, h + r - r * std::sin(angle), std::cos(angle), -std::sin(angle)});
  }
  const auto foot = [&](double shown) {
    shown = noise.foot_anywhere ? shown * random.uniform(0.0, 1.0) : shown;
    const double depth = std::max(r, shown * world.foliage_depth_m);
    const double down = world.foliage_depth_m > r ? (depth - r) / (world.foliage_depth_m - r) : 0.0;
    return LongEdge{w + down * (world.base_half_width_m - w), h + depth};
  };
  const LongEdge left = foot(world.left_wall_shown), right = foot(world.right_wall_shown);
  corners.push_back({y + left.y + grow_left, left.drop, 1.0});
  corners.push_back({y - right.y - grow_right, right.drop, -1.0});
  return corners;
}

std::vector<PrismRow> plant(const World& world, const Noise& noise, base::Random& random) {
  std::vector<PrismRow> rows;
  for (int k = -world.rows_each_side; k <= world.rows_each_side; ++k) {
    PrismRow row;
    row.index = k;
    row.y = -world.cross_track_m - k * world.spacing_m + random.normal(0.0, noise.planting_sigma_m);
    const double grow_left = random.normal(0.0, noise.growth_sigma_m);
    const double grow_right = random.normal(0.0, noise.growth_sigma_m);
    row.edges = cross_section(world, noise, row.y, grow_left, grow_right, random);
    row.left_error = random.normal();
    row.right_error = random.normal();
    if (noise.top_sigma_px > 0.0) row.top_error = random.normal(0.0, noise.top_sigma_px);
    row.line.index = k;
    rows.push_back(row);
  }
  // Nearest to the camera first: it hides the others.
  std::sort(rows.begin(), rows.end(),
            [](const PrismRow& a, const PrismRow& b) { return std::abs(a.y) < std::abs(b.y); });
  return rows;
}

/// Whether an edge can be told: not hidden by a nearer row, and, for a detector of green, not against another
/// row's leaves.
bool told(double u, std::size_t own, const std::vector<Interval>& all, bool leaf_against_leaf) {
  constexpr double kGapPx = 2.0;  // green closer than this has grown together
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool matters = i < own || (i > own && !leaf_against_leaf);
    if (matters && u > all[i].left - kGapPx && u < all[i].right + kGapPx) return false;
  }
  return true;
}

double step(double state, double correlation, base::Random& random) {
  return correlation * state + std::sqrt(1.0 - correlation * correlation) * random.normal();
}

/// `top` is where the far edge of the row's top is told by its light.
void add_sample(PrismRow& row, Interval seen, double top, double v, const Camera& camera, const Noise& noise,
                base::Random& random) {
  row.left_error = step(row.left_error, noise.correlation, random);
  row.right_error = step(row.right_error, noise.correlation, random);
  const auto inside = [&](double u) { return u >= 0.0 && u <= camera.width - 1.0; };
  const double left = inside(seen.left) ? seen.left + noise.edge_sigma_px * row.left_error : kNone;
  const double right = inside(seen.right) ? seen.right + noise.edge_sigma_px * row.right_error : kNone;
  if (std::isnan(left) && std::isnan(right)) return;
  if (!noise.edges && (std::isnan(left) || std::isnan(right))) return;
  rows::RowSample sample;
  const double centre = std::isnan(left) ? right : std::isnan(right) ? left : 0.5 * (left + right);
  sample.centre_px = {centre, v};
  sample.sigma_px = std::max(1e-3, noise.edge_sigma_px);
  sample.edge_sigma_px = sample.sigma_px;
  if (noise.edges) sample.left_u_px = left, sample.right_u_px = right;
  if (inside(top)) {
    (row.index < 0 ? sample.top_left_u_px : sample.top_right_u_px) = top + row.top_error;
    sample.top_sigma_px = noise.top_sigma_px;
  }
  row.line.samples.push_back(sample);
}

}  // namespace

Camera thesis_camera() {
  Camera camera;
  camera.model = camera::CameraModel::opencv5;
  camera.width = 1280, camera.height = 720;
  camera.fx = 874.33, camera.fy = 872.39, camera.cx = 640.49, camera.cy = 360.81;
  camera.distortion = {-0.02, 0.015, 0.0005, -0.0004, 0.0};
  return camera;
}

rows::RowLines picture_of(const World& world, const Camera& camera, const Noise& noise, std::uint64_t seed) {
  constexpr double kNarrowestPx = 4.0;  // thinner rows are not found
  constexpr int kTopRows = 3;           // beyond, a row's top is a few pixels
  base::Random random(seed);
  const Scene scene{world, camera, geom::cam_from_level(world.attitude)};
  std::vector<PrismRow> rows = plant(world, noise, random);
  for (double v = 0.0; v <= camera.height - 1.0; v += kRowStepPx) {
    std::vector<Interval> all;
    for (const PrismRow& row : rows) {
      all.push_back(silhouette(scene, row.edges, v));
      if (!(all.back().right - all.back().left >= kNarrowestPx)) all.back() = {};
    }
    for (std::size_t i = 0; i < rows.size(); ++i) {
      Interval seen = all[i];
      double top = kNone;
      if (noise.top_sigma_px > 0.0 && rows[i].index != 0 && std::abs(rows[i].index) <= kTopRows) {
        const double u = rows[i].index < 0 ? seen.left : seen.right;
        if (told(u, i, all, true) && !told(u, i, all, false)) top = u;
      }
      if (!told(seen.left, i, all, noise.leaf_against_leaf)) seen.left = kNone;
      if (!told(seen.right, i, all, noise.leaf_against_leaf)) seen.right = kNone;
      add_sample(rows[i], seen, top, v, camera, noise, random);
    }
  }
  rows::RowLines lines;
  lines.method = "generated";
  lines.width = camera.width, lines.height = camera.height;
  lines.status = "ok";
  lines.confidence = 1.0;
  std::sort(rows.begin(), rows.end(), [](const PrismRow& a, const PrismRow& b) { return a.index < b.index; });
  for (PrismRow& row : rows) {
    if (row.line.samples.size() >= 5) lines.rows.push_back(std::move(row.line));
  }
  return lines;
}

FieldKnowledge knowledge_of(const World& world, double relative_sigma) {
  FieldKnowledge field;
  const auto known = [&](double value) { return Estimate{value, relative_sigma * value, 1}; };
  field.row_spacing_m = known(world.spacing_m);
  field.half_width_m = known(world.half_width_m);
  field.row_height_m = {1.7, 0.05, 1};
  field.outline_rise_m = {0.0, 0.0, 1};  // rows end where they end
  field.rounding_m = known(world.rounding_m);
  field.softness_m = known(world.softness_m);
  field.foliage_depth_m = known(world.foliage_depth_m);
  field.base_width_ratio = known(world.base_half_width_m / world.half_width_m);
  return field;
}

AttitudePrior prior_of(const World& world, double pitch_sigma_rad, double roll_sigma_rad) {
  return {{world.attitude.pitch_rad, pitch_sigma_rad, 1}, {world.attitude.roll_rad, roll_sigma_rad, 1}};
}

}  // namespace furrow::altitude::testing
