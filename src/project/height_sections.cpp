#include "project/height_sections.h"

#include <cmath>
#include <map>

#include "furrow/audit/legs.h"
#include "furrow/base/text.h"
#include "furrow/geom/angles.h"
#include "project/pages.h"

namespace furrow::project {
namespace {

using base::format_fixed;

/// Priors tighter than this hold a quantity fixed: the flight was not asked about it.
constexpr double kHeldSigma = 1e-6;

std::string quantity_words(const std::string& name) {
  static const std::map<std::string, std::string> kWords = {
      {"row_spacing", "the row spacing"},
      {"half_width", "the half width of the rows"},
      {"foliage_depth", "the depth of the foliage"},
      {"base_ratio", "how wide the rows are at their foot"},
      {"rounding", "how round the tops of the rows are"},
      {"softness", "how gradually the canopy thins out at its edge"},
      {"pitch_bias", "the bias of the gimbal's pitch"},
      {"roll_bias", "the bias of the gimbal's roll"},
      {"terrain_slope", "the mean slope of the ground"},
      {"focal_factor", "the focal length"}};
  const auto found = kWords.find(name);
  return found == kWords.end() ? name : found->second;
}

/// What the flight says of a quantity, by what is left of its sigma.
std::string verdict_words(const altitude::SharedQuantity& q) {
  constexpr double kNothing = 0.9, kLittle = 0.5, kOneNumber = 0.9;
  const std::string what = quantity_words(q.name);
  if (q.sigma_ratio > kNothing) return "The flight says nothing about " + what + ".";
  std::string words =
      (q.sigma_ratio > kLittle ? "The flight says a little about " : "The flight tells ") + what;
  if (std::abs(q.correlation) > kOneNumber)
    words += ", but only together with " + quantity_words(q.most_correlated);
  return words + ".";
}

std::vector<std::string> shared_row(const altitude::SharedQuantity& q) {
  const double unit = q.name.ends_with("_bias") || q.name == "terrain_slope" ? geom::rad_to_deg(1.0) : 1.0;
  return {q.name,
          with_sigma(unit * q.prior.value, unit * q.prior.sigma, 3),
          with_sigma(unit * q.posterior.value, unit * q.posterior.sigma, 3),
          format_fixed(q.sigma_ratio, 2),
          q.most_correlated,
          format_fixed(q.correlation, 2),
          verdict_words(q)};
}

std::string percent(double share) {
  return format_fixed(100.0 * share, 0) + " %";
}

/// The sentence that names the largest cause.
std::string largest_cause(const std::vector<audit::CauseShare>& causes) {
  std::string words = "The largest cause of the heights' uncertainty is " +
                      audit::cause_words(causes[0].cause) + ": " + percent(causes[0].variance_share) +
                      " of the variance";
  if (causes.size() > 1) {
    words +=
        "; next is " + audit::cause_words(causes[1].cause) + " with " + percent(causes[1].variance_share);
  }
  return words + ".";
}

}  // namespace

report::Section flight_section(const Result<altitude::RefinedFlight>& flight) {
  report::Section section;
  section.title = "The flight as a whole";
  if (const auto failure = altitude::failure_of(flight)) {
    section.paragraphs = {"Not refined as a whole: " + failure->message()};
    return section;
  }
  section.paragraphs = {
      "All shots were refined at once; gimbal bias and the farm's numbers are common to them. The sigma "
      "ratio "
      "is the sigma after the flight over the one before: near 1, the pictures tell nothing beyond what was "
      "known. A correlation near 1 or -1 says that only the two together are told.",
      flight->termination + " after " + std::to_string(flight->iterations) + " iterations."};
  report::PageTable table;
  table.caption = "Shared quantities (angles in degrees, lengths in metres)";
  table.cells.columns = {"quantity",    "before",  "after", "sigma ratio", "most correlated with",
                         "correlation", "in words"};
  std::string held;
  for (const altitude::SharedQuantity& q : flight->shared) {
    if (q.prior.sigma > kHeldSigma) {
      table.cells.rows.push_back(shared_row(q));
    } else {
      held += (held.empty() ? "" : ", ") + quantity_words(q.name);
    }
  }
  if (!held.empty()) section.paragraphs.push_back("Held fixed: " + held + ".");
  section.tables = {std::move(table)};
  return section;
}

report::Section legs_section(const std::vector<audit::ShotRecord>& records, double row_height_m,
                             std::vector<figures::Figure> figures) {
  report::Section section;
  section.title = "By legs of the flight";
  section.paragraphs = {
      "Stretches at one height of the log, counted as the thesis did: mean height above ground, and mean and "
      "standard deviation of estimate minus log. The log's zero is the take-off point and its barometer "
      "drifts, so this error is of both; where the truth is known, the errors against it stand beside."};
  report::PageTable table{
      "Mean height above ground; mean error and standard deviation against the log and the truth",
      audit::leg_table(records, row_height_m)};
  if (table.cells.rows.empty()) {
    section.paragraphs = {
        "No table: it needs a log with heights and the height of the rows (rows.height_m)."};
  } else {
    section.tables = {std::move(table)};
  }
  section.figures = std::move(figures);
  return section;
}

report::Section budget_section(const std::vector<audit::ShotBudget>& budgets,
                               std::vector<figures::Figure> figures) {
  report::Section section;
  section.title = "Error budget";
  const auto causes = audit::causes_of(budgets);
  section.paragraphs = {causes.empty() ? "No shot has a height, so there is nothing to split."
                                       : largest_cause(causes)};
  if (causes.empty()) return section;
  report::PageTable table{"Part of the variance of all heights, by cause", {}};
  table.cells.columns = {"cause", "in words", "part / %"};
  for (const audit::CauseShare& share : causes) {
    constexpr double kShown = 0.0005;
    if (std::abs(share.variance_share) < kShown) continue;
    table.cells.rows.push_back(
        {share.cause, audit::cause_words(share.cause), format_fixed(100.0 * share.variance_share, 1)});
  }
  section.paragraphs.push_back("budget.csv has every shot.");
  section.tables = {std::move(table)};
  section.figures = std::move(figures);
  return section;
}

report::Section fusion_section(const std::vector<audit::ShotRecord>& records,
                               const Result<audit::FlightFusion>& fusion,
                               std::vector<figures::Figure> figures) {
  report::Section section;
  section.title = "Fusion";
  if (!fusion.ok()) {
    section.paragraphs = {"Not fused: " + fusion.error().message()};
    return section;
  }
  section.paragraphs = {
      "Rows, barometer, downward sensor and GNSS of the log, smoothed together; the bias of each source and "
      "the "
      "rise of the ground are estimated, and readings too far from the others are left out. The rows' "
      "heights "
      "are those of the pictures alone, without the log's steps. fusion.csv has every reading."};
  if (fusion->fused.surface_open) {
    section.paragraphs.push_back(
        "Only the downward sensor fixes the height, and it never changed its level: whether it saw leaves or "
        "soil is not known, and the sigma includes the height of the rows.");
  }
  if (const std::string rise = audit::rise_words(*fusion); !rise.empty()) section.paragraphs.push_back(rise);
  section.tables = {{"Sources", audit::sources_table(*fusion)},
                    {"Each source switched off", audit::trials_table(*fusion)}};
  const auto comparison = audit::compare_fusion(records, *fusion);
  if (!comparison.empty()) {
    section.tables.push_back(
        {"Against the truth of the simulation (estimate - truth)", audit::comparison_table(comparison)});
  }
  section.figures = std::move(figures);
  return section;
}

}  // namespace furrow::project
