#include "furrow/rows/thesis.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "rows/index_rows.h"

namespace furrow::rows {
namespace {

/// A straight row of the working picture: r = x cos t + y sin t.
struct HoughLine {
  double rho = 0.0, theta = 0.0;
  double x_at(double y) const { return (rho - y * std::sin(theta)) / std::cos(theta); }
  /// Angle from the vertical, in (-90, 90] deg.
  double tilt_deg() const {
    const double degrees = theta * 180.0 / std::numbers::pi;
    return degrees > 90.0 ? degrees - 180.0 : degrees;
  }
};

struct Chain {
  cv::Mat working, mask, green, binary, filled, skeleton, edges;
  std::vector<HoughLine> raw, kept;
};

void clear_rows(cv::Mat& picture, int from, int to) {
  from = std::clamp(from, 0, picture.rows);
  to = std::clamp(to, from, picture.rows);
  picture.rowRange(from, to).setTo(0);
}

/// Step 1: green band of HSV, and the green channel under it.
void mask_green(Chain& chain, const ThesisOptions& options) {
  cv::Mat hsv;
  cv::cvtColor(chain.working, hsv, cv::COLOR_RGB2HSV);
  cv::inRange(hsv, cv::Scalar(options.hue_low, options.saturation_low, options.value_low),
              cv::Scalar(options.hue_high, 255, 255), chain.mask);
  cv::Mat green;
  cv::extractChannel(chain.working, green, 1);
  chain.green = cv::Mat::zeros(green.size(), CV_8U);
  green.copyTo(chain.green, chain.mask);
}

/// Step 2: cleared, blurred, Otsu, dilated, eroded, cropped, borders cleared.
void make_binary(Chain& chain, const ThesisOptions& options) {
  cv::Mat grey = chain.green.clone();
  const auto height_part = [&](double part) { return static_cast<int>(std::lround(part * grey.rows)); };
  clear_rows(grey, 0, height_part(options.clear_top));
  clear_rows(grey, grey.rows - height_part(options.clear_bottom), grey.rows);
  const cv::Size box(options.blur_px | 1, options.blur_px | 1);
  if (!options.blur_after_threshold) cv::blur(grey, grey, box);
  cv::threshold(grey, chain.binary, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  if (options.blur_after_threshold) {
    cv::blur(chain.binary, chain.binary, box);
    cv::threshold(chain.binary, chain.binary, 127, 255, cv::THRESH_BINARY);
  }
  cv::dilate(chain.binary, chain.binary, cv::Mat(), {-1, -1}, options.dilations);
  cv::erode(chain.binary, chain.binary, cv::Mat(), {-1, -1}, options.erosions);
  clear_rows(chain.binary, 0, height_part(options.crop_top));
  const int side = std::clamp(options.clear_side_px, 0, chain.binary.cols / 2);
  chain.binary.colRange(0, side).setTo(0);
  chain.binary.colRange(chain.binary.cols - side, chain.binary.cols).setTo(0);
}

/// Step 3: what the outside cannot reach is a hole.
void fill_holes(Chain& chain) {
  cv::Mat outside;
  cv::copyMakeBorder(chain.binary, outside, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::floodFill(outside, cv::Point(0, 0), cv::Scalar(128));
  const cv::Mat inside = outside(cv::Rect(1, 1, chain.binary.cols, chain.binary.rows));
  chain.filled = inside != 128;
}

/// Step 4: erosion repeated while something is left; the rest of each erosion's opening stays (Serra's
/// skeleton), then Sobel edges.
void make_skeleton(Chain& chain, const ThesisOptions& options) {
  cv::Mat rest = chain.filled.clone();
  for (int i = 0; i < options.skeleton_erosions; ++i) {
    cv::Mat eroded, opened;
    cv::erode(rest, eroded, cv::Mat());
    cv::dilate(eroded, opened, cv::Mat());
    // A part that this erosion would delete altogether is kept as it is.
    rest = eroded | (rest & ~opened);
  }
  chain.skeleton = rest;
  cv::Mat along_x, along_y;
  cv::Sobel(rest, along_x, CV_16S, 1, 0);
  cv::Sobel(rest, along_y, CV_16S, 0, 1);
  cv::convertScaleAbs(cv::abs(along_x) + cv::abs(along_y), chain.edges);
  cv::threshold(chain.edges, chain.edges, 127, 255, cv::THRESH_BINARY);
}

bool is_same_row(const HoughLine& a, const HoughLine& b, int height, const ThesisOptions& options) {
  const double apart_middle = std::abs(a.x_at(0.5 * height) - b.x_at(0.5 * height));
  const double apart_bottom = std::abs(a.x_at(height) - b.x_at(height));
  if (std::min(apart_middle, apart_bottom) < options.same_rho_px) return true;
  return std::abs(a.tilt_deg() - b.tilt_deg()) < options.same_theta_deg &&
         std::max(apart_middle, apart_bottom) < 2.0 * options.same_rho_px;
}

std::vector<HoughLine> without_duplicates(const std::vector<HoughLine>& raw, int height,
                                          const ThesisOptions& options) {
  std::vector<HoughLine> kept;
  for (const HoughLine& line : raw) {
    if (std::abs(line.tilt_deg()) > options.most_tilt_deg) continue;
    const bool is_new = std::none_of(kept.begin(), kept.end(), [&](const HoughLine& other) {
      return is_same_row(line, other, height, options);
    });
    if (is_new) kept.push_back(line);
  }
  return kept;
}

/// Step 5: the threshold sinks until the wanted number of rows is found.
void sweep_hough(Chain& chain, const ThesisOptions& options) {
  const double theta_step = std::max(options.hough_theta_deg, 0.1) * std::numbers::pi / 180.0;
  const int step = std::max(options.hough_step, 1);
  for (int votes = options.hough_start; votes >= std::max(options.hough_stop, 1); votes -= step) {
    std::vector<cv::Vec2f> found;  // by votes, most first
    cv::HoughLines(chain.edges, found, std::max(options.hough_rho_px, 0.1), theta_step, votes);
    chain.raw.clear();
    for (const cv::Vec2f& line : found)
      chain.raw.push_back({static_cast<double>(line[0]), static_cast<double>(line[1])});
    chain.kept = without_duplicates(chain.raw, chain.edges.rows, options);
    if (static_cast<int>(chain.kept.size()) >= options.wanted_rows) break;
  }
  if (static_cast<int>(chain.kept.size()) > options.wanted_rows)
    chain.kept.resize(static_cast<std::size_t>(std::max(options.wanted_rows, 0)));
}

Chain run_chain(const Image& picture, const ThesisOptions& options) {
  check(options.width >= 16 && options.height >= 16, "ThesisOptions: the working size must be 16x16 or more");
  Chain chain;
  const cv::Mat full(picture.height, picture.width, CV_8UC(picture.channels),
                     const_cast<std::uint8_t*>(picture.data.data()));
  cv::resize(full, chain.working, {options.width, options.height}, 0, 0, cv::INTER_AREA);
  if (picture.channels == 1) cv::cvtColor(chain.working, chain.working, cv::COLOR_GRAY2RGB);
  mask_green(chain, options);
  make_binary(chain, options);
  fill_holes(chain);
  make_skeleton(chain, options);
  sweep_hough(chain, options);
  return chain;
}

/// Half of the white run of the filled mask around x on the middle row: the thesis's automatic search for
/// pix.
std::optional<double> half_width(const cv::Mat& filled, double x) {
  const int y = filled.rows / 2;
  const int column = static_cast<int>(std::lround(x));
  if (column < 0 || column >= filled.cols || filled.at<std::uint8_t>(y, column) == 0) return std::nullopt;
  int left = column, right = column;
  while (left > 0 && filled.at<std::uint8_t>(y, left - 1) != 0) --left;
  while (right + 1 < filled.cols && filled.at<std::uint8_t>(y, right + 1) != 0) ++right;
  if (left == 0 || right + 1 == filled.cols) return std::nullopt;
  return 0.5 * (right - left + 1);
}

Image from_mat(const cv::Mat& mat) {
  Image picture = image::make_image(mat.cols, mat.rows, mat.channels());
  mat.copyTo(cv::Mat(mat.rows, mat.cols, mat.type(), picture.data.data()));
  return picture;
}

Image drawn(const cv::Mat& working, const std::vector<HoughLine>& lines) {
  cv::Mat canvas = working.clone();
  for (const HoughLine& line : lines) {
    // Points far outside on both sides; cv::line clips.
    const double a = std::cos(line.theta), b = std::sin(line.theta),
                 reach = 2.0 * (working.cols + working.rows);
    cv::line(canvas, cv::Point2d(a * line.rho - b * reach, b * line.rho + a * reach),
             cv::Point2d(a * line.rho + b * reach, b * line.rho - a * reach), cv::Scalar(255, 0, 0), 1,
             cv::LINE_AA);
  }
  return from_mat(canvas);
}

}  // namespace

RowLines detect_thesis(const Image& picture, const ThesisOptions& options) {
  RowLines result = begun(picture, "thesis");
  if (picture.empty()) return result;
  const Chain chain = run_chain(picture, options);
  const double scale_u = static_cast<double>(picture.width) / options.width;
  const double scale_v = static_cast<double>(picture.height) / options.height;
  constexpr double kStepPx = 10.0;  // samples of a row are at most 10 px apart (row_lines.h)
  for (const HoughLine& line : chain.kept) {
    RowLine row;
    for (const double v : sample_rows(picture.height, kStepPx)) {
      RowSample sample;
      const double y = (v + 0.5) / scale_v - 0.5;
      sample.centre_px = {(line.x_at(y) + 0.5) * scale_u - 0.5, v};
      sample.sigma_px = scale_u * std::max(options.hough_rho_px, 1.0);
      sample.seen = sample.centre_px.x() >= 0.0 && sample.centre_px.x() <= picture.width - 1.0;
      row.samples.push_back(sample);
    }
    if (const auto half = half_width(chain.filled, line.x_at(0.5 * (options.height - 1)))) {
      // One working pixel on each side is all that the mask resolves.
      row.half_width_px = Estimate{*half * scale_u, scale_u / std::numbers::sqrt2, 1};
    }
    result.rows.push_back(std::move(row));
  }
  index_rows(result);
  if (result.rows.empty()) {
    result.status = "no_rows";
    result.reason = "the sweep of the Hough threshold ended without a line";
  } else {
    result.status = "ok";
    // The chain has no measure of its own: as often as it was right on the train pictures of CRBD and CRDLD
    // (a quarter), less where it found fewer rows than wanted.
    constexpr double kOftenRight = 0.25;
    result.confidence = kOftenRight * std::min(1.0, static_cast<double>(result.rows.size()) /
                                                        std::max(options.wanted_rows, 1));
  }
  return result;
}

std::vector<StepPicture> thesis_steps(const Image& picture, const ThesisOptions& options) {
  if (picture.empty()) return {};
  const Chain chain = run_chain(picture, options);
  std::vector<StepPicture> steps;
  steps.push_back({"01_working", from_mat(chain.working)});
  steps.push_back({"02_green_mask", from_mat(chain.mask)});
  steps.push_back({"03_green_channel", from_mat(chain.green)});
  steps.push_back({"04_binary", from_mat(chain.binary)});
  steps.push_back({"05_filled", from_mat(chain.filled)});
  steps.push_back({"06_skeleton", from_mat(chain.skeleton)});
  steps.push_back({"07_sobel", from_mat(chain.edges)});
  steps.push_back({"08_hough_raw", drawn(chain.working, chain.raw)});
  steps.push_back({"09_hough_filtered", drawn(chain.working, chain.kept)});
  return steps;
}

}  // namespace furrow::rows
