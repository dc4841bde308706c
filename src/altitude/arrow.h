#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

namespace furrow::altitude {

/// Normal matrix of a flight: one small block for each shot, a tie to the next shot's height, and a border
/// that all shots share (docs/formulation/altitude.md, section 9).
struct ArrowMatrix {
  std::vector<Eigen::MatrixXd> diagonal;  ///< n x n for each shot
  std::vector<Eigen::MatrixXd>
      next;  ///< n x n: this shot's rows, the next shot's columns; one fewer than shots
  std::vector<Eigen::MatrixXd> border;  ///< n x m for each shot
  Eigen::MatrixXd corner;               ///< m x m
  Eigen::MatrixXd corner_prior;         ///< m x m, known beside the shots
  /// So many shots tell the border's quantities no more than one: what they see is the same.
  double repeats = 1.0;
};

/// The parts of its inverse that a flight reports.
struct ArrowInverse {
  std::vector<Eigen::MatrixXd> diagonal;  ///< n x n for each shot
  std::vector<Eigen::MatrixXd> border;    ///< n x m for each shot
  Eigen::MatrixXd corner;                 ///< m x m
};

/// With repeats r the border's information from the shots, after they are eliminated, counts 1/r. Nothing
/// when the matrix is not positive definite. Linear in the number of shots.
std::optional<ArrowInverse> invert(const ArrowMatrix& matrix);

}  // namespace furrow::altitude
