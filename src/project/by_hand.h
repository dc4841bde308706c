#pragma once
#include <filesystem>
#include <vector>

#include "furrow/base/csv.h"
#include "furrow/figures/following.h"
#include "furrow/project/follow_job.h"

namespace furrow::project {

/// Deviations read by hand, joined with what the algorithms say of the same pictures.
class ByHand {
 public:
  /// Columns picture (a name, with or without its extension, or a number counted from 1), one of deviation_m,
  /// deviation_cm and deviation_px, and flight if there are several. Errors: file_*, csv_*, missing_column,
  /// bad_value (with the line).
  static Result<ByHand> read(const std::filesystem::path& file);
  /// Notes the algorithms' values where this picture was read by hand.
  void add(const FollowedPicture& picture, bool is_metric);
  /// Pictures in the file that the source did not show.
  std::size_t missing() const;
  const std::vector<figures::DeviationByHand>& flights() const { return flights_; }

 private:
  struct Place {
    std::size_t flight, at;
    bool is_found = false;
  };
  std::vector<figures::DeviationByHand> flights_;
  std::vector<std::pair<std::string, Place>> places_;  ///< by the file's picture cells, sorted
};

/// The table of thesis section 4: per flight and in all, and per method, the mean deviation, the mean error
/// against the hand and its standard deviation.
base::CsvTable by_hand_table(const std::vector<figures::DeviationByHand>& flights);

}  // namespace furrow::project
