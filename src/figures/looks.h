#pragma once
#include <string>

#include "figures/plot.h"

namespace furrow::figures {

// One look per source of a number, the same in every figure.

inline Series look(const std::string& name, Colour colour, double line_pt, Dash dash, Marker marker) {
  Series series;
  series.name = name;
  series.colour = colour;
  series.line_pt = line_pt;
  series.dash = std::move(dash);
  series.marker = marker;
  return series;
}

inline Series refined_look() {
  return look("refined from rows, \u00b11\u03c3", kBlue, 1.3, {}, Marker::circle);
}
inline Series log_look(const std::string& name) {
  return look(name, kOrange, 1.1, {5.0, 2.0}, Marker::square);
}
inline Series vps_look() {
  return look("VPS, above surface", kGreen, 1.0, {6.0, 1.8, 1.2, 1.8}, Marker::diamond);
}
inline Series thesis_look() {
  return look("thesis formula", kVermillion, 0.0, {}, Marker::triangle);
}
inline Series truth_look() {
  return look("truth", kBlack, 0.9, {}, Marker::ring);
}

}  // namespace furrow::figures
