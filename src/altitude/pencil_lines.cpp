#include "pencil_lines.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace furrow::altitude {
namespace {

/// An edge of fewer samples is a glimpse.
constexpr int kGlimpse = 6;

/// A row that shows no edge has grown into its neighbours, and where its middle lies is the detector's guess;
/// it counts only when there are not two rows with edges. Nor does a glimpse of an edge count beside rows
/// that show theirs: leaves in front of it and behind it decide what is seen.
std::vector<EdgeLine> prefer_edges(const std::vector<EdgeLine>& lines) {
  std::vector<EdgeLine> edges, clear;
  for (const EdgeLine& line : lines) {
    if (line.side == Side::centre) continue;
    edges.push_back(line);
    if (line.samples >= kGlimpse) clear.push_back(line);
  }
  if (distinct_rows(clear) >= 2) return clear;
  return distinct_rows(edges) >= 2 ? edges : lines;
}

/// Of a row alone: its two edges where both are clear; its middle says no more than they do.
std::vector<EdgeLine> single_row_lines(const std::vector<EdgeLine>& lines) {
  std::vector<EdgeLine> edges;
  for (const EdgeLine& line : lines) {
    if (line.side != Side::centre && line.samples >= kGlimpse) edges.push_back(line);
  }
  return edges.size() == 2 ? edges : lines;
}

}  // namespace

Error degenerate(const char* code, std::string found, std::string wanted) {
  return Error{code, "rows", std::move(found), std::move(wanted), ""};
}

Result<std::vector<EdgeLine>> usable_lines(const RowsOnUnitPlane& rows, bool may_be_one) {
  for (const RowsOnUnitPlane::Row& row : rows.rows) {
    for (const RowDirection& d : row.directions) {
      if (!d.centre.allFinite() || !std::isfinite(d.sigma)) {
        return degenerate("not_finite",
                          "a direction of row " + std::to_string(row.index) + " that is not finite",
                          "finite directions with finite sigmas");
      }
    }
  }
  std::vector<EdgeLine> lines = prefer_edges(reduce_to_lines(rows));
  const int distinct = distinct_rows(lines);
  if (distinct >= 2) return lines;
  if (may_be_one && rows.rows.size() == 1 && distinct == 1 && lines.front().row == 0)
    return single_row_lines(lines);
  const bool shared = rows.rows.size() >= 2 && !lines.empty();
  if (shared)
    return degenerate("ill_conditioned", "all rows share one index", "two or more rows that differ in index");
  return degenerate("not_enough_rows", std::to_string(distinct) + " row with two or more samples",
                    may_be_one ? "two or more rows, or one and the gimbal's pitch" : "two or more rows");
}

int distinct_rows(const std::vector<EdgeLine>& lines) {
  std::set<int> rows;
  for (const EdgeLine& line : lines) rows.insert(line.row);
  return static_cast<int>(rows.size());
}

double slope_at(const RowAxes<double>& axes, const EdgeLine& line) {
  const Eigen::Vector2d p = 0.5 * (line.points[0] + line.points[1]);
  const double lateral = axes.m.x * p.x() + axes.m.y * p.y() + axes.m.z;
  const double up = axes.q.x * p.x() + axes.q.y * p.y() + axes.q.z;
  return -lateral / up;
}

bool below_horizon(const RowAxes<double>& axes, const EdgeLine& line) {
  const Eigen::Vector2d p = 0.5 * (line.points[0] + line.points[1]);
  return axes.q.x * p.x() + axes.q.y * p.y() + axes.q.z < 0.0;
}

double side_of(const EdgeLine& line) {
  if (line.side == Side::centre) return 0.0;
  return line.side == Side::left ? 1.0 : -1.0;
}

bool is_top_edge(const EdgeLine& line, double slope) {
  return side_of(line) * slope >= 0.0;
}

void set_reaches(std::vector<EdgeLine>& lines, const RowAxes<double>& axes, double depth) {
  for (EdgeLine& line : lines) {
    const double side = side_of(line), t = depth * std::max(0.0, side * slope_at(axes, line));
    line.reach = side * (std::sqrt(1.0 + t * t) - t);
  }
}

std::vector<EdgeLine> top_lines(const std::vector<EdgeLine>& lines, const RowAxes<double>& axes) {
  std::vector<EdgeLine> tops;
  for (const EdgeLine& line : lines) {
    if (is_top_edge(line, slope_at(axes, line))) tops.push_back(line);
  }
  return distinct_rows(tops) >= 2 ? tops : lines;
}

}  // namespace furrow::altitude
