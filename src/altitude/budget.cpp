#include "budget.h"

#include <algorithm>
#include <cmath>

namespace furrow::altitude {

namespace {

double signed_square(double x) {
  return x * std::abs(x);
}

double signed_root(double x) {
  return std::copysign(std::sqrt(std::abs(x)), x);
}

}  // namespace

void add_share(std::vector<SigmaShare>& shares, const std::string& cause, double sigma_m) {
  const auto found = std::find_if(shares.begin(), shares.end(),
                                  [&cause](const SigmaShare& share) { return share.cause == cause; });
  if (found == shares.end()) {
    shares.push_back({cause, sigma_m});
  } else {
    found->sigma_m = signed_root(signed_square(found->sigma_m) + signed_square(sigma_m));
  }
}

void add_row_shares(std::vector<SigmaShare>& shares, const ShotSystem& system, const Eigen::RowVectorXd& gain,
                    double noise_scale2) {
  double picture = 0.0, plants = 0.0;
  Eigen::Index at = 0;
  for (const WeightedBlock& block : system.blocks) {
    const Eigen::Index n = block.rows.residuals();
    const Eigen::RowVectorXd raw = gain.segment(at, n) * block.whitener;
    picture += (raw * block.covariance.picture).dot(raw) * noise_scale2;
    plants += (raw * block.covariance.plants).dot(raw) * noise_scale2;
    at += n;
  }
  add_share(shares, "picture", std::sqrt(picture));
  add_share(shares, "plants", std::sqrt(plants));
}

void add_camera_shares(std::vector<SigmaShare>& shares, const Eigen::RowVectorXd& by_intrinsics,
                       const Camera& camera) {
  constexpr Eigen::Index kLinear = 4;  // fx, fy, cx, cy
  const Eigen::Index rest = by_intrinsics.size() - kLinear;
  const double linear = (by_intrinsics.head(kLinear) * camera.covariance.topRows(kLinear)).dot(by_intrinsics);
  const double distortion =
      rest > 0 ? (by_intrinsics.tail(rest) * camera.covariance.bottomRows(rest)).dot(by_intrinsics) : 0.0;
  add_share(shares, "focal", signed_root(linear));
  add_share(shares, "distortion", signed_root(distortion));
}

}  // namespace furrow::altitude
