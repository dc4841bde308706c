#include "rows/relief.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace furrow::rows {
namespace {

constexpr double kReach = 6.0;  // row numbers to each side
constexpr double kBin = 0.05;   // row numbers
constexpr int kBins = 240;      // 2 kReach / kBin
constexpr int kFeatures = 3;    // log light, shares of red and green

/// The picture's mean features by row number, less their means, with squares that sum up to 1.
struct Profile {
  std::vector<float> k;
  std::array<std::vector<float>, kFeatures> feature;

  /// Row numbers in view.
  double extent() const { return kBin * static_cast<double>(k.size()); }
};

using Features = std::array<float, kFeatures>;

/// Features of every pixel of a picture row.
void features_of(const GreenMap& map, int row, std::vector<Features>& features) {
  const std::uint16_t* light = map.light.data() + static_cast<std::ptrdiff_t>(row) * map.width;
  const std::uint16_t* chroma = map.chroma.data() + static_cast<std::ptrdiff_t>(row) * map.width;
  for (int u = 0; u < map.width; ++u) {
    const int high = chroma[u] / kChromaLevels, low = chroma[u] % kChromaLevels;  // two numbers in one
    features[static_cast<std::size_t>(u)] = {std::log(static_cast<float>(light[u]) + kDarkLevel),
                                             static_cast<float>(high), static_cast<float>(low)};
  }
}

Profile profile_of(const GreenMap& map, const PlanarField& field) {
  constexpr double kLeastScale = 0.15;
  constexpr int kPictureRows = 120;
  constexpr int kLeastRows = 6;  // picture rows that show a place
  std::array<std::array<double, kFeatures>, kBins> sums{};
  std::array<int, kBins> counts{};
  std::vector<Features> features(static_cast<std::size_t>(map.width));
  const int step = std::max(1, map.height / kPictureRows);
  for (int row = step / 2; row < map.height; row += step) {
    const double v = map.v_in_picture(row);
    if (field.scale(v) < kLeastScale) continue;
    features_of(map, row, features);
    const double zero = field.k_at(0.0, v), per_px = 1.0 / field.spacing_at(v);
    std::array<std::array<double, kFeatures>, kBins> here{};
    std::array<int, kBins> pixels{};
    for (int u = 0; u < map.width; ++u) {
      const double place = (zero + map.u_in_picture(u) * per_px + kReach) / kBin;
      if (!(place >= 0.0 && place < kBins)) continue;
      const auto bin = static_cast<std::size_t>(place);
      for (std::size_t f = 0; f < kFeatures; ++f)
        here[bin][f] += static_cast<double>(features[static_cast<std::size_t>(u)][f]);
      ++pixels[bin];
    }
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      if (pixels[bin] == 0) continue;
      for (std::size_t f = 0; f < kFeatures; ++f) sums[bin][f] += here[bin][f] / pixels[bin];
      ++counts[bin];
    }
  }
  Profile profile;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    if (counts[bin] < kLeastRows) continue;
    profile.k.push_back(static_cast<float>((static_cast<double>(bin) + 0.5) * kBin - kReach));
    for (std::size_t f = 0; f < kFeatures; ++f)
      profile.feature[f].push_back(static_cast<float>(sums[bin][f] / counts[bin]));
  }
  for (auto& values : profile.feature) {
    double sum = 0.0, squares = 0.0;
    for (const float value : values) sum += static_cast<double>(value);
    for (float& value : values) {
      value -= static_cast<float>(sum / static_cast<double>(values.size()));
      squares += static_cast<double>(value * value);
    }
    for (float& value : values) value *= static_cast<float>(1.0 / std::sqrt(std::max(squares, 1e-12)));
  }
  return profile;
}

/// Parts of a surface that may look each their own: of a top from left to right, of the walls on each side
/// of the camera from foot to top, of the ground from row to row.
constexpr int kTopParts = 5, kWallParts = 4, kGroundParts = 12;
constexpr int kParts = kTopParts + 2 * kWallParts + kGroundParts;

