#include "furrow/target/board.h"

#include <array>
#include <cmath>
#include <map>

#include "furrow/base/fields.h"
#include "furrow/base/file.h"
#include "furrow/base/text.h"
#include "furrow/base/value.h"
#include "target/markers.h"

namespace furrow::target {
namespace {

/// A board this large would be a wall: the number is in millimetres.
constexpr double kLargestSquare_m = 1.0;
/// Two homographies' worth of points need three corners a side; a thousand is no board that fits in a
/// picture.
constexpr int kFewestCorners = 3, kMostCorners = 1000;
/// A monitor's or a stretched print's squares stay within this.
constexpr double kLargestAspect = 2.0;
/// Tags further apart than twice their side are no grid that anybody prints.
constexpr double kWidestSpacing = 2.0;

Error invalid(const std::string& where, const std::string& found, const std::string& wanted,
              const std::string& hint = "") {
  return {"board_invalid", where, found, wanted, hint};
}

/// The two whole numbers of a list like `corners: [9, 6]`, each from `fewest`.
Result<std::array<int, 2>> pair_of_counts(const base::Value* list, int fewest, const std::string& where,
                                          const std::string& wanted) {
  if (list == nullptr || list->array() == nullptr || list->array()->size() != 2)
    return invalid(where, "no list of two counts", wanted);
  std::array<int, 2> out{};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto count = (*list->array())[i].integer();
    if (!count || *count < fewest || *count > kMostCorners) {
      return invalid(where, "a side without a count from " + std::to_string(fewest) + " to 1000", wanted,
                     "count corners between squares, not squares");
    }
    out[i] = static_cast<int>(*count);
  }
  return out;
}

Status check_fields(base::Fields& fields, const std::string& name) {
  const Status status = fields.finish();
  if (status.ok()) return status;
  Error error = status.error();
  error.code = "board_invalid";
  if (error.where.empty()) error.where = name;
  return error;
}

/// A file under a reader: its tree and name, for messages with lines.
struct Source {
  const base::Value& tree;
  std::string name;

