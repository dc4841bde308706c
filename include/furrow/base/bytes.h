#pragma once

namespace furrow::base {

/// Whether no text holds this byte: control characters other than tabs and line ends.
constexpr bool is_control(char c) {
  constexpr char kDelete = 127;
  return (c >= 0 && c < ' ' && c != '\n' && c != '\r' && c != '\t') || c == kDelete;
}

}  // namespace furrow::base
