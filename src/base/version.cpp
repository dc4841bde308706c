#include "furrow/base/version.h"

namespace furrow::base {

std::string version() {
  return FURROW_VERSION;
}

}  // namespace furrow::base
