#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace furrow::base {

/// `text` without blanks, tabs and line ends at both ends.
std::string_view trim(std::string_view text);

/// Parts between `separator`s, untrimmed; "" gives one empty part.
std::vector<std::string_view> split(std::string_view text, char separator);

/// ASCII lower case.
std::string to_lower(std::string_view text);

/// A whole decimal number, blanks around it and a leading '+' allowed, '.' as the point whatever the locale;
/// nothing for anything else, "nan" and "inf" included.
std::optional<double> parse_double(std::string_view text);

/// A whole decimal integer, blanks and a leading '+' allowed.
std::optional<std::int64_t> parse_int(std::string_view text);

/// Shortest text that reads back to the same double; "nan", "inf" for those. Locale-free.
std::string format_double(double value);

/// Fixed notation with `decimals` digits after the point; never "-0.00".
std::string format_fixed(double value, int decimals);

/// The candidate with the fewest edits to `name`, if it is near enough to be a slip of the pen (2 edits, or a
/// third of the length); nothing otherwise.
std::optional<std::string> nearest_name(std::string_view name, std::span<const std::string> candidates);

/// Order in which a person lists files: digits compare as numbers ("left2" before "left10").
bool natural_less(std::string_view a, std::string_view b);

}  // namespace furrow::base
