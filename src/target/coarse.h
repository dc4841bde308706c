#pragma once
#include <Eigen/Core>

#include "furrow/image/image.h"

namespace furrow::target {

/// A smaller copy for searching, with what one of its pixels spans in the whole picture.
struct Coarse {
  Image grey;
  double su = 1.0, sv = 1.0;

  /// The place in the whole picture; pixel centres are whole numbers in both.
  Eigen::Vector2d in_whole(const Eigen::Vector2d& px) const {
    return {(px.x() + 0.5) * su - 0.5, (px.y() + 0.5) * sv - 0.5};
  }
};

/// A copy whose longer side is at most `longest_px`; the picture itself when it is no longer.
Coarse coarse_copy(const Image& grey, int longest_px);

}  // namespace furrow::target
