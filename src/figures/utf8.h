#pragma once
#include <string>
#include <string_view>

namespace furrow::figures {

/// Characters of UTF-8 text. Whatever is no UTF-8 becomes U+FFFD, line ends and other controls become blanks:
/// names come from files.
std::u32string characters(std::string_view text);

/// The same as UTF-8 again: safe to hand to a text renderer.
std::string printable(std::string_view text);

}  // namespace furrow::figures
