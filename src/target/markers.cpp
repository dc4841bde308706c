#include "target/markers.h"

#include <algorithm>
#include <functional>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "furrow/base/text.h"

namespace furrow::target {
namespace {

constexpr std::pair<const char*, int> kDictionaries[] = {
    {"4x4_50", cv::aruco::DICT_4X4_50},
    {"4x4_100", cv::aruco::DICT_4X4_100},
    {"4x4_250", cv::aruco::DICT_4X4_250},
    {"4x4_1000", cv::aruco::DICT_4X4_1000},
    {"5x5_50", cv::aruco::DICT_5X5_50},
    {"5x5_100", cv::aruco::DICT_5X5_100},
    {"5x5_250", cv::aruco::DICT_5X5_250},
    {"5x5_1000", cv::aruco::DICT_5X5_1000},
    {"6x6_50", cv::aruco::DICT_6X6_50},
    {"6x6_100", cv::aruco::DICT_6X6_100},
    {"6x6_250", cv::aruco::DICT_6X6_250},
    {"6x6_1000", cv::aruco::DICT_6X6_1000},
    {"7x7_50", cv::aruco::DICT_7X7_50},
    {"7x7_100", cv::aruco::DICT_7X7_100},
    {"7x7_250", cv::aruco::DICT_7X7_250},
    {"7x7_1000", cv::aruco::DICT_7X7_1000},
    {"aruco_original", cv::aruco::DICT_ARUCO_ORIGINAL},
    {"apriltag_16h5", cv::aruco::DICT_APRILTAG_16h5},
    {"apriltag_25h9", cv::aruco::DICT_APRILTAG_25h9},
    {"apriltag_36h10", cv::aruco::DICT_APRILTAG_36h10},
    {"apriltag_36h11", cv::aruco::DICT_APRILTAG_36h11},
};

/// Black modules about a marker's bits. Kalibr prints its tags with two.
constexpr int kMarkerBorder = 1, kTagBorder = 2;

/// Null for an unknown name.
cv::Ptr<cv::aruco::Dictionary> opencv_dictionary(const std::string& key) {
  for (const auto& [name, number] : kDictionaries) {
    if (key == name) return cv::aruco::getPredefinedDictionary(number);
  }
  return {};
}

/// Column and row of the white square that holds a marker.
std::pair<int, int> square_of_marker(const BoardSpec& board, int id) {
  int count = 0;
  for (int j = 0; j <= board.corners_y; ++j) {
    for (int i = 0; i <= board.corners_x; ++i) {
      if (!is_black_square(board, i, j) && count++ == id) return {i, j};
    }
  }
  check(false, "square_of_marker: no such marker on the board");
  return {};
}

std::array<Eigen::Vector2d, 4> around(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  return {low, Eigen::Vector2d(high.x(), low.y()), high, Eigen::Vector2d(low.x(), high.y())};
}

/// Most outlines with four corners that are looked at; the largest boards have some hundred markers.
constexpr std::size_t kMostOutlines = 2000;

/// Length from which on at most kMostOutlines outlines with four corners are longer, px; nothing where there
/// are no more than that. Outlines are found as OpenCV's detector finds them, at the middle one of its
/// thresholds.
std::optional<std::size_t> shortest_outline_px(const cv::Mat& picture,
                                               const cv::aruco::DetectorParameters& detector,
                                               SearchWork& work) {
  const int window = (detector.adaptiveThreshWinSizeMin + detector.adaptiveThreshWinSizeMax) / 2 | 1;
  cv::Mat dark;
  cv::adaptiveThreshold(picture, dark, 255, cv::ADAPTIVE_THRESH_MEAN_C, cv::THRESH_BINARY_INV, window,
                        detector.adaptiveThreshConstant);
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(dark, outlines, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
  const double shortest_px = detector.minMarkerPerimeterRate * std::max(picture.cols, picture.rows);
  std::vector<std::size_t> lengths_px;
  std::vector<cv::Point> corners;
  for (const auto& outline : outlines) {
    const auto length_px = static_cast<double>(outline.size());
    if (length_px < shortest_px) continue;
    cv::approxPolyDP(outline, corners, length_px * detector.polygonalApproxAccuracyRate, true);
    if (corners.size() == 4 && cv::isContourConvex(corners)) lengths_px.push_back(outline.size());
  }
  const std::size_t looked_at = std::min(lengths_px.size(), kMostOutlines);
  work.spend(static_cast<std::int64_t>(looked_at * looked_at));
  if (lengths_px.size() <= kMostOutlines) return std::nullopt;
  const auto last = lengths_px.begin() + kMostOutlines;
  std::nth_element(lengths_px.begin(), last, lengths_px.end(), std::greater<>());
  work.leave_out();
  return *last + 1;
}

std::vector<SeenMarker> find_with_border(const Image& grey, const BoardSpec& board, int border,
                                         SearchWork& work) {
  const auto dictionary = opencv_dictionary(board.dictionary);
  check(dictionary && grey.channels == 1, "find_markers: a grey picture and a known dictionary");
  auto parameters = cv::aruco::DetectorParameters::create();
  parameters->markerBorderBits = border;
  // Markers of 0.25 % of the picture's longer side are read; OpenCV's own limit is for one marker before the
  // camera.
  parameters->minMarkerPerimeterRate = 0.01;
  const cv::Mat picture(grey.height, grey.width, CV_8U, const_cast<std::uint8_t*>(grey.data.data()));
  if (!work.spend(static_cast<std::int64_t>(grey.width) * grey.height)) return {};
  const int longest_px = std::max(grey.width, grey.height);
  if (const auto least_px = shortest_outline_px(picture, *parameters, work))
    parameters->minMarkerPerimeterRate = (static_cast<double>(*least_px) + 0.5) / longest_px;
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(picture, dictionary, corners, ids, parameters);
  std::vector<SeenMarker> out;
  for (std::size_t m = 0; m < ids.size(); ++m) {
    SeenMarker marker{ids[m], {}};
    for (std::size_t c = 0; c < 4; ++c)
      marker.corner_px[c] = {static_cast<double>(corners[m][c].x), static_cast<double>(corners[m][c].y)};
    out.push_back(marker);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const SeenMarker& a, const SeenMarker& b) { return a.id < b.id; });
  return out;
}

}  // namespace

std::string dictionary_key(const std::string& name) {
  const std::string key = base::to_lower(base::trim(name));
  return key.starts_with("dict_") ? key.substr(5) : key;
}

std::optional<Dictionary> find_dictionary(const std::string& key) {
  const auto dictionary = opencv_dictionary(key);
  if (!dictionary) return std::nullopt;
  return Dictionary{dictionary->bytesList.rows, dictionary->markerSize};
}

std::vector<std::string> dictionary_keys() {
  std::vector<std::string> out;
  for (const auto& [name, number] : kDictionaries) out.emplace_back(name);
  return out;
}

std::string dictionary_names() {
  std::string out;
  for (const std::string& key : dictionary_keys()) out += (out.empty() ? "" : ", ") + key;
  return out;
}

MarkerPrint print_marker(const BoardSpec& board, int id) {
  const auto found = opencv_dictionary(board.dictionary);
  check(found && id >= 0 && id < found->bytesList.rows, "print_marker: no such marker");
  const cv::Mat bits =
      cv::aruco::Dictionary::getBitsFromByteList(found->bytesList.rowRange(id, id + 1), found->markerSize);
  const bool tag = board.kind == BoardKind::aprilgrid;
  const int border = tag ? kTagBorder : kMarkerBorder;
  MarkerPrint out{found->markerSize + 2 * border, {}};
  out.white.assign(static_cast<std::size_t>(out.side) * static_cast<std::size_t>(out.side), false);
  for (int v = 0; v < bits.rows; ++v) {
    for (int u = 0; u < bits.cols; ++u)
      out.white[static_cast<std::size_t>((v + border) * out.side + u + border)] =
          bits.at<std::uint8_t>(v, u) != 0;
  }
  if (tag) std::reverse(out.white.begin(), out.white.end());
  return out;
}

bool is_black_square(const BoardSpec& board, int column, int row) {
  const bool white_first = board.legacy_pattern && (board.corners_y + 1) % 2 == 0;
  return ((column + row) % 2 == 0) != white_first;
}

int marker_count(const BoardSpec& board) {
  if (board.kind == BoardKind::checkerboard) return 0;
  if (board.kind == BoardKind::aprilgrid) return board.corners_x / 2 * (board.corners_y / 2);
  const int squares = (board.corners_x + 1) * (board.corners_y + 1);
  return is_black_square(board, 0, 0) ? squares / 2 : (squares + 1) / 2;
}

std::array<Eigen::Vector2d, 4> marker_in_board(const BoardSpec& board, int id) {
  if (board.kind == BoardKind::aprilgrid) {
    const int columns = board.corners_x / 2, i = 2 * (id % columns),
              j = board.corners_y - 2 - 2 * (id / columns);
    auto corners =
        around(corner_in_board(board, i, j).head<2>(), corner_in_board(board, i + 1, j + 1).head<2>());
    std::rotate(corners.begin(), corners.begin() + 2, corners.end());
    return corners;
  }
  const auto [i, j] = square_of_marker(board, id);
  const Eigen::Vector2d side(board.square_m, board.square_m * board.aspect);
  const Eigen::Vector2d middle = side.cwiseProduct(Eigen::Vector2d(i - 0.5, j - 0.5));
  const Eigen::Vector2d half = 0.5 * Eigen::Vector2d(board.marker_m, board.marker_m * board.aspect);
  return around(middle - half, middle + half);
}

std::vector<SeenMarker> find_markers(const Image& grey, const BoardSpec& board, SearchWork& work) {
  if (board.kind != BoardKind::aprilgrid) return find_with_border(grey, board, kMarkerBorder, work);
  auto tags = find_with_border(grey, board, kTagBorder, work);
  return tags.empty() ? find_with_border(grey, board, kMarkerBorder, work) : tags;
}

}  // namespace furrow::target