int part_of(double fraction, int parts) {
  return std::clamp(static_cast<int>(fraction * parts), 0, parts - 1);
}

/// std::floor is a call where the processor is not told; it is most of the search's time.
double floor_of(double x) {
  const double whole = static_cast<double>(static_cast<std::int64_t>(x));
  return whole > x ? whole - 1.0 : whole;
}

/// A place on a surface.
struct Place {
  Surface surface;
  int part = 0;  ///< among kParts
};

/// A relief with what every place needs of it.
class Surfaces {
 public:
  explicit Surfaces(const Relief& relief)
      : relief_(relief),
        axis_(relief.middle - relief.camera),
        per_period_(1.0 / relief.spacing),
        half_width_(relief.half_width / relief.spacing) {}

  Place at(double k) const {
    const double x = k - relief_.camera;
    const double periods = (x - axis_) * per_period_;
    const double off = periods - floor_of(periods + 0.5);
    if (std::abs(off) <= half_width_)
      return {Surface::top, part_of(0.5 + 0.5 * off / half_width_, kTopParts)};
    // The next row outwards stands before what lies behind it, from its foot on.
    const bool right = x >= 0.0;
    const double next = right ? floor_of(periods) + 1.0 : floor_of(periods);
    const double edge = axis_ + (next + (right ? -half_width_ : half_width_)) * relief_.spacing;
    const double foot = relief_.foot * edge;
    if ((edge > 0.0) == right && std::abs(x) > std::abs(foot)) {
      const double up = (x - foot) / (edge - foot);
      return {Surface::wall, kTopParts + (right ? 0 : kWallParts) + part_of(up, kWallParts)};
    }
    const double ground = (x / relief_.foot - axis_) * per_period_;
    return {Surface::ground, kTopParts + 2 * kWallParts + part_of(ground - floor_of(ground), kGroundParts)};
  }

 private:
  const Relief& relief_;
  double axis_, per_period_, half_width_;
};

/// Log likelihood of the picture where each part has one look; `part_at` gives the part at a row number.
template <class PartAt>
double score_of(const Profile& profile, const PartAt& part_at) {
  constexpr double kPiece = 0.25;       // row numbers: what lies closer looks alike
  constexpr double kMostPieces = 30.0;  // the rest lies far off, where a row is a few pixels
  constexpr double kLeastLeft = 0.05;
  std::array<float, kParts> count{};
  std::array<Features, kParts> sum{};
  for (std::size_t i = 0; i < profile.k.size(); ++i) {
    const auto part = static_cast<std::size_t>(part_at(static_cast<double>(profile.k[i])));
    count[part] += 1.0F;
    for (std::size_t f = 0; f < kFeatures; ++f) sum[part][f] += profile.feature[f][i];
  }
  Features explained{};
  for (std::size_t part = 0; part < kParts; ++part) {
    if (count[part] == 0.0F) continue;
    for (std::size_t f = 0; f < kFeatures; ++f) explained[f] += sum[part][f] * sum[part][f] / count[part];
  }
  const double pieces = std::min(kMostPieces, profile.extent() / kPiece);
  double score = 0.0;
  for (const float part : explained)
    score -= 0.5 * pieces * std::log(std::max(1.0 - static_cast<double>(part), kLeastLeft));
  return score;
}

/// The same of stripes on flat ground, which repeat from row to row or, as where every second alley is sown,
/// from every second one to the next.
double flat_score(const Profile& profile) {
  const auto repeating = [&](double rows) {
    return score_of(profile, [rows](double k) { return part_of(k / rows - floor_of(k / rows), kParts); });
  };
  return std::max(repeating(1.0), repeating(2.0));
}

constexpr std::array kHalfWidths = {0.13, 0.18, 0.26};  // of tops, in spacings
constexpr double kLeastPeriods = 4.0;                   // in view: to fewer, some relief fits by chance

/// A relief with its log likelihood.
struct Scored {
  Relief relief;
  double score = -1.0;

  void take_better(const Relief& other, double other_score) {
    if (other_score > score) relief = other, score = other_score;
  }
};

