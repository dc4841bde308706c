#include "furrow/calib/views.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

#include "calib/view_information.h"
#include "furrow/base/text.h"
#include "furrow/camera/compare.h"

namespace furrow::calib {
namespace {

using base::format_fixed;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kDegree = std::numbers::pi / 180.0;

Eigen::Vector2d warp_of(const Calibration& calibration) {
  if (calibration.board_warp_x_m.observations == 0) return Eigen::Vector2d::Zero();
  return {calibration.board_warp_x_m.value, calibration.board_warp_y_m.value};
}

/// What is known of a lens: variances of two things and how a change of the covariance changes them.
class Knowledge {
 public:
  explicit Knowledge(const Calibration& calibration) : covariance_(calibration.lens_and_board_covariance) {
    const Eigen::MatrixXd picture = camera::picture_change(calibration.camera);
    const Eigen::Index n = picture.cols();
    focal_.setZero(covariance_.rows());
    focal_.head(n) = focal_by_intrinsics(calibration.camera);
    picture_.setZero(picture.rows(), covariance_.rows());
    picture_.leftCols(n) =
        picture * std::sqrt(2.0 / static_cast<double>(std::max<Eigen::Index>(1, picture.rows())));
    update();
  }
  const Eigen::MatrixXd& covariance() const { return covariance_; }
  double focal_variance() const { return focal_.dot(focal_side_); }
  double picture_variance() const { return (picture_side_ * picture_.transpose()).trace(); }

  /// How much smaller the two variances are by C_s E C_s'.
  struct Change {
    double focal, picture;
  };
  Change change(const ViewInformation& view, const Eigen::MatrixXd& step) const {
    Eigen::VectorXd own(step.rows());
    for (Eigen::Index i = 0; i < own.size(); ++i)
      own[i] = focal_side_[view.place[static_cast<std::size_t>(i)]];
    return {own.dot(step * own), step.cwiseProduct(part_of(both_sides_, view.place)).sum()};
  }
  void add(const ViewInformation& view, const Eigen::MatrixXd& step) {
    Eigen::MatrixXd own(covariance_.rows(), step.rows());
    for (Eigen::Index i = 0; i < step.rows(); ++i)
      own.col(i) = covariance_.col(view.place[static_cast<std::size_t>(i)]);
    covariance_ -= own * step * own.transpose();
    covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
    update();
  }

 private:
  void update() {
    focal_side_ = covariance_ * focal_;
    picture_side_ = picture_ * covariance_;
    both_sides_ = picture_side_.transpose() * picture_side_;
  }
  Eigen::VectorXd focal_, focal_side_;
  Eigen::MatrixXd picture_, picture_side_, both_sides_, covariance_;
};

bool has_covariance(const Calibration& calibration) {
  return calibration.lens_and_board_covariance.rows() ==
             camera::intrinsics(calibration.camera).size() + kBoardTerms &&
         calibration.sigma0_px > 0.0;
}

std::vector<int> ids_of(const View& view) {
  if (!view.corner_ids.empty()) return view.corner_ids;
  std::vector<int> out(view.observed_px.size());
  std::iota(out.begin(), out.end(), 0);
  return out;
}

ViewGain gain_of(const Calibration& calibration, const Knowledge& all, const View& view) {
  std::vector<double> weight = view.weight;
  if (weight.empty()) weight.assign(view.observed_px.size(), 1.0);
  for (double& w : weight) w /= calibration.sigma0_px;
  const auto information = view_information(calibration.camera, calibration.board, warp_of(calibration),
                                            pose_vector(view.cam_from_board), ids_of(view), weight);
  if (!information) return {view.image, kNan, kNan};
  const auto step = information_step(*information, all.covariance(), -1.0);
  if (!step) return {view.image, kInfinity, kInfinity};
  const Knowledge::Change change = all.change(*information, *step);
  return {view.image, std::sqrt(1.0 + change.focal / all.focal_variance()) - 1.0,
          std::sqrt(1.0 + change.picture / all.picture_variance()) - 1.0};
}

/// A pose to try.
struct Candidate {
  NextView view;
  ViewInformation information;
};

/// Corners that stand for all of a board's: at most five by five of them, evenly spread.
std::vector<int> some_corners(const target::BoardSpec& board) {
  constexpr int kMost = 5;
  const int columns = std::min(kMost, board.corners_x), rows = std::min(kMost, board.corners_y);
  std::vector<int> out;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int x = i * (board.corners_x - 1) / (columns - 1), y = j * (board.corners_y - 1) / (rows - 1);
      out.push_back(y * board.corners_x + x);
    }
  }
  return out;
}

