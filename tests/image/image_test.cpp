#include "furrow/image/image.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "furrow/base/file.h"
#include "furrow/base/random.h"

namespace furrow::image {
namespace {

Image noise(int width, int height) {
  base::Random random(1);
  Image picture = make_image(width, height, 3);
  for (auto& value : picture.data) value = static_cast<std::uint8_t>(random.below(256));
  return picture;
}

TEST(Image, PngKeepsEveryPixelInRgbOrder) {
  const Image picture = noise(33, 17);
  const auto again = decode_image(encode_image(picture, ".png"), "a.png");
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again->data, picture.data);
}

TEST(Image, NamesWhatCannotBeRead) {
  EXPECT_EQ(read_image("/nowhere/a.jpg").error().code, "file_missing");
  EXPECT_EQ(decode_image("", "a.jpg").error().message(),
            "a.jpg: the file is empty; wanted a whole JPEG, PNG or TIFF picture.");
  EXPECT_EQ(decode_image("no picture", "a.jpg").error().code, "picture_unreadable");
  const std::string jpeg = encode_image(noise(320, 240), ".jpg");
  EXPECT_TRUE(decode_image(jpeg, "a.jpg").ok());
  EXPECT_EQ(decode_image(jpeg.substr(0, jpeg.size() * 2 / 3), "a.jpg").error().code, "picture_unreadable");
}

TEST(Image, AnyBytesEndInAPictureOrAnError) {
  const std::string png = encode_image(noise(16, 16), ".png");
  base::Random random(5);
  for (int i = 0; i < 500; ++i) {
    std::string bytes = png.substr(0, random.below(static_cast<std::uint32_t>(png.size())) + 1);
    bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] = static_cast<char>(random.below(256));
    (void)decode_image(bytes, "a.png").ok();
  }
}

TEST(Image, ResizeAveragesAreas) {
  Image picture = make_image(4, 2, 1);
  picture.data = {0, 100, 10, 30, 100, 200, 50, 70};
  const Image half = resize(picture, 2, 1);
  EXPECT_EQ(half.data, (std::vector<std::uint8_t>{100, 40}));
}

TEST(Image, CropTakesTheNamedPart) {
  Image picture = make_image(4, 3, 1);
  for (std::size_t i = 0; i < picture.data.size(); ++i) picture.data[i] = static_cast<std::uint8_t>(i);
  const Image part = crop(picture, 1, 1, 2, 2);
  EXPECT_EQ(part.data, (std::vector<std::uint8_t>{5, 6, 9, 10}));
  EXPECT_EQ(crop(picture, 0, 0, 4, 3).data, picture.data);
}

}  // namespace
}  // namespace furrow::image