  std::string at(const std::string& key) const {
    const base::Value* value = tree.find(key);
    return name + (value != nullptr && value->line > 0 ? ":" + std::to_string(value->line) : "");
  }
};

Result<BoardSpec> parse_checkerboard(const Source& source, base::Fields& fields, BoardSpec board) {
  fields.required("square_m", board.square_m);
  const base::Value* counts = fields.member("corners");
  FURROW_DO(check_fields(fields, source.name));
  FURROW_TRY(const auto corners,
             pair_of_counts(counts, kFewestCorners, source.at("corners"),
                            "corners: [9, 6] (inner corners between the squares: columns, rows)"));
  board.corners_x = corners[0];
  board.corners_y = corners[1];
  return board;
}

Result<BoardSpec> parse_charuco(const Source& source, base::Fields& fields, BoardSpec board) {
  board.kind = BoardKind::charuco;
  fields.required("square_m", board.square_m);
  fields.required("marker_m", board.marker_m);
  fields.required("dictionary", board.dictionary);
  fields.optional("legacy_pattern", board.legacy_pattern);
  const base::Value* counts = fields.member("squares");
  FURROW_DO(check_fields(fields, source.name));
  FURROW_TRY(const auto squares, pair_of_counts(counts, kFewestCorners + 1, source.at("squares"),
                                                "squares: [11, 8] (squares: columns, rows)"));
  board.corners_x = squares[0] - 1;
  board.corners_y = squares[1] - 1;
  board.dictionary = dictionary_key(board.dictionary);
  return board;
}

Result<BoardSpec> parse_aprilgrid(const Source& source, base::Fields& fields, BoardSpec board) {
  board.kind = BoardKind::aprilgrid;
  board.dictionary = "apriltag_36h11";
  int columns = 0, rows = 0;
  double spacing = 0.0;
  fields.required("tagCols", columns);
  fields.required("tagRows", rows);
  fields.required("tagSize", board.square_m);
  fields.required("tagSpacing", spacing);
  FURROW_DO(check_fields(fields, source.name));
  for (const auto& [key, count] : {std::pair{"tagCols", columns}, {"tagRows", rows}}) {
    if (count < 2 || count > kMostCorners / 2)
      return invalid(source.at(key), std::to_string(count) + " tags", "2 to 500 a side");
  }
  if (!(spacing > 0.0 && spacing <= kWidestSpacing)) {
    return invalid(source.at("tagSpacing"), base::format_double(spacing),
                   "the gap between two tags over a tag's side, above 0 to 2 (Kalibr's own boards have 0.3)");
  }
  board.corners_x = 2 * columns;
  board.corners_y = 2 * rows;
  board.gap_m = spacing * board.square_m;
  return board;
}

/// Counts and names that the markers impose; what every board obeys has been checked.
Status validate_markers(const BoardSpec& board, const std::string& where) {
  const auto dictionary = find_dictionary(board.dictionary);
  if (!dictionary) return invalid(where, "the dictionary '" + board.dictionary + "'", dictionary_names());
  const int needed = marker_count(board);
  if (needed > dictionary->markers) {
    return invalid(where, std::to_string(needed) + " markers",
                   "at most the " + std::to_string(dictionary->markers) + " of " + board.dictionary,
                   "take a larger dictionary or fewer squares");
  }
  if (board.kind == BoardKind::aprilgrid) {
    if (board.corners_x % 2 == 0 && board.corners_y % 2 == 0 && board.gap_m > 0.0) return Done{};
    return invalid(where, "an AprilGrid of odd corners or without gaps", "two corners a tag, gaps above 0");
  }
  if (board.marker_m > 0.0 && board.marker_m < board.square_m) return Done{};
  return invalid(where, "a marker of " + base::format_double(board.marker_m) + " m",
                 "a length above 0 and below the square's " + base::format_double(board.square_m) + " m");
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
  return board.kind == BoardKind::checkerboard ? Status(Done{}) : validate_markers(board, where);
}

Result<BoardSpec> parse_board(const std::string& text, const std::string& name) {
  FURROW_TRY(const base::Value tree, base::parse_yaml(text, name));
  const Source source{tree, name};
  BoardSpec board;
  board.name = std::filesystem::path(name).stem().string();
  std::string type;
  base::Fields fields(tree, name, "");
  // Kalibr's files say target_type.
  fields.required(tree.find("target_type") != nullptr ? "target_type" : "type", type);
  fields.optional("aspect", board.aspect);
  fields.optional("name", board.name);
  const std::map<std::string, decltype(&parse_charuco)> readers{
      {"checkerboard", parse_checkerboard}, {"charuco", parse_charuco}, {"aprilgrid", parse_aprilgrid}};
  const auto reader = readers.find(type);
  if (!fields.ok()) return check_fields(fields, name).error();
  if (reader == readers.end())
    return invalid(source.at("type"), "type '" + type + "'", "checkerboard, charuco or aprilgrid");
  FURROW_TRY(board, reader->second(source, fields, board));
  const Status status = validate(board);
  if (!status.ok()) {
    Error error = status.error();
    error.where = source.at(board.kind == BoardKind::aprilgrid ? "tagSize" : "square_m");
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

Eigen::Vector3d corner_in_board(const BoardSpec& board, int i, int j) {
  const auto along = [&](int n) {
    return board.kind == BoardKind::aprilgrid
               ? n / 2 * (board.square_m + board.gap_m) + n % 2 * board.square_m
               : n * board.square_m;
  };
  return {along(i), along(j) * board.aspect, 0.0};
}

PrintedExtent printed_extent(const BoardSpec& board) {
  const Eigen::Vector2d last = corner_in_board(board, board.corners_x - 1, board.corners_y - 1).head<2>();
  // A square goes on beyond the inner corners; an AprilGrid's small squares beyond the outer tags.
  const double beyond = board.kind == BoardKind::aprilgrid ? board.gap_m : board.square_m;
  const Eigen::Vector2d margin(beyond, beyond * board.aspect);
  return {-margin, last + margin};
}

std::vector<Eigen::Vector3d> corners_in_board(const BoardSpec& board) {
  std::vector<Eigen::Vector3d> out;
  out.reserve(static_cast<std::size_t>(board.corners_x) * static_cast<std::size_t>(board.corners_y));
  for (int j = 0; j < board.corners_y; ++j) {
    for (int i = 0; i < board.corners_x; ++i) out.push_back(corner_in_board(board, i, j));
  }
  return out;
}

}  // namespace furrow::target
