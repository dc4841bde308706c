#include "rows/leaf_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "furrow/base/whole.h"

namespace furrow::rows {
namespace {

constexpr int kTextures = 8;  // levels of local contrast
constexpr int kLooks = kChromaCells * kTextures;

/// Something for every look: a chroma and a texture.
using Looks = std::vector<float>;

/// Sum of the absolute differences of light across each pixel, along and across; 0 at the border.
cv::Mat light_steps(const cv::Mat& light) {
  cv::Mat steps(light.rows, light.cols, CV_16U, cv::Scalar(0)), along, across;
  if (light.rows < 3 || light.cols < 3) return steps;
  const cv::Range middle_v(1, light.rows - 1), middle_u(1, light.cols - 1);
  const auto from = [&](int v, int u) {
    return light(cv::Range(v, v + light.rows - 2), cv::Range(u, u + light.cols - 2));
  };
  cv::absdiff(from(1, 0), from(1, 2), along);
  cv::absdiff(from(0, 1), from(2, 1), across);
  cv::add(along, across, steps(middle_v, middle_u));
  return steps;
}

/// The look of every pixel. Texture is the mean light step over the mean light of 5 x 5 px, an eighth a
/// level: leaves in sun and leaves in shade stand side by side; mown grass and soil are even.
std::vector<std::uint16_t> looks_of(const GreenMap& map) {
  constexpr double kLevelsPerContrast = 8.0;
  const cv::Mat light(map.height, map.width, CV_16U, const_cast<std::uint16_t*>(map.light.data()));
  cv::Mat steps, lights, levels;
  cv::blur(light_steps(light), steps, {5, 5});
  cv::blur(light, lights, {5, 5});
  cv::add(lights, cv::Scalar(static_cast<double>(kDarkLevel)), lights);
  cv::divide(steps, lights, levels, kLevelsPerContrast, CV_8U);
  std::vector<std::uint16_t> looks(map.chroma.size());
  const std::uint8_t* level = levels.ptr<std::uint8_t>();
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const unsigned texture = std::min<unsigned>(level[i], kTextures - 1);
    looks[i] = static_cast<std::uint16_t>(texture * kChromaCells + map.chroma[i]);
  }
  return looks;
}

/// What stands in the cores of the near rows and what beside them. Every picture row counts alike, in
/// spacings.
struct Census {
  Looks core = Looks(kLooks), rest = Looks(kLooks);
  double cores = 0.0, rests = 0.0;  ///< sums of the two
  double core_green = 0.0;          ///< sum of the cores' excess green

  void add(bool in_core, std::uint16_t look, float green, float weight) {
    (in_core ? core : rest)[look] += weight;
    (in_core ? cores : rests) += static_cast<double>(weight);
    if (in_core) core_green += static_cast<double>(weight * green);
  }
};

/// The followed row and its neighbours: these show their walls too, in sun and in shade.
Census take_census(const GreenMap& map, const std::vector<std::uint16_t>& looks, const CommonModel& model,
                   double tooth, const std::optional<Relief>& relief) {
  constexpr double kReach =
      1.5;  // row numbers from the followed row: out to the alleys beyond its neighbours
  constexpr double kCoreShare = 0.25;   // half the core over the row's visible width
  constexpr double kLeastScale = 0.25;  // farther off, lens and JPEG mix cores and alleys
  constexpr int kPictureRows = 160;     // enough to know the looks
  Census census;
  const Cut near = model.at(map.v_in_picture(0.7 * map.height));
  const double followed = std::round((map.u_in_picture(0.5 * (map.width - 1)) - near.centre) / near.spacing);
  const int step = std::max(1, map.height / kPictureRows);
  for (int v = step / 2; v < map.height; v += step) {
    const double v_px = map.v_in_picture(v);
    if (model.field().scale(v_px) < kLeastScale) continue;
    const Cut cut = model.at(v_px);
    const double per_u = map.scale_u / cut.spacing;  // row numbers per column of the map
    const double k0 = (map.u_in_picture(0.0) - cut.centre) / cut.spacing - followed;
    const int first = base::ceil_between((-kReach - k0) / per_u, 0, map.width);
    const int last = base::floor_between((kReach - k0) / per_u, -1, map.width - 1);
    const std::uint16_t* look = looks.data() + static_cast<std::ptrdiff_t>(v) * map.width;
    for (int u = first; u <= last; ++u) {
      const double k = k0 + u * per_u;
      const bool in_core = relief ? relief->surface_at(k + followed) != Surface::ground
                                  : std::abs(k - std::round(k)) < kCoreShare * tooth;
      census.add(in_core, look[u], map.row(v)[u], static_cast<float>(per_u));
    }
  }
  return census;
}

/// Spreads counts over looks one level apart: 1 2 1, twice by each chroma and once by texture, about what
/// noise and JPEG do.
void smooth(Looks& looks) {
  Looks out(looks.size());
  const auto spread = [&](int stride, int levels) {
    for (int i = 0; i < kLooks; ++i) {
      const int level = i / stride % levels;
      const auto at = static_cast<std::size_t>(i), apart = static_cast<std::size_t>(stride);
      const float before = level > 0 ? looks[at - apart] : 0.0F;
      const float after = level + 1 < levels ? looks[at + apart] : 0.0F;
      out[at] = 0.25F * (before + after) + 0.5F * looks[at];
    }
    looks.swap(out);
  };
  for (int round = 0; round < 2; ++round) {
    spread(1, kChromaLevels);
    spread(kChromaLevels, kChromaLevels);
  }
  spread(kChromaCells, kTextures);
}

/// 0 below `low`, 1 above `high`, smooth between.
float smooth_step(float value, float low, float high) {
  const float x = std::clamp((value - low) / (high - low), 0.0F, 1.0F);
  return x * x * (3.0F - 2.0F * x);
}

}  // namespace

