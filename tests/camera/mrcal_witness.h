#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>

namespace furrow::camera {

/// mrcal_project() of one point. Kept behind this file: libmrcal's ABI changes between releases.
std::optional<Eigen::Vector2d> mrcal_projection(const std::string& lensmodel,
                                                const Eigen::VectorXd& intrinsics,
                                                const Eigen::Vector3d& x_in_cam);

/// Intrinsics as mrcal's own reader finds them in a cameramodel's text; empty when it refuses.
Eigen::VectorXd mrcal_reads(const std::string& cameramodel, int& width, int& height);

}  // namespace furrow::camera
