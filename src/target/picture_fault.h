#pragma once
#include <string>

#include "furrow/image/image.h"

namespace furrow::target {

/// What is wrong with a picture in which no board was found, for its reason: "overexposed: 62 % of it is
/// white", "too dark", "blurred: its sharpest edges are 3.4 px wide"; empty when nothing stands out.
std::string picture_fault(const Image& grey);

}  // namespace furrow::target