double score_of(const Profile& profile, const Relief& relief) {
  const Surfaces surfaces(relief);
  return score_of(profile, [&](double k) { return surfaces.at(k).part; });
}

/// The best reliefs with tops at the field's rows, and of all.
struct Search {
  Scored same, any;
};

/// Over all spacings, phases, widths and heights.
Search search(const Profile& profile, double camera) {
  constexpr double kFrom = 0.45, kRatio = 1.07;
  constexpr int kSpacings = 26;  // to 2.44
  constexpr int kPhases = 14;
  constexpr std::array kFeet = {0.45, 0.65, 0.85};
  // Tops lie farther apart than rows that were found on what is seen of the ground between, too.
  constexpr double kLeastSame = 0.75, kMostSame = 1.9, kSameMiddle = 0.2;
  Search found;
  Relief relief;
  relief.camera = camera;
  relief.spacing = kFrom;
  for (int step = 0; step < kSpacings; ++step, relief.spacing *= kRatio) {
    const bool is_seen = profile.extent() > kLeastPeriods * relief.spacing;
    for (int phase = 0; phase < kPhases; ++phase) {
      relief.middle = (static_cast<double>(phase) / kPhases - 0.5) * relief.spacing;
      const bool same =
          std::abs(relief.middle) < kSameMiddle && relief.spacing > kLeastSame && relief.spacing < kMostSame;
      if (!is_seen && !same) continue;
      for (const double half_width : kHalfWidths) {
        relief.half_width = half_width * relief.spacing;
        for (const double foot : kFeet) {
          relief.foot = foot;
          const double score = score_of(profile, relief);
          found.any.take_better(relief, score);
          if (same) found.same.take_better(relief, score);
        }
      }
    }
  }
  return found;
}

/// The best of those whose field is strips on the ground, midway between the crop's rows.
Scored between_strips(const Profile& profile, double camera) {
  constexpr double kLowestFoot = 0.40, kStep = 0.02;
  constexpr int kFeet = 27;  // to 0.92
  Scored best;
  for (int step = 0; step < kFeet; ++step) {
    Relief relief;
    relief.camera = camera;
    relief.foot = kLowestFoot + step * kStep;
    relief.spacing = 1.0 / relief.foot;
    if (!(profile.extent() > kLeastPeriods * relief.spacing)) continue;
    for (const double side : {-0.5, 0.5}) {
      const double top = camera + (side - camera) / relief.foot;
      relief.middle = std::remainder(top, relief.spacing);
      for (const double half_width : kHalfWidths) {
        relief.half_width = half_width * relief.spacing;
        best.take_better(relief, score_of(profile, relief));
      }
    }
  }
  return best;
}

}  // namespace

Surface Relief::surface_at(double k) const {
  return Surfaces(*this).at(k).surface;
}

Relief Relief::in_own_rows() const {
  return {0.0, 1.0, half_width / spacing, (camera - middle) / spacing, foot};
}

Relief Relief::renumbered(double more) const {
  return {middle + more, spacing, half_width, camera + more, foot};
}

std::optional<FoundRelief> find_relief(const GreenMap& level, const PlanarField& field) {
  // Of log likelihood over the field's own rows: twenty to one for strips that alternate with the crop's rows
  // as they are sown, four hundred to one for any other place.
  constexpr double kStripsGain = 3.0, kLeastGain = 6.0;
  const auto point = field.vanishing_point();
  if (level.light.empty() || !point) return std::nullopt;
  const Profile profile = profile_of(level, field);
  if (profile.k.empty()) return std::nullopt;
  // Straight below the vanishing point lies what is below the camera.
  const double camera = field.k_at(point->x(), point->y() + field.length);
  const auto [same, any] = search(profile, camera);
  const Scored strips = between_strips(profile, camera);
  const double here = std::max(same.score, flat_score(profile));
  const double by_strips = strips.score - kStripsGain, by_any = any.score - kLeastGain;
  if (std::max(by_strips, by_any) <= here) return FoundRelief{same.relief, false};
  return FoundRelief{by_strips > by_any ? strips.relief : any.relief, true};
}

}  // namespace furrow::rows
