// Pictures made to keep a search busy: it ends within its bound, and says what it cost.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>

#include "furrow/base/random.h"
#include "furrow/target/detect.h"
#include "target/find.h"
#include "target/render_board.h"

namespace furrow::target {
namespace {

#ifdef __SANITIZE_ADDRESS__
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

using Grey = std::function<double(double, double)>;

/// Something in [0, 1) that depends on a cell alone.
double hashed(double i, double j) {
  const auto key =
      static_cast<std::uint64_t>(static_cast<std::int64_t>(i) * 1'000'003 + static_cast<std::int64_t>(j));
  return static_cast<double>(base::mix_bits(key) >> 11U) / 9007199254740992.0;
}

/// A checkerboard without end, squares of `side`; its lines wave by `wave` squares.
Grey checker(double side, double wave) {
  return [=](double u, double v) {
    const double x = (u + 0.2 * v) / side, y = (v - 0.2 * u) / side;
    const double bent_x = x + wave * std::sin(0.7 * y), bent_y = y + wave * std::sin(0.9 * x);
    return std::fmod(std::abs(std::floor(bent_x) + std::floor(bent_y)), 2.0) < 0.5 ? 40.0 : 200.0;
  };
}

/// Grey levels drawn for each cell of that side and blended between them: saddles everywhere.
Grey blended_noise(double side) {
  return [=](double u, double v) {
    const double x = u / side, y = v / side, i = std::floor(x), j = std::floor(y);
    const auto smooth = [](double t) { return t * t * (3.0 - 2.0 * t); };
    const double a = smooth(x - i), b = smooth(y - j);
    return 255.0 * ((1 - b) * ((1 - a) * hashed(i, j) + a * hashed(i + 1, j)) +
                    b * ((1 - a) * hashed(i, j + 1) + a * hashed(i + 1, j + 1)));
  };
}

/// Places as in a copy 1280 px wide, at which boards are looked for.
Image drawn(int width, int height, const Grey& grey) {
  Image out = image::make_image(width, height, 1);
  const double scale = 1280.0 / width;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u)
      *out.at(u, v) =
          static_cast<std::uint8_t>(std::clamp(std::lround(grey(scale * u, scale * v)), 0L, 255L));
  }
  return out;
}

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

TEST(Bounded, EveryPictureEndsWithinItsSteps) {
  const BoardSpec board{"b", 9, 6, 0.025, 1.0};
  BoardSpec charuco{"c", 10, 7, 0.022, 1.0};
  charuco.kind = BoardKind::charuco;
  charuco.marker_m = 0.016;
  charuco.dictionary = "5x5_50";
  const std::vector<std::pair<std::string, Grey>> busy{
      {"noise", [](double u, double v) { return 255.0 * hashed(1e3 * u, 1e3 * v); }},
      {"blended noise", blended_noise(6.0)},
      {"fine squares", checker(5.0, 0.0)},
      {"squares", checker(16.0, 0.0)},
      {"waving squares", checker(8.0, 0.6)},
      {"wrinkled squares", checker(10.0, 2.0)}};
  for (const auto& [name, grey] : busy) {
    for (const auto& [width, height] : {std::pair{2592, 1936}, {5472, 3648}}) {
      // The other patterns take no longer, and a sanitized build takes twenty times as long for all.
      if (width > 4000 && (kSanitized || (name != "noise" && name != "fine squares"))) continue;
      const Image picture = drawn(width, height, grey);
      for (const BoardSpec& spec : {board, charuco}) {
        const double before_s = cpu_seconds();
        const BoardDetection seen = detect_board(picture, spec);
        // Before outlines were bounded, OpenCV's markers took minutes over fine squares. Seconds in any
        // build.
        EXPECT_LT(cpu_seconds() - before_s, 60.0) << name << " " << width << " " << spec.name;
        EXPECT_GT(seen.search_steps, 100'000) << name;
        EXPECT_LE(seen.search_steps, kMostSearchSteps) << name;
        EXPECT_TRUE(seen.search_cut || name != "fine squares") << spec.name;
      }
    }
  }
}

TEST(Bounded, ASearchWithoutStepsLeftEndsAtOnceAndSaysSo) {
  const BoardSpec board{"b", 9, 6, 0.025, 1.0};
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 600;
  camera.cx = 319.5;
  camera.cy = 239.5;
  Rigid3 pose;
  pose.translation = {-0.1, -0.06, 0.35};
  const Image picture = render_board(camera, board, pose);
  SearchWork fresh;
  EXPECT_EQ(find_grid(picture, 9, 6, fresh).grid.px.size(), 54U);
  EXPECT_FALSE(fresh.cut());
  EXPECT_LT(fresh.steps(), kMostSearchSteps / 100);
  // At every place where it may end: no crash, and what it finds is a whole grid or none.
  for (std::int64_t left = 0; left < fresh.steps(); left += fresh.steps() / 50) {
    SearchWork work;
    ASSERT_TRUE(work.spend(kMostSearchSteps - left));
    const std::size_t found = find_grid(picture, 9, 6, work).grid.px.size();
    EXPECT_TRUE(found == 0 || found == 54) << left;
    EXPECT_TRUE(work.cut()) << left;
    EXPECT_LE(work.steps(), kMostSearchSteps);
  }
}

}  // namespace
}  // namespace furrow::target
