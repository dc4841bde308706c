#include "furrow/target/board.h"

#include <cmath>

#include "furrow/base/fields.h"
#include "furrow/base/file.h"
#include "furrow/base/text.h"
#include "furrow/base/value.h"

namespace furrow::target {
namespace {

/// A board this large would be a wall: the number is in millimetres.
constexpr double kLargestSquare_m = 1.0;
/// Two homographies' worth of points need three corners a side; a thousand is no board that fits in a
/// picture.
constexpr int kFewestCorners = 3, kMostCorners = 1000;
/// A monitor's or a stretched print's squares stay within this.
constexpr double kLargestAspect = 2.0;

Error invalid(const std::string& where, const std::string& found, const std::string& wanted,
              const std::string& hint = "") {
  return {"board_invalid", where, found, wanted, hint};
}

Result<int> corner_count(const base::Value& counts, std::size_t i, const std::string& where) {
  const auto count = (*counts.array())[i].integer();
  if (!count || *count < kFewestCorners || *count > kMostCorners) {
    return invalid(where, "a side without a count from 3 to 1000",
                   "the inner corners in a row and in a column",
                   "count corners between squares, not squares");
  }
  return static_cast<int>(*count);
}

Status check_fields(base::Fields& fields, const std::string& name) {
  const Status status = fields.finish();
  if (status.ok()) return status;
  Error error = status.error();
  error.code = "board_invalid";
  if (error.where.empty()) error.where = name;
  return error;
}

}  // namespace

Status validate(const BoardSpec& board) {
  const std::string where = board.name.empty() ? "board" : board.name;
  if (board.corners_x < kFewestCorners || board.corners_y < kFewestCorners ||
      board.corners_x > kMostCorners || board.corners_y > kMostCorners) {
    return invalid(where,
                   std::to_string(board.corners_x) + "x" + std::to_string(board.corners_y) + " inner corners",
                   "3 to 1000 a side", "count corners between squares, not squares");
  }
  if (!(board.square_m > 0.0) || !std::isfinite(board.square_m)) {
    return invalid(where, "a square of " + base::format_double(board.square_m) + " m",
                   "a length above 0 in metres");
  }
  if (board.square_m >= kLargestSquare_m) {
    return invalid(where, "a square of " + base::format_double(board.square_m) + " m", "less than 1 m",
                   "the unit is metres: 25 mm is 0.025");
  }
  if (!(board.aspect >= 1.0 / kLargestAspect && board.aspect <= kLargestAspect)) {
    return invalid(where, "an aspect of " + base::format_double(board.aspect),
                   "0.5 to 2; 1 for square squares");
  }
  return Done{};
}

Result<BoardSpec> parse_board(const std::string& text, const std::string& name) {
  FURROW_TRY(const base::Value tree, base::parse_yaml(text, name));
  BoardSpec board;
  board.name = std::filesystem::path(name).stem().string();
  std::string type;
  base::Fields fields(tree, name, "");
  fields.required("type", type);
  fields.required("square_m", board.square_m);
  fields.optional("aspect", board.aspect);
  fields.optional("name", board.name);
  const base::Value* counts = fields.member("corners");
  FURROW_DO(check_fields(fields, name));
  const std::string where =
      name + (tree.line > 0 && counts != nullptr ? ":" + std::to_string(counts->line) : "");
  if (type != "checkerboard") return invalid(name, "type '" + type + "'", "type: checkerboard");
  if (counts == nullptr || counts->array() == nullptr || counts->array()->size() != 2) {
    return invalid(where, "no list of two counts under `corners`",
                   "corners: [9, 6] (inner corners: columns, rows)");
  }
  FURROW_TRY(board.corners_x, corner_count(*counts, 0, where));
  FURROW_TRY(board.corners_y, corner_count(*counts, 1, where));
  Status status = validate(board);
  if (!status.ok()) {
    Error error = status.error();
    const base::Value* square = tree.find("square_m");
    error.where = name + (square != nullptr ? ":" + std::to_string(square->line) : "");
    return error;
  }
  return board;
}

Result<BoardSpec> read_board(const std::filesystem::path& file) {
  // A board is a few lines; anything larger is another file.
  constexpr std::size_t kLargestFileBytes = std::size_t{1} << 20;
  FURROW_TRY(const std::string text, base::read_file(file, kLargestFileBytes));
  return parse_board(text, file.string());
}

std::vector<Eigen::Vector3d> corners_in_board(const BoardSpec& board) {
  std::vector<Eigen::Vector3d> out;
  out.reserve(static_cast<std::size_t>(board.corners_x) * static_cast<std::size_t>(board.corners_y));
  for (int j = 0; j < board.corners_y; ++j) {
    for (int i = 0; i < board.corners_x; ++i)
      out.emplace_back(i * board.square_m, j * board.square_m * board.aspect, 0.0);
  }
  return out;
}

}  // namespace furrow::target
