#include "furrow/base/result.h"

namespace furrow::base {

std::string Error::message() const {
  std::string text = where.empty() ? found : where + ": " + found;
  if (!wanted.empty()) text += "; wanted " + wanted;
  if (!text.empty() && text.back() != '.') text += '.';
  if (!hint.empty()) text += ' ' + hint;
  return text;
}

}  // namespace furrow::base
