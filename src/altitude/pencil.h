#pragma once
#include <Eigen/Core>
#include <vector>

#include "furrow/altitude/shot_height.h"
#include "gimbal_prior.h"
#include "row_block.h"

namespace furrow::altitude {

/// Places in the pencil's parameters: angles, then t_k = a + b k and g = half width / height.
inline constexpr int kPencilTheta = 0, kPencilLambda = 1, kPencilPsi = 2, kPencilA = 3, kPencilB = 4,
                     kPencilG = 5, kPencilSize = 6;
using PencilVector = Eigen::Matrix<double, kPencilSize, 1>;

/// Slope at which the pencil `x` has a line (eq. 3.1, 3.8).
template <class T>
T pencil_slope(const T* x, const EdgeLine& line) {
  return x[kPencilA] + x[kPencilB] * static_cast<double>(line.row) + x[kPencilG] * line.reach;
}

/// The pencil of equally spaced lines that the picture shows, before any metres (eq. 3.1).
struct Pencil {
  PencilVector value = PencilVector::Zero();
  Eigen::Matrix<double, kPencilSize, kPencilSize> covariance;
  std::vector<RowBlock> blocks;  ///< every line that lies below the horizon, walls included
  int observations = 0;          ///< samples used
  int rows = 0;                  ///< rows used
  int rows_left_out = 0;         ///< rows that lie where their index says they cannot

  GimbalAngles angles() const { return {value[kPencilTheta], value[kPencilLambda], value[kPencilPsi]}; }
};

/// With `least_rows` 1 a row alone will do where the prior knows the pitch: then b is next to unknown.
/// Errors: as from_spacing but for the prior's, and rows_across, camera_along_horizon.
Result<Pencil> fit_pencil(const RowsOnUnitPlane& rows, const FieldKnowledge& field, const GimbalPrior& gimbal,
                          int least_rows = 2);

}  // namespace furrow::altitude
