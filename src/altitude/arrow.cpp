#include "arrow.h"

#include <Eigen/Cholesky>

namespace furrow::altitude {
namespace {

using Factor = Eigen::LLT<Eigen::MatrixXd>;

struct Sweep {
  std::vector<Eigen::MatrixXd> pivots;  ///< each shot's block after the shots before it are eliminated
  std::vector<Eigen::MatrixXd> border;  ///< the border, likewise
};

std::optional<Eigen::MatrixXd> inverse_of(const Eigen::MatrixXd& m) {
  const Factor factor(m);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return factor.solve(Eigen::MatrixXd::Identity(m.rows(), m.cols()));
}

/// Eliminates shots from first to last (eq. 9.4).
std::optional<Sweep> forward(const ArrowMatrix& a) {
  Sweep sweep{a.diagonal, a.border};
  for (std::size_t i = 0; i + 1 < a.diagonal.size(); ++i) {
    const Factor factor(sweep.pivots[i]);
    if (factor.info() != Eigen::Success) return std::nullopt;
    const Eigen::MatrixXd gain = factor.solve(a.next[i]);
    sweep.pivots[i + 1] -= a.next[i].transpose() * gain;
    sweep.border[i + 1] -= gain.transpose() * sweep.border[i];
  }
  return sweep;
}

/// Pivots of the elimination from last to first; none when the matrix is not positive definite.
std::vector<Eigen::MatrixXd> backward_pivots(const ArrowMatrix& a) {
  std::vector<Eigen::MatrixXd> pivots = a.diagonal;
  for (std::size_t i = a.diagonal.size(); i-- > 1;) {
    const Factor factor(pivots[i]);
    if (factor.info() != Eigen::Success) return {};
    pivots[i - 1] -= a.next[i - 1] * factor.solve(a.next[i - 1].transpose());
  }
  return pivots;
}

/// A^-1 times the border, by back substitution.
std::vector<Eigen::MatrixXd> solve_border(const ArrowMatrix& a, const Sweep& sweep) {
  std::vector<Eigen::MatrixXd> solution(a.diagonal.size());
  for (std::size_t i = a.diagonal.size(); i-- > 0;) {
    Eigen::MatrixXd right = sweep.border[i];
    if (i + 1 < a.diagonal.size()) right -= a.next[i] * solution[i + 1];
    solution[i] = sweep.pivots[i].llt().solve(right);
  }
  return solution;
}

}  // namespace

std::optional<ArrowInverse> invert(const ArrowMatrix& a) {
  const auto sweep = forward(a);
  const auto backward = backward_pivots(a);
  if (!sweep || backward.empty()) return std::nullopt;
  const std::vector<Eigen::MatrixXd> solution = solve_border(a, *sweep);
  Eigen::MatrixXd schur = a.corner;
  for (std::size_t i = 0; i < a.diagonal.size(); ++i) schur -= a.border[i].transpose() * solution[i];
  const auto corner = inverse_of(schur / a.repeats + a.corner_prior);
  if (!corner) return std::nullopt;
  ArrowInverse inverse;
  inverse.corner = *corner;
  for (std::size_t i = 0; i < a.diagonal.size(); ++i) {
    const auto own = inverse_of(sweep->pivots[i] + backward[i] - a.diagonal[i]);
    if (!own) return std::nullopt;
    inverse.border.push_back(-solution[i] * *corner);
    inverse.diagonal.push_back(*own + solution[i] * *corner * solution[i].transpose());
  }
  return inverse;
}

}  // namespace furrow::altitude
