#include "camera/mrcal_witness.h"

#include <cstdlib>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wconversion"
extern "C" {
#include <mrcal/mrcal.h>
}
#pragma GCC diagnostic pop

namespace furrow::camera {

std::optional<Eigen::Vector2d> mrcal_projection(const std::string& lensmodel,
                                                const Eigen::VectorXd& intrinsics,
                                                const Eigen::Vector3d& x_in_cam) {
  mrcal_lensmodel_t model;
  if (!mrcal_lensmodel_from_name(&model, lensmodel.c_str())) return std::nullopt;
  mrcal_point3_t p;
  p.x = x_in_cam.x();
  p.y = x_in_cam.y();
  p.z = x_in_cam.z();
  mrcal_point2_t q;
  if (!mrcal_project(&q, nullptr, nullptr, &p, 1, &model, intrinsics.data())) return std::nullopt;
  return Eigen::Vector2d(q.x, q.y);
}

Eigen::VectorXd mrcal_reads(const std::string& cameramodel, int& width, int& height) {
  mrcal_cameramodel_t* model =
      mrcal_read_cameramodel_string(cameramodel.c_str(), static_cast<int>(cameramodel.size()));
  if (model == nullptr) return {};
  const int count = mrcal_lensmodel_num_params(&model->lensmodel);
  Eigen::VectorXd out = Eigen::Map<Eigen::VectorXd>(model->intrinsics, count);
  width = static_cast<int>(model->imagersize[0]);
  height = static_cast<int>(model->imagersize[1]);
  mrcal_free_cameramodel(&model);
  return out;
}

}  // namespace furrow::camera
