#include "calibration_sampling.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "furrow/base/random.h"
#include "furrow/calib/uncertainty.h"
#include "furrow/stats/robust.h"

using namespace furrow;

namespace {

constexpr int kSolves = 200, kPlaces = 9;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Sums of claimed and sampled squares.
struct Tally {
  double claimed = 0.0, sampled = 0.0;
  double ratio() const { return std::sqrt(claimed / sampled); }
};

struct Tallies {
  Tally fx, cx, near[kPlaces], infinity[kPlaces];
  int solves = 0;
};

Eigen::Vector2d place_px(const Camera& camera, int place) {
  return {(1 + 2 * (place % 3)) * camera.width / 6.0, (1 + 2 * (place / 3)) * camera.height / 6.0};
}

/// Where a point goes that keeps its place among the boards.
std::optional<Eigen::Vector2d> reprojected(const calib::Calibration& exact, const calib::Calibration& sample,
                                           const Eigen::Vector3d& x, bool is_direction) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < exact.views.size(); ++i) {
    if (!exact.views[i].used) continue;
    const Rigid3 drift = sample.views[i].cam_from_board * geom::inverse(exact.views[i].cam_from_board);
    sum += is_direction ? Eigen::Vector3d(drift.rotation * x) : drift * x;
  }
  const auto used =
      std::count_if(exact.views.begin(), exact.views.end(), [](const auto& v) { return v.used; });
  return camera::project(sample.camera, sum / static_cast<double>(used));
}

/// Whether a board's tilt against its line of sight came out the other way round.
bool is_turned_over(const Rigid3& exact, const Rigid3& sample, const Eigen::Vector3d& middle_in_board) {
  const Eigen::Vector3d sight = (exact * middle_in_board).normalized();
  const Eigen::Vector3d normal = exact.rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d other = 2.0 * normal.dot(sight) * sight - normal;
  const Eigen::Vector3d seen = sample.rotation * Eigen::Vector3d::UnitZ();
  return (seen - other).norm() < (seen - normal).norm();
}

void add(const calib::Calibration& exact, const calib::Calibration& sample, double near_m, Tallies& out) {
  ++out.solves;
  out.fx.sampled += std::pow(sample.camera.fx - exact.camera.fx, 2);
  out.fx.claimed += sample.camera.covariance(0, 0);
  out.cx.sampled += std::pow(sample.camera.cx - exact.camera.cx, 2);
  out.cx.claimed += sample.camera.covariance(2, 2);
  for (int place = 0; place < kPlaces; ++place) {
    const Eigen::Vector2d px = place_px(exact.camera, place);
    const auto way = camera::unproject_ray(exact.camera, px);
    if (!way) continue;
    for (const double distance_m : {near_m, kInfinity}) {
      const bool far = distance_m == kInfinity;
      const auto seen = reprojected(exact, sample, far ? *way : Eigen::Vector3d(near_m * *way), far);
      const auto claim = calib::projection_covariance(sample, px, distance_m);
      if (!seen || !claim) continue;
      Tally& tally = far ? out.infinity[place] : out.near[place];
      tally.sampled += (*seen - px).squaredNorm();
      tally.claimed += claim->trace();
    }
  }
}

void print(const char* which, const Tallies& tallies) {
  const auto range = [](const Tally* places) {
    std::vector<double> ratios;
    for (int i = 0; i < kPlaces; ++i) ratios.push_back(places[i].ratio());
    const auto [low, high] = std::minmax_element(ratios.begin(), ratios.end());
    return std::pair(*low, *high);
  };
  const auto near = range(tallies.near), far = range(tallies.infinity);
  std::printf(
      "    claimed / sampled, %s %d solves: fx %.2f cx %.2f, nine places at the boards' distance %.2f to "
      "%.2f, "
      "at infinity %.2f to %.2f\n",
      which, tallies.solves, tallies.fx.ratio(), tallies.cx.ratio(), near.first, near.second, far.first,
      far.second);
}

}  // namespace

void print_sampling(const calib::Calibration& solved, const std::vector<target::BoardDetection>& detections,
                    const calib::CalibrateOptions& options) {
  const auto corners = target::corners_in_board(solved.board);
  const Eigen::Vector3d middle = 0.5 * (corners.front() + corners.back());
  auto exact = detections;
  std::vector<double> depths_m;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    exact[i].found = solved.views[i].used;
    if (!exact[i].found) continue;
    depths_m.push_back(solved.views[i].cam_from_board.translation.norm());
    for (std::size_t c = 0; c < corners.size(); ++c)
      exact[i].corners_px[c] = *camera::project(solved.camera, solved.views[i].cam_from_board * corners[c]);
  }
  const double near_m = stats::median(depths_m);
  base::Random random(1);
  Tallies all, upright;
  for (int trial = 0; trial < kSolves; ++trial) {
    auto noisy = exact;
    for (auto& view : noisy) {
      for (auto& px : view.corners_px)
        px += solved.sigma0_px * Eigen::Vector2d(random.normal(), random.normal());
    }
    const auto sample = calib::calibrate(noisy, solved.board, options);
    if (!sample.ok() || !sample->usable) continue;
    bool turned = false;
    for (std::size_t i = 0; i < exact.size(); ++i)
      turned = turned || (exact[i].found && is_turned_over(solved.views[i].cam_from_board,
                                                           sample->views[i].cam_from_board, middle));
    add(solved, *sample, near_m, all);
    if (!turned) add(solved, *sample, near_m, upright);
  }
  print("all", all);
  if (upright.solves > 1 && upright.solves < all.solves) print("those with no board turned over,", upright);
}
