#include "furrow/base/text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "furrow/base/time.h"

namespace furrow::base {
namespace {

TEST(Text, ParsesWholeNumbersOnly) {
  EXPECT_EQ(parse_double(" +2.50 "), 2.5);
  EXPECT_EQ(parse_double("-1e3"), -1000.0);
  for (const char* bad : {"", " ", "1,5", "1.5m", "nan", "inf", "+-1", "++1", "0x10"}) {
    EXPECT_FALSE(parse_double(bad).has_value()) << bad;
  }
  EXPECT_EQ(parse_int("+42"), 42);
  EXPECT_FALSE(parse_int("4.2").has_value());
}

TEST(Text, FormatsReadBackTheSame) {
  for (const double value : {0.1, 1.0 / 3.0, -1e-300, 12345678.9})
    EXPECT_EQ(parse_double(format_double(value)), value);
  EXPECT_EQ(format_fixed(-0.0004, 2), "0.00");
  EXPECT_EQ(format_fixed(-0.006, 2), "-0.01");
  EXPECT_EQ(format_fixed(std::numeric_limits<double>::quiet_NaN(), 2), "nan");
}

TEST(Text, NearestNameFindsSlipsOfThePen) {
  const std::vector<std::string> names = {"spacing_m", "height_m", "half_width_m"};
  EXPECT_EQ(nearest_name("spaceing_m", names), "spacing_m");
  EXPECT_EQ(nearest_name("heigth_m", names), "height_m");
  EXPECT_FALSE(nearest_name("colour", names).has_value());
}

TEST(Text, NaturalOrderIsTotal) {
  std::vector<std::string> names = {"left10.jpg", "left2.jpg", "left1.jpg", "left01.jpg"};
  std::sort(names.begin(), names.end(), natural_less);
  const std::vector<std::string> wanted = {"left01.jpg", "left1.jpg", "left2.jpg", "left10.jpg"};
  EXPECT_EQ(names, wanted);
}

TEST(Time, ReadsAndWritesDates) {
  // 2023-12-22 19:56:32 UTC is 1703274992 s (date -u -d ... +%s).
  EXPECT_EQ(parse_date_time("2023-12-22 19:56:32"), 1703274992LL * kNanosecondsPerSecond);
  EXPECT_EQ(parse_date_time("2023:12:22 19:56:32.5"), 1703274992LL * kNanosecondsPerSecond + 500'000'000);
  EXPECT_EQ(format_utc(*parse_date_time("2024-02-29T23:59:59.9996Z")), "2024-03-01T00:00:00.000Z");
  for (const char* bad :
       {"2023-02-29 00:00:00", "2023-12-22", "", "2023-12-22 24:00:00", "9999-01-01 00:00:00"}) {
    EXPECT_FALSE(parse_date_time(bad).has_value()) << bad;
  }
}

}  // namespace
}  // namespace furrow::base
