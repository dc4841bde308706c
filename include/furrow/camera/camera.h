#pragma once
#include <array>
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "furrow/base/result.h"

namespace furrow::camera {

/// Most intrinsics that one pixel depends on: fx fy cx cy and the 4 x 4 knots of a cubic patch, two numbers
/// each.
inline constexpr int kMaxActiveIntrinsics = 36;

/// Lens models; OpenCV's coefficients in its order k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4.
enum class CameraModel {
  pinhole,   ///< no distortion
  opencv4,   ///< k1 k2 p1 p2
  opencv5,   ///< ... k3: Brown-Conrady
  opencv8,   ///< ... k4 k5 k6: rational
  opencv12,  ///< ... s1 s2 s3 s4: thin prism
  fisheye,   ///< k1 k2 k3 k4 on the angle: Kannala and Brandt (2006), OpenCV's fisheye, ROS's equidistant
  stereographic,          ///< no distortion; mrcal's LENSMODEL_STEREOGRAPHIC
  latlon,                 ///< no distortion; angles about the x axis, mrcal's LENSMODEL_LATLON
  splined_stereographic,  ///< a grid of knots over the stereographic plane; mrcal's
                          ///< LENSMODEL_SPLINED_STEREOGRAPHIC
};

/// The grid of a splined model, as mrcal has it: knots evenly spaced over the stereographic plane, fov_x_deg
/// across with one spare interval on each side (cubic) or half of one (quadratic).
struct SplineGrid {
  int order = 3;              ///< 3 cubic, 2 quadratic
  int columns = 0, rows = 0;  ///< knots; mrcal's Nx and Ny
  int fov_x_deg = 0;          ///< what the knots span across, 1 to 359
};

/// Number of distortion coefficients; `grid` counts for the splined model only.
int distortion_count(CameraModel model, const SplineGrid& grid = {});
/// "pinhole", "opencv4", ... as in files and on the command line.
std::string model_name(CameraModel model);
std::optional<CameraModel> model_from_name(const std::string& name);
/// All names, for messages: "pinhole, opencv4, ...".
std::string model_names();

/// How a pixel becomes a ray, and back. Pixel (0, 0) is the centre of the top-left pixel; cam: x right, y
/// down, z forward.
struct Camera {
  CameraModel model = CameraModel::pinhole;
  int width = 0;                                  ///< px
  int height = 0;                                 ///< px
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  ///< px
  /// distortion_count() coefficients; a splined model's are (x, y) of the knots, row by row.
  std::vector<double> distortion;
  SplineGrid spline;  ///< of the splined model
  /// Covariance of (fx, fy, cx, cy, distortion...), in that order; 0 x 0 when unknown.
  Eigen::MatrixXd covariance;
  /// How this camera was made, for reports: "calibrated from 12 views at 1280x720", "scaled from ...".
  std::string provenance;
};

/// fx, fy, cx, cy, distortion... as one vector, and back (the other fields are kept).
Eigen::VectorXd intrinsics(const Camera& camera);
Camera with_intrinsics(Camera camera, const Eigen::VectorXd& values);

/// "fx", "fy", "cx", "cy", "k1", ...; a splined model's are "x(i,j)", "y(i,j)" for column i, row j of its
/// knots.
std::vector<std::string> intrinsic_names(const Camera& camera);

/// Errors: camera_invalid (size, focal length not above 0, wrong count of coefficients, not finite), naming
/// the field.
Status validate(const Camera& camera);

/// Pixel of a point; nothing when the point has no finite pixel (a pole of the rational model) or, for the
/// models on the unit plane (pinhole and OpenCV's), is not in front of the camera (z <= 0). The models of
/// wide lenses see beyond 90 degrees, all but the point straight behind. Equal to OpenCV's projectPoints and
/// fisheye::projectPoints and to mrcal's mrcal_project (docs/formulation/camera.md, eq. 1 and 6 to 9). Beyond
/// the fold of the model (see fold_radius) it returns what the polynomial says, as those do.
std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& x_in_cam);

