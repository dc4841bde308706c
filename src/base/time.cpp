#include "furrow/base/time.h"

#include <array>
#include <chrono>
#include <cstdio>

#include "furrow/base/text.h"

namespace furrow::base {
namespace {

/// Takes 1 to `most` digits off the front.
std::optional<int> take_number(std::string_view& text, std::size_t most) {
  std::size_t n = 0;
  int value = 0;
  while (n < text.size() && n < most && text[n] >= '0' && text[n] <= '9')
    value = value * 10 + (text[n++] - '0');
  if (n == 0) return std::nullopt;
  text.remove_prefix(n);
  return value;
}

bool take_one_of(std::string_view& text, std::string_view allowed) {
  if (text.empty() || allowed.find(text.front()) == std::string_view::npos) return false;
  text.remove_prefix(1);
  return true;
}

/// ".123" as nanoseconds; digits past the ninth are dropped.
std::optional<Nanoseconds> take_fraction(std::string_view& text) {
  Nanoseconds value = 0;
  Nanoseconds unit = kNanosecondsPerSecond;
  std::size_t n = 0;
  for (; n < text.size() && text[n] >= '0' && text[n] <= '9'; ++n) {
    unit /= 10;
    value += unit * (text[n] - '0');
  }
  if (n == 0) return std::nullopt;
  text.remove_prefix(n);
  return value;
}

}  // namespace

std::optional<Nanoseconds> parse_date_time(std::string_view text) {
  text = trim(text);
  constexpr std::array<std::string_view, 6> kAfter = {"-:./", "-:./", " T", ":", ":", ""};
  constexpr std::array<std::size_t, 6> kDigits = {4, 2, 2, 2, 2, 2};
  std::array<int, 6> field{};
  for (std::size_t i = 0; i < field.size(); ++i) {
    const auto number = take_number(text, kDigits[i]);
    if (!number || (!kAfter[i].empty() && !take_one_of(text, kAfter[i]))) return std::nullopt;
    field[i] = *number;
  }
  Nanoseconds fraction = 0;
  if (take_one_of(text, ".,")) {
    const auto digits = take_fraction(text);
    if (!digits) return std::nullopt;
    fraction = *digits;
  }
  take_one_of(text, "Z");
  using namespace std::chrono;
  const year_month_day date{year{field[0]}, month{static_cast<unsigned>(field[1])},
                            day{static_cast<unsigned>(field[2])}};
  // Years that nanoseconds in 64 bits can hold.
  const bool in_range = field[0] >= 1900 && field[0] <= 2200;
  if (!text.empty() || !in_range || !date.ok() || field[3] > 23 || field[4] > 59 || field[5] > 60)
    return std::nullopt;
  const auto seconds = Nanoseconds{sys_days{date}.time_since_epoch().count()} * 86400 + field[3] * 3600 +
                       field[4] * 60 + field[5];
  return seconds * kNanosecondsPerSecond + fraction;
}

std::string format_utc(Nanoseconds t_utc_ns) {
  using namespace std::chrono;
  const sys_time<milliseconds> time{round<milliseconds>(nanoseconds{t_utc_ns})};
  const auto days_part = floor<days>(time);
  const year_month_day date{days_part};
  const hh_mm_ss clock{time - days_part};
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%04d-%02u-%02uT%02d:%02d:%02d.%03dZ",
                static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                static_cast<unsigned>(date.day()), static_cast<int>(clock.hours().count()),
                static_cast<int>(clock.minutes().count()), static_cast<int>(clock.seconds().count()),
                static_cast<int>(clock.subseconds().count()));
  return buffer.data();
}

}  // namespace furrow::base