GreenMap leaf_map(GreenMap map, const CommonModel& model, double tooth, const std::optional<Relief>& relief) {
  constexpr double kLeastPixels = 20.0;  // of each kind, in spacings
  constexpr float kRare = 2e-6F;         // a look with a smaller share was not seen
  // Mean odds of core against core and rest, over the cores: 0.5 where they look like their surroundings.
  constexpr float kLeastOdds = 0.55F;
  // Parts of those odds at which a look stops being ground, and is leaf: looks at half the odds of a leaf
  // stand more often beside the rows than in them.
  constexpr float kGround = 0.4F, kLeaf = 0.9F;
  // Ground goes where hardly a pixel around is leaf, so that the places where an edge mixes with the ground
  // keep their greenness: at a straight edge a quarter of the window is leaf 1.75 px outside it.
  constexpr int kAround = 7;  // px
  constexpr float kNoLeaf = 0.18F, kSomeLeaf = 0.32F;
  if (map.chroma.empty()) return map;
  const std::vector<std::uint16_t> looks = looks_of(map);
  Census census = take_census(map, looks, model, tooth, relief);
  if (census.cores < kLeastPixels || census.rests < kLeastPixels) return map;
  smooth(census.core);
  smooth(census.rest);
  Looks odds(kLooks);
  float mean_odds = 0.0F;
  for (std::size_t i = 0; i < odds.size(); ++i) {
    const float core = census.core[i] / static_cast<float>(census.cores);
    const float rest = census.rest[i] / static_cast<float>(census.rests);
    odds[i] = core / (core + rest + kRare);
    mean_odds += core * odds[i];
  }
  if (mean_odds < kLeastOdds) return map;
  std::vector<std::uint8_t> leafness(kLooks);
  for (std::size_t i = 0; i < odds.size(); ++i)
    leafness[i] =
        static_cast<std::uint8_t>(std::lround(255.0F * smooth_step(odds[i] / mean_odds, kGround, kLeaf)));
  cv::Mat leaf(map.height, map.width, CV_8U), around;
  for (std::size_t i = 0; i < looks.size(); ++i) leaf.ptr<std::uint8_t>()[i] = leafness[looks[i]];
  cv::blur(leaf, around, {kAround, kAround});
  std::array<float, 256> kept{};
  for (std::size_t i = 0; i < kept.size(); ++i)
    kept[i] = smooth_step(static_cast<float>(i) / 255.0F, kNoLeaf, kSomeLeaf);
  for (std::size_t i = 0; i < looks.size(); ++i) map.value[i] *= kept[around.ptr<std::uint8_t>()[i]];
  return map;
}

}  // namespace furrow::rows
