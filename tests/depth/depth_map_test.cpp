#include "furrow/depth/depth_map.h"

#include <gtest/gtest.h>
#include <cmath>
#include <cstring>

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

}  // namespace
}  // namespace furrow::depth
