#include "furrow/audit/budget.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "furrow/base/text.h"

namespace furrow::audit {
namespace {

/// Shares below this are of quantities held fixed.
constexpr double kNothing_m = 1e-6;

/// Causes in the order in which the refinement names them.
std::vector<std::string> causes_in(const std::vector<ShotBudget>& budgets) {
  std::vector<std::string> causes;
  for (const ShotBudget& budget : budgets) {
    for (const altitude::SigmaShare& share : budget.shares) {
      if (std::abs(share.sigma_m) < kNothing_m) continue;
      if (std::find(causes.begin(), causes.end(), share.cause) == causes.end()) causes.push_back(share.cause);
    }
  }
  return causes;
}

std::string number(double value) {
  return std::isfinite(value) ? base::format_fixed(value, 4) : std::string();
}

double sigma_by(const ShotBudget& budget, const std::string& cause) {
  for (const altitude::SigmaShare& share : budget.shares) {
    if (share.cause == cause) return share.sigma_m;
  }
  return std::nan("");
}

}  // namespace

base::CsvTable budget_table(const std::vector<ShotBudget>& budgets) {
  const auto causes = causes_in(budgets);
  base::CsvTable table;
  table.source = "budget.csv";
  table.columns = {"shot_id", "above_canopy_refined_m", "above_canopy_refined_sigma_m"};
  for (const std::string& cause : causes) table.columns.push_back("by_" + cause + "_m");
  for (const ShotBudget& budget : budgets) {
    auto& row = table.rows.emplace_back(std::vector<std::string>{
        budget.shot_id, number(budget.above_canopy_m.value), number(budget.above_canopy_m.sigma)});
    for (const std::string& cause : causes) row.push_back(number(sigma_by(budget, cause)));
  }
  return table;
}

std::vector<CauseShare> causes_of(const std::vector<ShotBudget>& budgets) {
  std::map<std::string, double> sums;
  double total = 0.0;
  for (const ShotBudget& budget : budgets) {
    if (!budget.above_canopy_m.usable()) continue;
    for (const altitude::SigmaShare& share : budget.shares) {
      const double relative = share.sigma_m / budget.above_canopy_m.value;
      sums[share.cause] += relative * std::abs(relative);
      total += relative * std::abs(relative);
    }
  }
  std::vector<CauseShare> causes;
  for (const auto& [cause, sum] : sums) {
    if (total > 0.0) causes.push_back({cause, sum / total});
  }
  std::stable_sort(causes.begin(), causes.end(), [](const CauseShare& a, const CauseShare& b) {
    return a.variance_share > b.variance_share;
  });
  return causes;
}

std::string cause_words(const std::string& cause) {
  static const std::map<std::string, std::string> kWords = {
      {"picture", "the scatter of the rows' edges in the picture"},
      {"plants", "rows that stand or grow off their place"},
      {"spacing", "the row spacing as the farm knows it"},
      {"half_width", "the half width of the rows as the farm knows it"},
      {"foliage", "the unknown depth and shape of the foliage"},
      {"ground", "the ground's waves between the rows ahead and those below"},
      {"outline", "how far the canopy's outline stands over the top that the farm names"},
      {"pitch", "the gimbal's pitch"},
      {"roll", "the gimbal's roll"},
      {"focal", "the camera's focal length and principal point"},
      {"distortion", "the lens's distortion"},
      {"terrain", "the slope of the ground"},
      {"other", "the other shots of the flight"}};
  const auto found = kWords.find(cause);
  return found == kWords.end() ? cause : found->second;
}

}  // namespace furrow::audit
