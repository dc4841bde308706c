#pragma once
#include <string>
#include <vector>

#include "furrow/altitude/shot_height.h"
#include "furrow/base/csv.h"

namespace furrow::audit {

/// One shot's refined height and where its sigma comes from.
struct ShotBudget {
  std::string shot_id;
  Estimate above_canopy_m;                   ///< unusable where there is no height
  std::vector<altitude::SigmaShare> shares;  ///< their squares add up to the square of the sigma
};

/// budget.csv: a row per shot with height, sigma and one column per cause (those that any shot has).
base::CsvTable budget_table(const std::vector<ShotBudget>& budgets);

/// A cause's part of the variance of all heights, the parts adding up to 1.
struct CauseShare {
  std::string cause;
  double variance_share = 0.0;
};

/// Causes over the whole flight, each shot's variance counted relative to its height squared; largest first.
std::vector<CauseShare> causes_of(const std::vector<ShotBudget>& budgets);

/// "rows that stand or grow off their place": the cause in words.
std::string cause_words(const std::string& cause);

}  // namespace furrow::audit
