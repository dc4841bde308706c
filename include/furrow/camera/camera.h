#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "furrow/base/result.h"

namespace furrow::camera {

/// Most intrinsics any model has: fx fy cx cy and 12 coefficients.
inline constexpr int kMaxIntrinsics = 16;

/// Lens models; coefficients in OpenCV's order k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4.
enum class CameraModel {
  pinhole,   ///< no distortion
  opencv4,   ///< k1 k2 p1 p2
  opencv5,   ///< ... k3: Brown-Conrady
  opencv8,   ///< ... k4 k5 k6: rational
  opencv12,  ///< ... s1 s2 s3 s4: thin prism
};

/// Number of distortion coefficients.
int distortion_count(CameraModel model);
/// "pinhole", "opencv4", ... as in files and on the command line.
std::string model_name(CameraModel model);
std::optional<CameraModel> model_from_name(const std::string& name);

/// How a pixel becomes a ray, and back. Pixel (0, 0) is the centre of the top-left pixel; cam: x right, y
/// down, z forward.
struct Camera {
  CameraModel model = CameraModel::pinhole;
  int width = 0;                                  ///< px
  int height = 0;                                 ///< px
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  ///< px
  std::vector<double> distortion;                 ///< distortion_count(model) coefficients
  /// Covariance of (fx, fy, cx, cy, distortion...), in that order; 0 x 0 when unknown.
  Eigen::MatrixXd covariance;
  /// How this camera was made, for reports: "calibrated from 12 views at 1280x720", "scaled from ...".
  std::string provenance;
};

/// fx, fy, cx, cy, distortion... as one vector, and back (the other fields are kept).
Eigen::VectorXd intrinsics(const Camera& camera);
Camera with_intrinsics(Camera camera, const Eigen::VectorXd& values);

/// Errors: camera_invalid (size, focal length not above 0, wrong count of coefficients, not finite), naming
/// the field.
Status validate(const Camera& camera);

/// Pixel of a point; nothing when the point is not in front of the camera (z <= 0) or has no finite pixel (a
/// pole of the rational model). Equal to OpenCV's projectPoints and mrcal's mrcal_project
/// (docs/formulation/camera.md, eq. 1). Beyond the fold of the model (see fold_radius) it returns what the
/// polynomial says, as those two do.
std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& x_in_cam);

/// A pixel with its derivatives.
struct Projection {
  Eigen::Vector2d px;
  Eigen::Matrix<double, 2, 3> d_point;  ///< by x_in_cam
  /// By (fx, fy, cx, cy, distortion...); the storage is inside, so that a solver's inner loop allocates
  /// nothing.
  Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMaxIntrinsics> d_intrinsics;
};
std::optional<Projection> project_with_jacobians(const Camera& camera, const Eigen::Vector3d& x_in_cam);

/// Radius on the unit plane beyond which the radial distortion stops growing, so that two points share a
/// pixel; nothing when the model grows for ever. The tangential and prism terms are left out here;
/// unproject() counts them in.
std::optional<double> fold_radius(const Camera& camera);

/// Point (x, y) on the unit plane z = 1 that projects to `px`, converged to 1e-9 px by Newton's method from
/// the radial inverse; nothing where the model has no inverse: beyond the fold, or at a point whose way from
/// the axis crosses one.
std::optional<Eigen::Vector2d> unproject(const Camera& camera, const Eigen::Vector2d& px);

/// d(unit plane) / d(px) at an unprojected point: the inverse of the 2x2 projection Jacobian.
std::optional<Eigen::Matrix2d> unproject_jacobian(const Camera& camera, const Eigen::Vector2d& on_unit_plane);

/// The same camera for pictures resampled to width x height with the same field of view (pixel centres: cx' =
/// (cx + 0.5) s - 0.5). The covariance follows.
Camera resize_camera(const Camera& camera, int width, int height);

/// `camera` for pictures of another size, or the reason why that cannot be told. Same aspect (within half a
/// pixel): resampled. Another aspect: camera_aspect_differs, since a crop's place is not in the picture.
Result<Camera> carry_camera(const Camera& camera, int width, int height);

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
