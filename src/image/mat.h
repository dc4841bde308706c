#pragma once
#include <opencv2/core.hpp>

#include "furrow/image/image.h"

namespace furrow::image {

/// The picture's memory as a cv::Mat, channel order as it is. OpenCV has no const view, hence the cast;
/// callers only read.
inline cv::Mat view(const Image& picture) {
  return {picture.height, picture.width, CV_8UC(picture.channels),
          const_cast<std::uint8_t*>(picture.data.data())};
}

inline Image from_mat(const cv::Mat& mat) {
  Image picture = make_image(mat.cols, mat.rows, mat.channels());
  mat.copyTo(view(picture));
  return picture;
}

}  // namespace furrow::image
