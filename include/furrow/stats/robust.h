#pragma once
#include <span>

namespace furrow::stats {

/// Middle value (mean of the two middle ones for an even count); NaN for none. In this header, inputs that
/// are not finite are left out.
double median(std::span<const double> values);

/// 1.4826 x median absolute deviation: equals sigma for Gaussian data. NaN for none.
double mad_sigma(std::span<const double> values);

/// Linear-interpolated quantile, q in [0, 1] (Hyndman and Fan type 7); NaN for none.
double quantile(std::span<const double> values, double q);

double mean(std::span<const double> values);

/// Sample standard deviation (n - 1); NaN for fewer than two.
double standard_deviation(std::span<const double> values);

double root_mean_square(std::span<const double> values);

}  // namespace furrow::stats
