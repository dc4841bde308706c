#include "furrow/depth/depth_map.h"

#include <gtest/gtest.h>
#include <cmath>
#include <cstring>

#include "damaged.h"

namespace furrow::depth {
namespace {

std::string raw(const std::vector<float>& values) {
  std::string bytes(values.size() * sizeof(float), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

std::string npy(const std::string& type, const std::string& shape, const std::string& data,
                const std::string& order = "False") {
  std::string header =
      "{'descr': '" + type + "', 'fortran_order': " + order + ", 'shape': (" + shape + "), }";
  header.resize((10 + header.size()) / 64 * 64 + 64 - 10 - 1, ' ');
  header += '\n';
  return std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(header.size() % 256) +
         static_cast<char>(header.size() / 256) + header + data;
}

TEST(DepthMap, ReadsNumPyFloatsWithLeadingAxes) {
  const auto map = decode_depth_map(npy("<f4", "1, 1, 2, 3", raw({1, 2, 3, 4, 5, -1})), "a.npy", 0.001);
  ASSERT_TRUE(map.ok()) << map.error().message();
  EXPECT_EQ(map->width, 3);
  EXPECT_EQ(map->height, 2);
  EXPECT_FLOAT_EQ(map->at(1, 0), 2.0F);
  EXPECT_FLOAT_EQ(map->at(0, 1), 4.0F);
  EXPECT_TRUE(std::isnan(map->at(2, 1)));  // not above 0: not known
}

TEST(DepthMap, ReadsNumPyCountsOfEitherEnd) {
  const auto little = decode_depth_map(npy("<u2", "1, 2", std::string("\x10\x00\x00\x01", 4)), "a.npy", 0.5);
  ASSERT_TRUE(little.ok()) << little.error().message();
  EXPECT_FLOAT_EQ(little->at(0, 0), 8.0F);
  EXPECT_FLOAT_EQ(little->at(1, 0), 128.0F);
  const auto big = decode_depth_map(npy(">u2", "1, 2", std::string("\x00\x10\x01\x00", 4)), "a.npy", 0.5);
  ASSERT_TRUE(big.ok()) << big.error().message();
  EXPECT_EQ(big->values, little->values);
}

TEST(DepthMap, APfmStandsOnItsHead) {
  const auto map = decode_depth_map("Pf\n2 2\n-1.0\n" + raw({3, 4, 1, 2}), "a.pfm", 1.0);
  ASSERT_TRUE(map.ok()) << map.error().message();
  EXPECT_EQ(map->values, (std::vector<float>{1, 2, 3, 4}));
}

TEST(DepthMap, NamesWhatItCannotRead) {
  const auto code = [](const std::string& bytes, const std::string& name) {
    const auto map = decode_depth_map(bytes, name, 1.0);
    return map.ok() ? std::string("ok") : map.error().code;
  };
  const std::string good = npy("<f4", "2, 3", raw({1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(code(good, "a.npy"), "ok");
  for (const std::string& bad :
       {std::string(), std::string("\x93NUMPY"), good.substr(0, 20), good.substr(0, good.size() - 1),
        npy("<f4", "2, 3", raw({1, 2, 3, 4, 5, 6}), "True"), npy("<c8", "2, 3", raw({1, 2, 3, 4, 5, 6})),
        npy("<f4", "2, 3, 4", raw({1, 2, 3, 4, 5, 6})), npy("<f4", "99999999, 99999999", "")}) {
    EXPECT_EQ(code(bad, "a.npy"), "depth_map_unreadable");
  }
  EXPECT_EQ(code("PF\n2 2\n-1.0\n" + raw(std::vector<float>(12)), "a.pfm"), "depth_map_unreadable");
  EXPECT_EQ(code("Pf\n2 2\n-1.0\n" + raw({1, 2, 3}), "a.pfm"), "depth_map_unreadable");
  EXPECT_EQ(code("no picture", "a.png"), "depth_map_unreadable");
  EXPECT_EQ(code(good, "a.exr"), "depth_map_unreadable");
  EXPECT_EQ(read_depth_map("/nowhere/a.npy", 1.0).error().code, "file_missing");
}

// A number that no size can be, in the place of one: such headers once ended the program.
TEST(DepthMap, NamesAShapeThatIsNone) {
  for (const char* shape : {"99999999999999999999, 3", "x3, 2", "2, -", "0x2, 3", "-2, 3"}) {
    const auto map = decode_depth_map(npy("<f4", shape, raw({1, 2, 3, 4, 5, 6})), "a.npy", 1.0);
    ASSERT_FALSE(map.ok()) << shape;
    EXPECT_EQ(map.error().code, "depth_map_unreadable");
  }
}

std::string from_hex(const std::string& hex) {
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2)
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  return bytes;
}

/// Two by one pixels of 16 bits, 4096 and 256.
const std::string kSmallPng = from_hex(
    "89504e470d0a1a0a0000000d494844520000000200000001100000000081d9fc150000000d49444154789c6310606064"
    "0000004700125050fcbb0000000049454e44ae426082");

TEST(DepthMap, ReadsAGreyPngOf16Bits) {
  const auto map = decode_depth_map(kSmallPng, "a.png", 0.5);
  ASSERT_TRUE(map.ok()) << map.error().message();
  EXPECT_EQ(map->values, (std::vector<float>{2048, 128}));
}

// Its header promises 3.6 thousand million pixels, over the decoder's limit, which once ended the program.
TEST(DepthMap, NamesAPngThatIsTooLarge) {
  const auto map = decode_depth_map(
      from_hex(
          "89504e470d0a1a0a0000000d494844520000ea600000ea601000000000f529f6dd0000000c49444154789c6360a03d00"
          "000064000186643c350000000049454e44ae426082"),
      "a.png", 1.0);
  ASSERT_FALSE(map.ok());
  EXPECT_EQ(map.error().code, "depth_map_unreadable");
}

// A damaged file is a map whose numbers are above 0 or not known, or an error that says where.
TEST(DepthMap, DamagedFilesGiveMapsOrErrors) {
  const std::vector<std::pair<std::string, std::string>> files = {
      {"a.npy", npy("<f4", "2, 3", raw({1, 2, 3, 4, 5, 6}))},
      {"b.npy", npy(">u2", "1, 1, 2", std::string("\x00\x10\x01\x00", 4))},
      {"a.pfm", "Pf\n2 2\n-1.0\n" + raw({3, 4, 1, 2})},
      {"a.png", kSmallPng}};
  base::Random random(27112026);
  for (const auto& [name, bytes] : files) {
    for (int i = 0; i < 2000; ++i) {
      const auto map = decode_depth_map(testing::damaged(bytes, random), name, 0.5);
      if (!map.ok()) {
        EXPECT_EQ(map.error().where, name);
        continue;
      }
      ASSERT_EQ(map->values.size(),
                static_cast<std::size_t>(map->width) * static_cast<std::size_t>(map->height));
      for (const float value : map->values) ASSERT_TRUE(std::isnan(value) || value > 0.0F);
    }
  }
}

}  // namespace
}  // namespace furrow::depth
