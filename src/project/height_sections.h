#pragma once
#include <vector>

#include "furrow/altitude/flight.h"
#include "furrow/audit/budget.h"
#include "furrow/audit/fusion.h"
#include "furrow/report/page.h"

namespace furrow::project {

/// "The flight as a whole": what it told of the quantities its shots share, in numbers and in words.
report::Section flight_section(const Result<altitude::RefinedFlight>& flight);

/// "By legs of the flight": the thesis's tables and figures.
report::Section legs_section(const std::vector<audit::ShotRecord>& records, double row_height_m,
                             std::vector<figures::Figure> figures);

/// "Error budget": the largest cause in a sentence, and the figure.
report::Section budget_section(const std::vector<audit::ShotBudget>& budgets,
                               std::vector<figures::Figure> figures);

/// "Fusion": all sources together, what each is worth, and the truth where there is one.
report::Section fusion_section(const std::vector<audit::ShotRecord>& records,
                               const Result<audit::FlightFusion>& fusion,
                               std::vector<figures::Figure> figures);

}  // namespace furrow::project
