#include "target/picture_fault.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "furrow/base/text.h"

namespace furrow::target {
namespace {

/// A board's white paper seldom fills half of a picture, and never to the limit of the sensor.
constexpr int kWhite = 250;
constexpr double kMostWhite = 0.4;
/// Where even the brightest hundredth stays below this, squares have no contrast.
constexpr int kDark = 40;
/// One sigma of the sharpest edges, px, above which corners of small squares run into each other.
constexpr double kWidestEdge_px = 2.5;

struct Histogram {
  std::array<double, 256> share{};

  explicit Histogram(const Image& grey) {
    for (const std::uint8_t level : grey.data) share[level] += 1.0 / static_cast<double>(grey.data.size());
  }
  /// The level below which that share of the picture lies.
  int level(double below) const {
    int at = 0;
    for (double sum = share[0]; sum < below && at < 255; sum += share[static_cast<std::size_t>(at)]) ++at;
    return at;
  }
  double at_least(int level) const {
    double sum = 0.0;
    for (std::size_t i = static_cast<std::size_t>(level); i < share.size(); ++i) sum += share[i];
    return sum;
  }
};

/// Brightest minus darkest level within a few pixels along a row or a column.
double step_across(const Image& grey, int u, int v, bool along_row) {
  constexpr int kReach = 10;
  int low = 255, high = 0;
  for (int d = -kReach; d <= kReach; ++d) {
    const int x = along_row ? u + d : u, y = along_row ? v : v + d;
    if (x < 0 || y < 0 || x >= grey.width || y >= grey.height) continue;
    low = std::min<int>(low, *grey.at(x, y));
    high = std::max<int>(high, *grey.at(x, y));
  }
  return high - low;
}

struct Slope {
  double steepness;  ///< grey levels per px
  int u, v;
  bool along_row;
};

/// The steepest slope of each block of a picture: edges are everywhere in a picture of a board.
std::vector<Slope> steepest_slopes(const Image& grey) {
  constexpr int kBlock = 24;
  std::vector<Slope> out;
  for (int v0 = 1; v0 + 1 < grey.height; v0 += kBlock) {
    for (int u0 = 1; u0 + 1 < grey.width; u0 += kBlock) {
      Slope best{0.0, 0, 0, true};
      for (int v = v0; v < std::min(v0 + kBlock, grey.height - 1); ++v) {
        for (int u = u0; u < std::min(u0 + kBlock, grey.width - 1); ++u) {
          const double du = 0.5 * std::abs(*grey.at(u + 1, v) - *grey.at(u - 1, v)),
                       dv = 0.5 * std::abs(*grey.at(u, v + 1) - *grey.at(u, v - 1));
          if (std::max(du, dv) > best.steepness) best = {std::max(du, dv), u, v, du >= dv};
        }
      }
      out.push_back(best);
    }
  }
  return out;
}

/// Sigma of the edges with the greatest steps: an edge of step C blurred by sigma rises by C / (sqrt(2 pi)
/// sigma) a pixel. 0 when the picture has no steps to speak of.
double edge_sigma_px(const Image& grey) {
  constexpr double kSmallestStep = 30.0;  // grey levels
  struct Edge {
    double step, sigma_px;
  };
  std::vector<Edge> edges;
  for (const Slope& slope : steepest_slopes(grey)) {
    const double step = step_across(grey, slope.u, slope.v, slope.along_row);
    if (step < kSmallestStep) continue;
    edges.push_back({step, step / (slope.steepness * std::sqrt(2.0 * std::numbers::pi))});
  }
  constexpr std::size_t kFewest = 8;
  if (edges.size() < kFewest) return 0.0;
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.step > b.step; });
  edges.resize(std::max(kFewest, edges.size() / 3));
  const auto middle = edges.begin() + static_cast<std::ptrdiff_t>(edges.size() / 2);
  std::nth_element(edges.begin(), middle, edges.end(),
                   [](const Edge& a, const Edge& b) { return a.sigma_px < b.sigma_px; });
  return middle->sigma_px;
}

}  // namespace

std::string picture_fault(const Image& grey) {
  if (grey.empty()) return "";
  const Histogram histogram(grey);
  if (const double white = histogram.at_least(kWhite); white > kMostWhite)
    return "overexposed: " + base::format_fixed(100.0 * white, 0) + " % of it is white";
  if (const int bright = histogram.level(0.99); bright < kDark)
    return "too dark: all but a hundredth of it is below " + std::to_string(bright + 1) + " of 255";
  const double sigma_px = edge_sigma_px(grey);
  if (sigma_px <= kWidestEdge_px) return "";
  return "blurred: its sharpest edges are " + base::format_fixed(sigma_px, 1) + " px wide";
}

}  // namespace furrow::target
