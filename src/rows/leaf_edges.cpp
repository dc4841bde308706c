#include "rows/leaf_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "rows/row_light.h"
#include "rows/top_spacing.h"

namespace furrow::rows {
namespace {

constexpr double kMeetingSigmaPx = 2.0;  // how well edges of leaves tell where rows meet
constexpr int kRows = 3;                 // beside the followed one; beyond, a row's top is a few pixels

/// Drop, or rise where `sign` is -1, over its standard error, limited softly, so that one sharp edge does not
/// outweigh a comb of three.
double evidence(const LightSide& side, float sign, double place) {
  constexpr double kLeastSigma = 0.01, kSoft = 6.0;
  const double drop = static_cast<double>(sign * value_at(side.all, place));
  if (drop <= 0.0) return 0.0;
  const double z = drop / std::hypot(static_cast<double>(side.sigma_at(place)), kLeastSigma);
  return z / (1.0 + z / kSoft);
}

std::optional<Estimate> edge_near(const LightSide& side, float sign, double place, double reach) {
  constexpr double kLeastEvidence = 2.4;  // a step of four sigmas
  constexpr double kFinest = 0.01;        // row numbers: a leaf
  const auto peak = peak_near(side.all, sign, place, reach);
  if (!peak || evidence(side, sign, *peak) < kLeastEvidence) return std::nullopt;
  double mean = 0.0, squares = 0.0;
  std::array<double, kLightBlocks> places{};
  for (std::size_t b = 0; b < kLightBlocks; ++b) {
    places[b] = peak_near(side.without[b], sign, place, reach).value_or(place);
    mean += places[b] / kLightBlocks;
  }
  for (const double one : places) squares += (one - mean) * (one - mean);
  const double sigma = std::sqrt(squares * (kLightBlocks - 1) / kLightBlocks);
  if (sigma > 0.5 * reach) return std::nullopt;
  return Estimate{*peak, std::hypot(sigma, kFinest), kLightBlocks};
}

/// The far edges near their places at that spacing.
TopComb comb_of(const std::array<LightSide, 2>& sides, const std::array<LightSide, 2>& leaf_sides,
                const GroundEdges& ground, const TopLight& tops) {
  TopComb comb;
  comb.middle = ground.middle;
  comb.spacing = tops.spacing;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    // Ground behind a top is dark; behind one in shade only leaves can be lighter.
    const LightSide& side = tops.rises[i] ? leaf_sides[i] : sides[i];
    const float sign = tops.rises[i] ? -1.0F : 1.0F;
    for (int k = 1; k <= kRows; ++k) {
      const double place = ground.middle + side.direction * (k * tops.spacing + ground.half_width);
      const double reach = std::min(0.8 * ground.half_width, 0.2 * tops.spacing);
      if (const auto edge = edge_near(side, sign, place, reach))
        comb.edges.push_back({side.direction * k, *edge});
    }
  }
  return comb;
}

}  // namespace

FoundTops find_tops(const GreenMap& map, const CommonModel& model, double tilt,
                    const std::vector<RowLine>& rows) {
  FoundTops found;
  if (map.light.empty()) return found;
  const auto fan = fan_of(model.field(), tilt);
  const auto ground = ground_edges(rows, model);
  if (!fan || !ground) return found;
  const LightByRow light = light_by_row(map, model.field(), *fan);
  const std::array sides = sides_of(light, Bare::dark), leaf_sides = sides_of(light, Bare::not_there);
  const TopsByLight by_light = tops_by_light(sides, leaf_sides, *ground, *fan);
  found.explained = by_light.by_saw;
  const TiltByLight tilted = tilt_by_light(sides, *ground, *fan);
  // Smooth walls make no saw: one under a tilt must explain more than they do.
  if (tilted.by_saw > by_light.by_faces) found.tilt = tilted.tilt;
  if (by_light.tops) found.comb = comb_of(sides, leaf_sides, *ground, *by_light.tops);
  return found;
}

void write_tops(const TopComb& comb, const PlanarField& field, double tilt, std::vector<RowLine>& rows) {
  const auto fan = fan_of(field, tilt);
  if (!fan) return;
  for (const TopEdge& edge : comb.edges) {
    for (RowLine& row : rows) {
      if (row.index != edge.row) continue;
      const auto top = edge.row < 0 ? &RowSample::top_left_u_px : &RowSample::top_right_u_px;
      for (RowSample& sample : row.samples) {
        const double v = sample.centre_px.y();
        if (field.scale(v) < kLeastScale) continue;
        const double place = (edge.place.value - comb.middle) / comb.spacing;
        sample.*top = fan->u_at(v, place);
        sample.top_sigma_px =
            std::hypot(edge.place.sigma / comb.spacing * field.spacing_at(v), kMeetingSigmaPx);
      }
    }
  }
}

}  // namespace furrow::rows
