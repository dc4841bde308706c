#pragma once
#include <CLI/CLI.hpp>

namespace furrow::cli {

/// Checks of numbers on the command line. CLI11's own take "nan" for a number above 0, and name the largest
/// double there is, 309 digits, as what they wanted.
CLI::Validator above_zero();
CLI::Validator zero_or_more();
CLI::Validator between(double least, double most);

}  // namespace furrow::cli