Eigen::Vector3d middle_of(const target::BoardSpec& board) {
  return 0.5 * target::corner_in_board(board, board.corners_x - 1, board.corners_y - 1);
}

/// Whether all squares of a board show, and are large enough for their corners to be found.
bool shows_whole(const Camera& camera, const target::BoardSpec& board, const Rigid3& cam_from_board) {
  constexpr double kSmallestSquarePx = 12.0;
  const double shown_px = 0.01 * camera.width;
  Eigen::Vector2d last;
  for (int j = -1; j <= board.corners_y; ++j) {
    for (int i = -1; i <= board.corners_x; ++i) {
      const Eigen::Vector3d x(i * board.square_m, j * board.square_m * board.aspect, 0.0);
      const auto px = camera::project(camera, cam_from_board * x);
      if (!px || px->x() < shown_px || px->y() < shown_px || px->x() > camera.width - 1 - shown_px ||
          px->y() > camera.height - 1 - shown_px)
        return false;
      if (i >= 0 && (*px - last).norm() < kSmallestSquarePx) return false;
      last = *px;
    }
  }
  return true;
}

Rigid3 held(const target::BoardSpec& board, const Eigen::Vector3d& way, const NextView& how) {
  Rigid3 out;
  const auto turn = [](double rad, const Eigen::Vector3d& axis) { return Eigen::AngleAxisd(rad, axis); };
  out.rotation = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), way) *
                 turn(how.tilt_x_rad, Eigen::Vector3d::UnitX()) *
                 turn(how.tilt_y_rad, Eigen::Vector3d::UnitY()) *
                 turn(how.upright ? 0.5 * std::numbers::pi : 0.0, Eigen::Vector3d::UnitZ());
  out.translation = how.distance_m * way - out.rotation * middle_of(board);
  return out;
}

/// Nearest and farthest board of a calibration, m.
std::pair<double, double> distances_m(const Calibration& calibration) {
  double nearest = kInfinity, farthest = 0.0;
  for (const View& view : calibration.views) {
    if (!view.used) continue;
    const double distance = (view.cam_from_board * middle_of(calibration.board)).norm();
    nearest = std::min(nearest, distance);
    farthest = std::max(farthest, distance);
  }
  return {nearest, farthest};
}

/// Poses of one place and size: all tilts in which the whole board shows.
void add_tilted(const Calibration& calibration, const Eigen::Vector3d& way, const NextView& at,
                std::vector<Candidate>& out) {
  const std::vector<int> ids = some_corners(calibration.board);
  const double all = calibration.board.corners_x * calibration.board.corners_y;
  const std::vector<double> weight(ids.size(),
                                   std::sqrt(all / static_cast<double>(ids.size())) / calibration.sigma0_px);
  for (const double tilt_x_deg : {0.0, 25.0, -25.0, 45.0, -45.0}) {
    for (const double tilt_y_deg : {0.0, 25.0, -25.0, 45.0, -45.0}) {
      for (const bool upright : {false, true}) {
        Candidate candidate{at, {}};
        candidate.view.tilt_x_rad = tilt_x_deg * kDegree;
        candidate.view.tilt_y_rad = tilt_y_deg * kDegree;
        candidate.view.upright = upright;
        candidate.view.cam_from_board = held(calibration.board, way, candidate.view);
        if (!shows_whole(calibration.camera, calibration.board, candidate.view.cam_from_board)) continue;
        auto information = view_information(calibration.camera, calibration.board, warp_of(calibration),
                                            pose_vector(candidate.view.cam_from_board), ids, weight);
        if (!information) continue;
        candidate.information = std::move(*information);
        out.push_back(std::move(candidate));
      }
    }
  }
}

std::vector<Candidate> candidates(const Calibration& calibration) {
  const Camera& camera = calibration.camera;
  const target::BoardSpec& board = calibration.board;
  const auto [nearest_m, farthest_m] = distances_m(calibration);
  const double wide_m = (std::max(board.corners_x, board.corners_y) + 1) * board.square_m,
               focal_px = camera::focal_on_axis_px(camera).mean();
  std::vector<Candidate> out;
  for (const double share : {0.2, 0.3, 0.45, 0.65, 0.9}) {
    NextView at;
    at.distance_m = wide_m * focal_px / (share * camera.width);
    if (at.distance_m < 0.5 * nearest_m || at.distance_m > 2.0 * farthest_m) continue;
    // Its middle at these shares of the room that a board of this size leaves.
    for (const double down : {-0.85, -0.4, 0.0, 0.4, 0.85}) {
      for (const double right : {-0.85, -0.4, 0.0, 0.4, 0.85}) {
        const double half = 0.5 * share * camera.width;
        at.middle_px = {0.5 * (camera.width - 1) + right * std::max(0.0, 0.5 * camera.width - half),
                        0.5 * (camera.height - 1) + down * std::max(0.0, 0.5 * camera.height - 0.7 * half)};
        const auto way = camera::unproject_ray(camera, at.middle_px);
        if (way) add_tilted(calibration, *way, at, out);
      }
    }
  }
  return out;
}

