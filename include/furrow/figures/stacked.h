#pragma once
#include <string>
#include <vector>

#include "furrow/altitude/plan.h"
#include "furrow/audit/budget.h"
#include "furrow/figures/figures.h"

namespace furrow::figures {

/// Sigma of the height over the shots, stacked by cause: each layer is as thick as its part of the variance,
/// so that all together are as high as the sigma. Errors: nothing_to_draw (no shot has a height).
Result<Figure> budget_over_shots(const std::vector<audit::ShotBudget>& budgets,
                                 const FigureOptions& options = {});

/// The same for planned shots, as a part of the height, over their pitch or height. Errors: nothing_to_draw.
Result<Figure> plan_over_pitch(const std::vector<altitude::PlannedShot>& plans,
                               const FigureOptions& options = {});
Result<Figure> plan_over_height(const std::vector<altitude::PlannedShot>& plans,
                                const FigureOptions& options = {});

}  // namespace furrow::figures
