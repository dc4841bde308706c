#include "furrow/base/csv.h"

#include <gtest/gtest.h>

#include "furrow/base/random.h"

namespace furrow::base {
namespace {

TEST(Csv, ReadsWhatPeopleHave) {
  const auto table =
      parse_csv("\xEF\xBB\xBFsep=;\r\nname; note\r\na;\"x;\"\"y\"\"\nz\"\r\n\r\nb; 2 \r\n", "t.csv");
  ASSERT_TRUE(table.ok()) << table.error().message();
  EXPECT_EQ(table->columns, (std::vector<std::string>{"name", "note"}));
  ASSERT_EQ(table->rows.size(), 2U);
  EXPECT_EQ(table->rows[0][1], "x;\"y\"\nz");
  EXPECT_EQ(table->rows[1][1], "2");
  EXPECT_EQ(table->lines, (std::vector<int>{3, 6}));
}

TEST(Csv, NamesTheLineOfABadRow) {
  const auto table = parse_csv("a,b\n1,2\n1,2,3\n4,5\n", "t.csv");
  ASSERT_FALSE(table.ok());
  EXPECT_EQ(table.error().message(), "t.csv:3: 3 cells; wanted 2, as in the header.");
}

TEST(Csv, DropsARowThatWasCutShort) {
  const auto table = parse_csv("a,b\n1,2\n3", "t.csv");
  ASSERT_TRUE(table.ok());
  EXPECT_EQ(table->rows.size(), 1U);
  ASSERT_EQ(table->warnings.size(), 1U);
  EXPECT_NE(table->warnings[0].find("t.csv:3"), std::string::npos);
}

TEST(Csv, EmptyAndUnclosedAreErrors) {
  EXPECT_EQ(parse_csv("", "t.csv").error().code, "csv_empty");
  EXPECT_EQ(parse_csv("a,b\n\"1,2\n", "t.csv").error().code, "csv_quote");
}

TEST(Csv, WritesWhatItReads) {
  const CsvTable table{"t.csv", {"a", "b"}, {{"x,\"y\"", ""}, {" blank ", "line\nend"}}, {}, {}};
  const auto again = parse_csv(to_csv(table), "t.csv");
  ASSERT_TRUE(again.ok()) << again.error().message();
  EXPECT_EQ(again->rows, table.rows);
}

TEST(Csv, AnyBytesEndInATableOrAnError) {
  Random random(7);
  const std::string alphabet = "ab,;\"\n\r\t \xEF=1";
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    for (std::uint32_t n = random.below(40); n > 0; --n)
      text += alphabet[random.below(static_cast<std::uint32_t>(alphabet.size()))];
    const auto table = parse_csv(text, "t.csv");
    if (!table.ok()) continue;
    for (const auto& row : table->rows) ASSERT_EQ(row.size(), table->columns.size());
  }
}

}  // namespace
}  // namespace furrow::base
