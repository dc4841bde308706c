#include "denial.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "furrow/base/text.h"
#include "furrow/stats/robust.h"

namespace furrow::altitude {
namespace {

/// So many others must speak before they can deny a shot.
constexpr std::size_t kLeastOthers = 3;

/// So far off a right shot is twenty times less likely than one whose rows were miscounted and that fits
/// then.
constexpr double kMiscountSigmas = 2.5;

/// A shot's height above the log's level.
struct Offset {
  std::size_t shot = 0;
  Estimate above_log_m;
};

/// The middle of up to three offsets to each side of the i-th, and their scatter beyond what they claim.
Estimate middle_around(std::span<const Offset> offsets, std::size_t i) {
  constexpr std::size_t kToEachSide = 3;
  std::vector<double> values, claimed;
  for (std::size_t k = i - std::min(i, kToEachSide); k < std::min(offsets.size(), i + kToEachSide + 1); ++k) {
    if (k == i) continue;
    values.push_back(offsets[k].above_log_m.value);
    claimed.push_back(offsets[k].above_log_m.sigma);
  }
  const double scatter = stats::mad_sigma(values), claim = stats::median(claimed);
  const double beyond = std::sqrt(std::max(0.0, scatter * scatter - claim * claim));
  return Estimate{stats::median(values), beyond, static_cast<int>(values.size())};
}

/// Whether twice or half the height would suit the others: every second row was missed, or lines between rows
/// were counted.
bool is_miscount(double height_m, double off_m, double sigma_m) {
  return std::min(std::abs(off_m + height_m), std::abs(off_m - 0.5 * height_m)) < sigma_m;
}

constexpr const char* kLookAtRows =
    "a line that is no row may have been counted: look at the picture of its rows";

Error denied_fit(const JudgedShot& shot, JudgedIn field, double limit) {
  const std::string missed = field == JudgedIn::own_field
                                 ? "a field with the farm's numbers and the gimbal's angles"
                                 : "the field that the flight's shots show together";
  return Error{"rows_do_not_fit", shot.shot_id,
               "rows that miss " + missed + " by " + base::format_fixed(shot.residual_rms, 1) +
                   " sigmas, far more than the flight's other shots",
               "at most " + base::format_fixed(limit, 1), kLookAtRows};
}

Error denied_height(const JudgedShot& shot, const Estimate& middle, double off_m, double limit_m) {
  return Error{"denied_by_neighbours", shot.shot_id,
               "by its rows " + base::format_fixed(shot.height_above_canopy_m.value, 2) +
                   " m above the canopy, " + base::format_fixed(off_m, 2) + " m off what the log makes of " +
                   std::to_string(middle.observations) + " shots around it",
               "within " + base::format_fixed(limit_m, 2) + " m", kLookAtRows};
}

}  // namespace

std::vector<std::optional<Error>> denied_by_fit(const std::vector<JudgedShot>& shots, JudgedIn field,
                                                const FlightOptions& options) {
  std::vector<std::optional<Error>> errors(shots.size());
  if (shots.size() <= kLeastOthers) return errors;
  std::vector<double> rms;
  rms.reserve(shots.size());
  for (const JudgedShot& shot : shots) rms.push_back(shot.residual_rms);
  // Where all shots fit worse than they claim, the claim is wrong, not every shot.
  const double limit = options.misfit_over_others * std::max(1.0, stats::median(rms));
  for (std::size_t i = 0; i < shots.size(); ++i)
    if (shots[i].residual_rms > limit) errors[i] = denied_fit(shots[i], field, limit);
  return errors;
}

std::vector<std::optional<Error>> denied_shots(const std::vector<JudgedShot>& shots,
                                               const FlightOptions& options) {
  std::vector<std::optional<Error>> errors = denied_by_fit(shots, JudgedIn::own_field, options);
  std::vector<Offset> offsets;
  for (std::size_t i = 0; i < shots.size(); ++i) {
    if (errors[i]) continue;
    Estimate above_log = shots[i].height_above_canopy_m;
    above_log.value -= shots[i].log_height_m;
    if (above_log.usable()) offsets.push_back({i, above_log});
  }
  if (offsets.size() <= kLeastOthers) return errors;
  for (std::size_t k = 0; k < offsets.size(); ++k) {
    const Estimate middle = middle_around(offsets, k);
    const Estimate& own = offsets[k].above_log_m;
    const double off_m = own.value - middle.value;
    const double sigma_m = std::hypot(own.sigma, middle.sigma, options.log_step_sigma_m);
    const JudgedShot& shot = shots[offsets[k].shot];
    const bool miscount = is_miscount(shot.height_above_canopy_m.value, off_m, sigma_m);
    const double limit_m = sigma_m * (miscount ? std::min(kMiscountSigmas, options.neighbour_conflict_sigmas)
                                               : options.neighbour_conflict_sigmas);
    if (std::abs(off_m) > limit_m)
      errors[offsets[k].shot] = denied_height(shot, middle, std::abs(off_m), limit_m);
  }
  return errors;
}

}  // namespace furrow::altitude
