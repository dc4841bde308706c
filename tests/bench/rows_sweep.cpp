#include "bench/rows_sweep.h"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "furrow/base/random.h"
#include "furrow/stats/robust.h"
#include "rows/drawn_field.h"

namespace furrow::bench {
namespace {

using rows::testing::DrawnField;

constexpr int kWidth = 320, kHeight = 240, kSeeds = 20;
/// Drawn level and this much larger, then turned by the roll and cut to size.
constexpr double kCanvas = 1.5;

/// What one picture of the sweep shows; one quantity is varied at a time.
struct Scene {
  double row_count = 6.0;      ///< on the middle row
  double pitch_deg = 35.0;     ///< below the horizon; 90: straight down
  double roll_deg = 0.0;       ///< of the picture about its middle
  double noise = 12.0;         ///< one-sigma, grey levels
  double blur_px = 0.0;        ///< one-sigma
  double gaps = 0.15;          ///< part of the plants that are missing
  double half_width = 0.18;    ///< of a row, spacings
  double bend_radius = 1e9;    ///< of the rows on the ground, spacings
  bool knows_horizon = false;  ///< the search is told the horizon and the roll
};

double radians(double deg) {
  return deg * std::numbers::pi / 180.0;
}

double horizon_above_middle(const Scene& scene) {
  const double f = 0.5 * kWidth / std::tan(radians(32.5));  // a camera that sees 65 deg
  return f * std::tan(radians(std::min(scene.pitch_deg, 89.999)));
}

/// The level field on the larger canvas; offset, slant and the bend's side are drawn by the seed.
DrawnField drawn_of(const Scene& scene, std::uint64_t seed) {
  base::Random random(seed);
  DrawnField drawn;
  drawn.width = static_cast<int>(kCanvas * kWidth), drawn.height = static_cast<int>(kCanvas * kHeight);
  drawn.seed = seed;
  drawn.noise = 0.0, drawn.gaps = scene.gaps, drawn.half_width = scene.half_width, drawn.ragged = 0.02;
  rows::PlanarField& field = drawn.field;
  field.u0 = 0.5 * (drawn.width - 1), field.v0 = 0.5 * (drawn.height + kHeight) - 1.0;
  field.length = kHeight;
  field.convergence = kHeight / (0.5 * kHeight + horizon_above_middle(scene));
  field.spacing = kWidth / scene.row_count / field.scale(field.v0 - 0.5 * kHeight);
  field.offset = random.uniform(-0.5, 0.5) * field.spacing;
  field.slope = random.uniform(-0.25, 0.25) * kWidth;
  const double bend = 0.5 * kHeight * kHeight / field.spacing / scene.bend_radius;
  field.bend = random.uniform() < 0.5 ? -bend : bend;
  return drawn;
}

/// canvas = turn * picture, 2 x 3.
cv::Matx23d canvas_from_picture(const Scene& scene, const DrawnField& drawn) {
  const double c = std::cos(radians(scene.roll_deg)), s = std::sin(radians(scene.roll_deg));
  const double u = 0.5 * (kWidth - 1), v = 0.5 * (kHeight - 1);
  const double canvas_u = 0.5 * (drawn.width - 1), canvas_v = 0.5 * (drawn.height - 1);
  return {c, -s, canvas_u - c * u + s * v, s, c, canvas_v - s * u - c * v};
}

Image picture_of(const Scene& scene, const DrawnField& drawn) {
  Image level = rows::testing::draw(drawn), picture = image::make_image(kWidth, kHeight, 3);
  const cv::Mat canvas(level.height, level.width, CV_8UC3, level.data.data());
  cv::Mat out(kHeight, kWidth, CV_8UC3, picture.data.data());
  cv::warpAffine(canvas, out, canvas_from_picture(scene, drawn), {kWidth, kHeight},
                 cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
  if (scene.blur_px > 0.0) cv::GaussianBlur(out, out, {0, 0}, scene.blur_px);
  base::Random random(drawn.seed + 1000);
  for (auto& value : picture.data)
    value =
        static_cast<std::uint8_t>(std::clamp(std::lround(value + random.normal(0.0, scene.noise)), 0L, 255L));
  return picture;
}

/// Rows -1, 0 and 1, or two of them where the picture shows no more, lie within a tenth of a spacing of
/// neighbouring drawn rows, at the median over the lower three quarters of the picture.
bool is_right(const Scene& scene, const DrawnField& drawn, const rows::RowLines& lines) {
  constexpr double kTolerance = 0.1;
  const cv::Matx23d turn = canvas_from_picture(scene, drawn);
  std::vector<double> firsts;  // number of row 0 by each row
  for (int index = -1; index <= 1; ++index) {
    std::vector<double> places;
    for (const rows::RowLine& row : lines.rows) {
      if (row.index != index) continue;
      for (const rows::RowSample& sample : row.samples) {
        const Eigen::Vector2d& p = sample.centre_px;
        if (p.y() < 0.25 * kHeight || p.x() < 0.0 || p.x() > kWidth - 1.0) continue;
        const auto canvas = turn * cv::Vec3d(p.x(), p.y(), 1.0);
        if (drawn.field.scale(canvas[1]) > 0.05) places.push_back(drawn.field.k_at(canvas[0], canvas[1]));
      }
    }
    if (!places.empty()) firsts.push_back(stats::median(places) - index);
  }
  return firsts.size() >= 2 && std::all_of(firsts.begin(), firsts.end(), [&](double first) {
           return std::abs(first - std::round(firsts[0])) <= kTolerance;
         });
}

void print_cell(rows::Method method, const Scene& scene, double value, std::vector<Answer>& answers) {
  int right = 0;
  std::vector<double> scores, confidences;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const DrawnField drawn = drawn_of(scene, seed);
    rows::DetectOptions options;
    options.method = method;
    if (scene.knows_horizon) {
      options.priors.horizon_slope = std::tan(radians(-scene.roll_deg));
      options.priors.horizon_v_px =
          0.5 * (kHeight - 1) - horizon_above_middle(scene) / std::cos(radians(scene.roll_deg));
    }
    const auto lines = rows::detect(picture_of(scene, drawn), options);
    const bool right_here = is_right(scene, drawn, lines);
    right += right_here;
    answers.push_back({lines.confidence, right_here});
    scores.push_back(lines.score);
    confidences.push_back(lines.confidence);
  }
  std::printf(" %g: %.2f (%.2f, %.2f)", value, right / static_cast<double>(kSeeds), stats::median(scores),
              stats::median(confidences));
}

void print_line(rows::Method method, const char* method_name, const char* what, Scene scene,
                double Scene::*quantity, const std::vector<double>& values, std::vector<Answer>& answers) {
  std::printf("sweep %-6s %s", method_name, what);
  for (const double value : values) {
    scene.*quantity = value;
    print_cell(method, scene, value, answers);
  }
  std::printf("\n");
}

}  // namespace

std::vector<Answer> print_row_sweep(rows::Method method, const char* method_name) {
  std::vector<Answer> answers;
  const auto line = [&](const char* what, double Scene::*quantity, const std::vector<double>& values,
                        const Scene& scene = {}) {
    print_line(method, method_name, what, scene, quantity, values, answers);
  };
  std::printf("sweep %-6s quantity value: part right (median score, median confidence), %d pictures each\n",
              method_name, kSeeds);
  line("noise / levels", &Scene::noise, {0, 12, 24, 48, 72, 96});
  line("blur / px", &Scene::blur_px, {0, 2, 4, 6, 8, 12});
  line("rows on the middle row", &Scene::row_count, {1.5, 2, 3, 6, 12, 24, 40, 60, 80, 120});
  line("pitch / deg", &Scene::pitch_deg, {8, 12, 20, 35, 60, 90});
  line("roll / deg", &Scene::roll_deg, {0, 3, 6, 10, 15, 20, 25, 30, 40});
  line("roll / deg, horizon given", &Scene::roll_deg, {0, 3, 6, 10, 15, 20}, {.knows_horizon = true});
  line("missing plants", &Scene::gaps, {0, 0.3, 0.5, 0.7, 0.8, 0.9});
  line("half width / spacings", &Scene::half_width, {0.04, 0.1, 0.2, 0.3, 0.4, 0.45});
  line("bend radius / spacings", &Scene::bend_radius, {1e9, 80, 40, 20, 10, 5});
  return answers;
}

}  // namespace furrow::bench
