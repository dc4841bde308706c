#pragma once
#include <span>

#include "furrow/stats/estimate.h"

namespace furrow::stats {

/// How two ways of measuring the same thing agree (Bland and Altman, Lancet 1986). Errors are estimate -
/// reference.
struct Agreement {
  int pairs = 0;             ///< pairs in which both were finite
  int left_out = 0;          ///< pairs in which one was not
  double mean_estimate = 0;  ///< mean of the estimates (the thesis's "mean altitude")
  double mean_reference = 0;
  double mean_error = 0;  ///< bias
  double sd_error = 0;    ///< sample standard deviation of the errors; NaN below two pairs
  double rmse = 0;
  double mean_abs_error = 0;
  double max_abs_error = 0;
  double limit_low = 0;  ///< 95 % limits of agreement: bias -+ 1.96 sd
  double limit_high = 0;
};

/// Both spans must have the same length. With no pair every number is NaN.
Agreement agreement(std::span<const double> estimates, std::span<const double> references);

/// Shares of truths within one and two sigma of their estimate; unusable estimates are left out.
struct Coverage {
  int count = 0;
  double within_1_sigma = 0;  ///< 0.683 expected
  double within_2_sigma = 0;  ///< 0.954 expected
};
Coverage coverage(std::span<const Estimate> estimates, std::span<const double> truths);

}  // namespace furrow::stats
