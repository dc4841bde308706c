#include "target/lattice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <numbers>
#include <optional>

namespace furrow::target {
namespace {

constexpr double kPi = std::numbers::pi;

/// How many there are, as steps of work.
std::int64_t size_of(const auto& things) {
  return static_cast<std::int64_t>(things.size());
}

constexpr int kNone = -1;

double turn_between(double a_rad, double b_rad) {
  return std::abs(std::remainder(a_rad - b_rad, 2.0 * kPi));
}

/// How far the line to a neighbour may point away from either corner's edge.
constexpr double kLargestTurn_rad = 0.35;

/// Whether the brightness on both sides of the line from p to q is that of an edge whose far side (in rising
/// angle) is `bright`.
bool is_edge(const SmoothGrey& grey, const Eigen::Vector2d& p, const Eigen::Vector2d& q, bool bright,
             double contrast) {
  const Eigen::Vector2d way = q - p;
  const double length = way.norm();
  const Eigen::Vector2d beyond =
      Eigen::Vector2d(-way.y(), way.x()) / length * std::clamp(0.12 * length, 1.2, 3.0);
  for (const double t : {0.3, 0.5, 0.7}) {
    const Eigen::Vector2d at = p + t * way;
    if (!grey.inside(at + beyond) || !grey.inside(at - beyond)) return false;
    const double step = grey.sample(at + beyond) - grey.sample(at - beyond);
    // An edge keeps a fifth of its corners' contrast even where blur and shading differ.
    constexpr double kSmallestShare = 0.2;
    if ((bright ? step : -step) < kSmallestShare * contrast) return false;
  }
  return true;
}

/// The neighbour of each seed along each ray, and the ray by which that one looks back.
struct Link {
  int to = kNone, back = kNone;
};
using Links = std::vector<std::array<Link, 4>>;

/// The ray of `seed` nearest to a direction with the wanted side bright, within the allowed turn.
int ray_towards(const CornerSeed& seed, double angle_rad, bool bright_beyond) {
  for (int r = 0; r < 4; ++r) {
    const auto i = static_cast<std::size_t>(r);
    if (seed.bright_beyond[i] == bright_beyond && turn_between(seed.ray_rad[i], angle_rad) < kLargestTurn_rad)
      return r;
  }
  return kNone;
}

/// The nearest seed along ray `r` of seed `a` that looks back along the same edge.
Link neighbour(const SmoothGrey& grey, const std::vector<CornerSeed>& seeds, std::size_t a, std::size_t r) {
  Link best;
  double nearest_px = std::numeric_limits<double>::infinity();
  const CornerSeed& from = seeds[a];
  for (std::size_t b = 0; b < seeds.size(); ++b) {
    const Eigen::Vector2d way = seeds[b].px - from.px;
    const double length = way.norm();
    if (b == a || length >= nearest_px || length == 0.0) continue;
    const double angle = std::atan2(way.y(), way.x());
    if (turn_between(angle, from.ray_rad[r]) > kLargestTurn_rad) continue;
    // Seen from the other end the bright side of the same edge lies the other way round.
    const int back = ray_towards(seeds[b], angle + kPi, !from.bright_beyond[r]);
    if (back == kNone) continue;
    if (!is_edge(grey, from.px, seeds[b].px, from.bright_beyond[r],
                 std::min(from.contrast, seeds[b].contrast)))
      continue;
    nearest_px = length;
    best = {static_cast<int>(b), back};
  }
  return best;
}

Links link_seeds(const SmoothGrey& grey, const std::vector<CornerSeed>& seeds) {
  Links links(seeds.size());
  for (std::size_t a = 0; a < seeds.size(); ++a) {
    for (std::size_t r = 0; r < 4; ++r) links[a][r] = neighbour(grey, seeds, a, r);
  }
  return links;
}

bool mutual(const Links& links, std::size_t a, std::size_t r) {
  const Link& link = links[a][r];
  return link.to != kNone &&
         links[static_cast<std::size_t>(link.to)][static_cast<std::size_t>(link.back)].to ==
             static_cast<int>(a);
}

constexpr std::array<std::pair<int, int>, 4> kWays{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

/// All seeds that can be reached from `start`, with their places; a seed that would get two places keeps the
/// first.
Lattice walk(const std::vector<CornerSeed>& seeds, const Links& links, std::size_t start,
             std::vector<bool>& taken) {
  struct Visit {
    std::size_t seed;
    std::pair<int, int> place;
    int turn;  ///< way of its ray 0
  };
  Lattice out;
  std::deque<Visit> queue{{start, {0, 0}, 0}};
  taken[start] = true;
  out[{0, 0}] = seeds[start].px;
  while (!queue.empty()) {
    const Visit visit = queue.front();
    queue.pop_front();
    for (int r = 0; r < 4; ++r) {
      if (!mutual(links, visit.seed, static_cast<std::size_t>(r))) continue;
      const Link& link = links[visit.seed][static_cast<std::size_t>(r)];
      const auto next = static_cast<std::size_t>(link.to);
      const int way = (r + visit.turn) % 4;
      const auto [di, dj] = kWays[static_cast<std::size_t>(way)];
      const std::pair<int, int> place{visit.place.first + di, visit.place.second + dj};
      if (taken[next] || out.count(place) > 0) continue;
      taken[next] = true;
      out[place] = seeds[next].px;
      queue.push_back({next, place, (way + 2 - link.back + 4) % 4});
    }
  }
  return out;
}

/// A saddle within `reach_px` of a place, nearest first; nothing when there is none.
std::optional<Eigen::Vector2d> saddle_near(const std::vector<Saddle>& saddles, const Eigen::Vector2d& px,
                                           double reach_px) {
  std::optional<Eigen::Vector2d> best;
  double nearest_px = reach_px;
  for (const Saddle& saddle : saddles) {
    const double distance = (saddle.px - px).norm();
    if (distance < nearest_px) {
      nearest_px = distance;
      best = saddle.px;
    }
  }
  return best;
}

std::optional<Eigen::Vector2d> corner_at(const Lattice& lattice, int i, int j) {
  const auto it = lattice.find({i, j});
  return it == lattice.end() ? std::nullopt : std::optional(it->second);
}

/// A place told by others, and how far it may be off.
struct Prediction {
  Eigen::Vector2d px;
  double reach_px;
};

/// A saddle this share of a square from its predicted place is the corner: its neighbours are a whole square
/// away. Between two corners the prediction is better than beyond them.
constexpr double kReachBetween = 0.2, kReachBeyond = 0.3;

/// Distance from a corner to the nearest of those beside it, px.
double spacing_at(const Lattice& lattice, int i, int j) {
  double nearest = std::numeric_limits<double>::infinity();
  const auto own = corner_at(lattice, i, j);
  for (const auto& [di, dj] : kWays) {
    const auto other = corner_at(lattice, i + di, j + dj);
    if (own && other) nearest = std::min(nearest, (*other - *own).norm());
  }
  return nearest;
}

/// From the corners on both sides of (i, j) in the way (di, dj).
std::optional<Prediction> predict_between(const Lattice& lattice, int i, int j, int di, int dj) {
  const auto a = corner_at(lattice, i + di, j + dj), b = corner_at(lattice, i - di, j - dj);
  if (!a || !b) return std::nullopt;
  const double spacing = std::min(0.5 * (*a - *b).norm(), spacing_at(lattice, i + di, j + dj));
  return Prediction{0.5 * (*a + *b), kReachBetween * spacing};
}

/// By continuing the line of two or three corners that ends before (i, j).
std::optional<Prediction> predict_beyond(const Lattice& lattice, int i, int j, int di, int dj) {
  const auto a = corner_at(lattice, i + di, j + dj), b = corner_at(lattice, i + 2 * di, j + 2 * dj);
  const auto c = corner_at(lattice, i + 3 * di, j + 3 * dj);
  if (!a || !b) return std::nullopt;
  return Prediction{c ? Eigen::Vector2d(3.0 * *a - 3.0 * *b + *c) : Eigen::Vector2d(2.0 * *a - *b),
                    kReachBeyond * spacing_at(lattice, i + di, j + dj)};
}

/// The saddle in a hole; between two corners also the place itself where blur leaves no saddle, for the
/// refinement to decide on.
std::optional<Eigen::Vector2d> corner_in_hole(const Lattice& lattice, const std::vector<Saddle>& saddles,
                                              int i, int j) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (const auto& [di, dj] : {std::pair{1, 0}, {0, 1}}) {
    const auto between = predict_between(lattice, i, j, di, dj);
    if (!between) continue;
    if (const auto px = saddle_near(saddles, between->px, between->reach_px)) return px;
    sum += between->px;
    ++count;
  }
  if (count > 0) return Eigen::Vector2d(sum / count);
  for (const auto& [di, dj] : kWays) {
    const auto beyond = predict_beyond(lattice, i, j, di, dj);
    if (!beyond) continue;
    if (const auto px = saddle_near(saddles, beyond->px, beyond->reach_px)) return px;
  }
  return std::nullopt;
}

/// Holes that may be filled, as a share of the corners seen: more are another thing's.
constexpr double kMostHoles = 0.15;

void fill_holes(Lattice& lattice, const std::vector<Saddle>& saddles, SearchWork& work) {
  const Extent e = extent(lattice);
  const double holes = e.columns * e.rows - static_cast<double>(lattice.size());
  if (holes > kMostHoles * static_cast<double>(lattice.size())) return;
  // Each round may enable the next; no board needs more than its longer side.
  for (int round = 0; round < std::max(e.columns, e.rows); ++round) {
    const std::int64_t places = static_cast<std::int64_t>(e.columns) * e.rows;
    if (!work.spend(places + (places - size_of(lattice)) * size_of(saddles))) return;
    bool any = false;
    for (int j = e.j0; j < e.j0 + e.rows; ++j) {
      for (int i = e.i0; i < e.i0 + e.columns; ++i) {
        if (lattice.count({i, j}) > 0) continue;
        const auto px = corner_in_hole(lattice, saddles, i, j);
        if (!px) continue;
        lattice[{i, j}] = *px;
        any = true;
      }
    }
    if (!any) return;
  }
}

/// Takes off one outer line that is less than half full; whether it did.
bool trim_once(Lattice& lattice) {
  const Extent e = extent(lattice);
  const auto count_column = [&](int i) {
    int n = 0;
    for (int j = e.j0; j < e.j0 + e.rows; ++j) n += static_cast<int>(lattice.count({i, j}));
    return n;
  };
  const auto count_row = [&](int j) {
    int n = 0;
    for (int i = e.i0; i < e.i0 + e.columns; ++i) n += static_cast<int>(lattice.count({i, j}));
    return n;
  };
  const auto drop = [&](auto matches) {
    std::erase_if(lattice, [&](const auto& entry) { return matches(entry.first); });
  };
  for (const int i : {e.i0, e.i0 + e.columns - 1}) {
    if (2 * count_column(i) >= e.rows) continue;
    drop([i](const std::pair<int, int>& place) { return place.first == i; });
    return true;
  }
  for (const int j : {e.j0, e.j0 + e.rows - 1}) {
    if (2 * count_row(j) >= e.columns) continue;
    drop([j](const std::pair<int, int>& place) { return place.second == j; });
    return true;
  }
  return false;
}

/// Adds the line of corners beyond one side when every one of them has a saddle; whether it added any.
bool extend(Lattice& lattice, const std::vector<Saddle>& saddles, int di, int dj, SearchWork& work) {
  const Extent e = extent(lattice);
  const int length = di != 0 ? e.rows : e.columns;
  if (!work.spend(length * size_of(saddles))) return false;
  Lattice added;
  for (int n = 0; n < length; ++n) {
    const int i = di == 0 ? e.i0 + n : (di > 0 ? e.i0 + e.columns : e.i0 - 1);
    const int j = dj == 0 ? e.j0 + n : (dj > 0 ? e.j0 + e.rows : e.j0 - 1);
    const auto prediction = predict_beyond(lattice, i, j, -di, -dj);
    const auto px = prediction ? saddle_near(saddles, prediction->px, prediction->reach_px) : std::nullopt;
    if (!px) return false;
    added[{i, j}] = *px;
  }
  lattice.insert(added.begin(), added.end());
  return !added.empty();
}

/// How far a corner lies from the middle between its neighbours, as a share of their distance; 0 where it has
/// no two opposite ones.
double kink(const Lattice& lattice, const std::pair<int, int>& place) {
  double worst = 0.0;
  for (const auto& [di, dj] : {std::pair{1, 0}, {0, 1}}) {
    const auto a = corner_at(lattice, place.first + di, place.second + dj);
    const auto b = corner_at(lattice, place.first - di, place.second - dj);
    if (!a || !b) continue;
    worst = std::max(worst, (lattice.at(place) - 0.5 * (*a + *b)).norm() / (0.5 * (*a - *b).norm()));
  }
  return worst;
}

/// Takes off the corners that bend the lattice most, worst first: a stain between two corners, joined by
/// chance. What perspective and a lens do between neighbours stays well below the limit.
void take_off_kinks(Lattice& lattice, SearchWork& work) {
  constexpr double kLargestKink = 0.3;
  constexpr std::int64_t kStepsPerKink = 40;  // what ten searches in a map take, in comparisons
  while (work.spend(kStepsPerKink * size_of(lattice))) {
    auto worst = lattice.end();
    double largest = kLargestKink;
    for (auto it = lattice.begin(); it != lattice.end(); ++it) {
      const double own = kink(lattice, it->first);
      if (own > largest) {
        largest = own;
        worst = it;
      }
    }
    if (worst == lattice.end()) return;
    lattice.erase(worst);
  }
}

bool fits_within(const Extent& e, int columns, int rows) {
  return (e.columns <= columns && e.rows <= rows) || (e.columns <= rows && e.rows <= columns);
}

}  // namespace

Extent extent(const Lattice& lattice) {
  if (lattice.empty()) return {};
  int i0 = std::numeric_limits<int>::max(), j0 = i0, i1 = std::numeric_limits<int>::min(), j1 = i1;
  for (const auto& [place, px] : lattice) {
    i0 = std::min(i0, place.first);
    i1 = std::max(i1, place.first);
    j0 = std::min(j0, place.second);
    j1 = std::max(j1, place.second);
  }
  return {i0, j0, i1 - i0 + 1, j1 - j0 + 1};
}

std::vector<Lattice> join_seeds(const SmoothGrey& grey, const std::vector<CornerSeed>& seeds,
                                SearchWork& work) {
  if (!work.spend(4 * size_of(seeds) * size_of(seeds))) return {};
  const Links links = link_seeds(grey, seeds);
  std::vector<bool> taken(seeds.size(), false);
  std::vector<Lattice> out;
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    if (!taken[i]) out.push_back(walk(seeds, links, i, taken));
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Lattice& a, const Lattice& b) { return a.size() > b.size(); });
  return out;
}

Lattice completed(Lattice lattice, const std::vector<Saddle>& saddles, int columns, int rows,
                  SearchWork& work) {
  take_off_kinks(lattice, work);
  while (!lattice.empty() && work.spend(size_of(lattice)) && trim_once(lattice)) {
  }
  fill_holes(lattice, saddles, work);
  bool grown = true;
  while (grown) {
    grown = false;
    for (const auto& [di, dj] : kWays) {
      const Extent e = extent(lattice);
      if (!fits_within({e.i0, e.j0, e.columns + std::abs(di), e.rows + std::abs(dj)}, columns, rows))
        continue;
      grown = extend(lattice, saddles, di, dj, work) || grown;
    }
  }
  return lattice;
}

}  // namespace furrow::target
