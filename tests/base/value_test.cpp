#include "furrow/base/value.h"

#include <gtest/gtest.h>

#include <limits>

#include "furrow/base/fields.h"
#include "furrow/base/random.h"

namespace furrow::base {
namespace {

TEST(Yaml, KeepsKindsAndLines) {
  const auto value =
      parse_yaml("name: \"3\"\nrows:\n  spacing_m: 3\n  on: true\nlist: [1, 2.5, x]\n", "p.yaml");
  ASSERT_TRUE(value.ok()) << value.error().message();
  EXPECT_EQ(*value->find("name")->string(), "3");
  const Value* rows = value->find("rows");
  EXPECT_EQ(rows->find("spacing_m")->integer(), 3);
  EXPECT_EQ(rows->find("spacing_m")->line, 3);
  EXPECT_TRUE(*rows->find("on")->boolean());
  EXPECT_EQ((*value->find("list")->array())[1].number(), 2.5);
}

TEST(Yaml, RefusesWithTheLine) {
  EXPECT_EQ(parse_yaml(std::string_view("a: 1\nb: \0 *c\n", 13), "p.yaml").error().message(),
            "p.yaml:2: not YAML: bytes that are no text.");
  EXPECT_NE(parse_yaml("a: 1\nb: [1, 2\n", "p.yaml").error().message().find("p.yaml:"), std::string::npos);
  EXPECT_EQ(parse_yaml("a: 1\na: 2\n", "p.yaml").error().where, "p.yaml:2");
  EXPECT_EQ(parse_yaml("a: &x 1\nb: *x\n", "p.yaml").error().where, "p.yaml:1");
  EXPECT_TRUE(parse_yaml("a: boards/*.jpg # & and * are fine here\nb: 'x & y'\n", "p.yaml").ok());
  std::string deep;
  for (int i = 0; i < 5000; ++i) deep += "[";
  EXPECT_FALSE(parse_yaml(deep, "p.yaml").ok());
}

TEST(Json, RoundTripsAndRefuses) {
  Value value;
  value.set("a", 0.1);
  value.set("b", std::numeric_limits<double>::quiet_NaN());
  value.set("c", Array{1, "x", true});
  EXPECT_EQ(to_json(value, -1), R"({"a":0.1,"b":null,"c":[1,"x",true]})");
  const auto again = parse_json(to_json(value), "t.json");
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again->find("a")->number(), 0.1);
  EXPECT_FALSE(parse_json("{", "t.json").ok());
  EXPECT_FALSE(parse_json(std::string(200000, '['), "t.json").ok());
}

TEST(Fields, ReadsAndRefusesUnknownKeys) {
  const auto value = parse_yaml("spacing_m: 3.0\nheigth_m: 1.7\n", "p.yaml");
  double spacing_m = 0.0;
  double height_m = 0.0;
  Fields fields(*value, "p.yaml", "rows");
  fields.required("spacing_m", spacing_m);
  fields.optional("height_m", height_m);
  EXPECT_EQ(spacing_m, 3.0);
  const auto status = fields.finish();
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().message(),
            "p.yaml:2: unknown key 'heigth_m' in 'rows'; wanted 'height_m' perhaps.");
}

TEST(Fields, NamesTheSlipBeforeWhatItLeavesMissing) {
  const auto value = parse_yaml("square_mm: 38\n", "b.yaml");
  double square_m = 0.0;
  Fields fields(*value, "b.yaml", "");
  fields.required("square_m", square_m);
  EXPECT_EQ(fields.finish().error().message(),
            "b.yaml:1: unknown key 'square_mm'; wanted 'square_m' perhaps.");
}

TEST(Fields, NamesWrongKindsAndMissingKeys) {
  const auto value = parse_yaml("\na: x\n", "p.yaml");
  double a = 0.0;
  Fields wrong(*value, "p.yaml", "");
  wrong.required("a", a);
  EXPECT_EQ(wrong.finish().error().message(), "p.yaml:2: a is 'x'; wanted a number.");
  Fields missing(*value, "p.yaml", "rows");
  std::string text;
  missing.optional("a", text);
  missing.required("b", a);
  EXPECT_EQ(missing.finish().error().code, "missing_key");
}

TEST(Yaml, AnyBytesEndInAValueOrAnError) {
  Random random(11);
  const std::string alphabet = "ab:-[]{}\"'#&*!|>?% \n\t1.,";
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    for (std::uint32_t n = random.below(30); n > 0; --n)
      text += alphabet[random.below(static_cast<std::uint32_t>(alphabet.size()))];
    (void)parse_yaml(text, "p.yaml").ok();
    (void)parse_json(text, "t.json").ok();
  }
}

}  // namespace
}  // namespace furrow::base