/// A pixel with its derivatives.
struct Projection {
  Eigen::Vector2d px;
  Eigen::Matrix<double, 2, 3> d_point;  ///< by x_in_cam
  /// By those of (fx, fy, cx, cy, distortion...) that this pixel depends on: all of them, but of a splined
  /// model the knots nearby only. The storage is inside, so that a solver's inner loop allocates nothing.
  Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMaxActiveIntrinsics> d_intrinsics;
  /// Place of each column of d_intrinsics in intrinsics().
  std::array<int, kMaxActiveIntrinsics> place;

  /// d_intrinsics as a matrix over all `count` intrinsics.
  Eigen::Matrix2Xd by_all_intrinsics(Eigen::Index count) const;
};
std::optional<Projection> project_with_jacobians(const Camera& camera, const Eigen::Vector3d& x_in_cam);

/// First column and row of the knots that bear on a place of a splined model.
struct SplinePatch {
  int column = 0, row = 0;
  bool operator==(const SplinePatch&) const = default;
};
/// The patch that a point falls into; nothing straight behind. The camera must be a splined one.
std::optional<SplinePatch> spline_patch(const Camera& camera, const Eigen::Vector3d& x_in_cam);
/// As project_with_jacobians(), but by this patch, continued where the point lies outside it: a solver whose
/// unknowns are a patch's knots must not see others. Equal inside the patch; two patches meet with equal
/// curvature.
std::optional<Projection> project_by_patch(const Camera& camera, const Eigen::Vector3d& x_in_cam,
                                           const SplinePatch& patch);

/// Radius on the unit plane beyond which the radial distortion stops growing, so that two points share a
/// pixel; nothing when the model grows for ever (a fisheye's: up to 90 degrees) and for a splined model,
/// which is not radial. The tangential and prism terms are left out here; unproject() counts them in.
std::optional<double> fold_radius(const Camera& camera);

/// Unit vector in cam that projects to `px`, converged to 1e-9 px; nothing where the model has no inverse
/// (see unproject()). Wide lenses have rays with z <= 0.
std::optional<Eigen::Vector3d> unproject_ray(const Camera& camera, const Eigen::Vector2d& px);

/// Point (x, y) on the unit plane z = 1 that projects to `px`, converged to 1e-9 px by Newton's method from
/// the radial inverse; nothing where the model has no inverse: beyond the fold, or at a point whose way from
/// the axis crosses one; nor at 90 degrees and more from the axis.
std::optional<Eigen::Vector2d> unproject(const Camera& camera, const Eigen::Vector2d& px);

/// d(unit plane) / d(px) at an unprojected point: the inverse of the 2x2 projection Jacobian.
std::optional<Eigen::Matrix2d> unproject_jacobian(const Camera& camera, const Eigen::Vector2d& on_unit_plane);

/// The same camera for pictures resampled to width x height with the same field of view (pixel centres: cx' =
/// (cx + 0.5) s - 0.5). The covariance follows.
Camera resize_camera(const Camera& camera, int width, int height);

/// `camera` for pictures of another size, or the reason why that cannot be told. Same aspect (within half a
/// pixel): resampled. Another aspect: camera_aspect_differs, since a crop's place is not in the picture.
Result<Camera> carry_camera(const Camera& camera, int width, int height);

/// Pixels per unit of tan(angle) on the optical axis, across and down: fx and fy, but for a splined model
/// what its knots make of them. The focal length that a height goes with.
Eigen::Vector2d focal_on_axis_px(const Camera& camera);

/// f_px x sensor width / image width, the thesis's section 2.
double focal_length_mm(double focal_px, double sensor_width_mm, int image_width_px);

/// Fields of view of an ideal lens, radians.
struct FieldOfView {
  double horizontal_rad, vertical_rad, diagonal_rad;
};
FieldOfView field_of_view(double sensor_width_mm, double sensor_height_mm, double focal_mm);

}  // namespace furrow::camera

namespace furrow {
using camera::Camera;
}
