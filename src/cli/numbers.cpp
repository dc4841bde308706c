#include "cli/numbers.h"

#include <functional>

#include "furrow/base/text.h"

namespace furrow::cli {
namespace {

CLI::Validator number_that(std::function<bool(double)> fits, const std::string& wanted) {
  const auto complaint = [fits = std::move(fits), wanted](const std::string& text) -> std::string {
    const auto number = base::parse_double(text);
    return number && fits(*number) ? "" : "'" + text + "'; wanted " + wanted;
  };
  return {complaint, "", "number"};
}

}  // namespace

CLI::Validator above_zero() {
  return number_that([](double x) { return x > 0.0; }, "a number above 0");
}

CLI::Validator zero_or_more() {
  return number_that([](double x) { return x >= 0.0; }, "0 or a number above it");
}

CLI::Validator between(double least, double most) {
  return number_that([=](double x) { return x >= least && x <= most; },
                     "a number from " + base::format_double(least) + " to " + base::format_double(most));
}

}  // namespace furrow::cli
