#include "target/find.h"

#include <opencv2/calib3d.hpp>

namespace furrow::target {

std::optional<Grid> find_grid(const Image& grey, int columns, int rows) {
  const cv::Mat picture(grey.height, grey.width, CV_8U, const_cast<std::uint8_t*>(grey.data.data()));
  std::vector<cv::Point2f> corners;
  const cv::Size size(columns, rows);
  bool found = cv::findChessboardCorners(picture, size, corners,
                                         cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE);
  if (!found) found = cv::findChessboardCornersSB(picture, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE);
  if (!found) return std::nullopt;
  Grid grid{columns, rows, {}};
  for (const cv::Point2f& p : corners) grid.px.emplace_back(p.x, p.y);
  return grid;
}

}  // namespace furrow::target