std::string tilt_words(double rad, const char* axis, const char* above, const char* below) {
  if (rad == 0.0) return "";
  return std::string("about ") + axis + " by " + format_fixed(std::abs(rad) / kDegree, 0) + " deg (its " +
         (rad > 0.0 ? above : below) + " towards the camera)";
}

std::string how_to_hold(const Camera& camera, const NextView& view) {
  std::string out = "hold the board" + std::string(view.upright ? ", turned a quarter," : "") + " " +
                    format_fixed(view.distance_m, 2) + " m away in the " +
                    part_of_picture(camera, view.middle_px) + " of the picture, facing the camera";
  const std::string about_x = tilt_words(view.tilt_x_rad, "x", "top", "bottom"),
                    about_y = tilt_words(view.tilt_y_rad, "y", "right side", "left side");
  if (!about_x.empty() || !about_y.empty()) out += ", then tilted ";
  return out + about_x + (about_x.empty() || about_y.empty() ? "" : " and ") + about_y;
}

/// A view with what it makes of two sigmas.
NextView with_words(NextView view, const Calibration& calibration, const Knowledge& before,
                    const Knowledge& after) {
  constexpr double kPercent = 100.0;
  const double focal_px = camera::focal_on_axis_px(calibration.camera).mean();
  const auto focal_percent = [&](const Knowledge& one) {
    return kPercent * std::sqrt(one.focal_variance()) / focal_px;
  };
  view.picture_sigma_px = std::sqrt(after.picture_variance());
  view.focal_percent = focal_percent(after);
  view.how_to_hold = how_to_hold(calibration.camera, view);
  view.sentence = view.how_to_hold + ": the picture's sigma goes from " +
                  format_fixed(std::sqrt(before.picture_variance()), 3) + " to " +
                  format_fixed(view.picture_sigma_px, 3) + " px and the focal length's from " +
                  format_fixed(focal_percent(before), 3) + " to " + format_fixed(view.focal_percent, 3) +
                  " %";
  return view;
}

/// Place of the candidate that lowers the picture's sigma most; nothing where none does.
std::optional<std::size_t> best_of(const std::vector<Candidate>& all, const Knowledge& known,
                                   Eigen::MatrixXd& best_step) {
  std::optional<std::size_t> best;
  double most = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    auto step = information_step(all[i].information, known.covariance(), 1.0);
    const double gain = step ? known.change(all[i].information, *step).picture : 0.0;
    if (!(gain > most)) continue;
    best = i;
    best_step = std::move(*step);
    most = gain;
  }
  return best;
}

}  // namespace

std::string part_of_picture(const Camera& camera, const Eigen::Vector2d& px) {
  const auto third = [](double at, int size) {
    return std::clamp(static_cast<int>(3.0 * (at + 0.5) / size), 0, 2);
  };
  const int column = third(px.x(), camera.width), row = third(px.y(), camera.height);
  if (row == 1) return column == 0 ? "left" : column == 1 ? "middle" : "right";
  return std::string(row == 0 ? "upper " : "lower ") + (column == 0   ? "left"
                                                        : column == 1 ? "middle"
                                                                      : "right");
}

std::vector<ViewGain> information_gain(const Calibration& calibration) {
  std::vector<ViewGain> out;
  for (const View& view : calibration.views) out.push_back({view.image, kNan, kNan});
  if (!has_covariance(calibration)) return out;
  const Knowledge all(calibration);
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (calibration.views[i].used) out[i] = gain_of(calibration, all, calibration.views[i]);
  }
  return out;
}

std::vector<NextView> next_views(const Calibration& calibration, int count) {
  std::vector<NextView> out;
  if (!has_covariance(calibration)) return out;
  const std::vector<Candidate> all = candidates(calibration);
  Knowledge known(calibration);
  while (static_cast<int>(out.size()) < count) {
    Eigen::MatrixXd step;
    const auto best = best_of(all, known, step);
    if (!best) break;
    const Knowledge before = known;
    known.add(all[*best].information, step);
    out.push_back(with_words(all[*best].view, calibration, before, known));
  }
  return out;
}

}  // namespace furrow::calib
