#include "furrow/sync/locate.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>

#include "furrow/base/text.h"
#include "furrow/telemetry/sample_fields.h"

namespace furrow::sync {
namespace {

using base::Nanoseconds;
using telemetry::Sample;
using telemetry::Shot;
using telemetry::Track;

/// EXIF cuts a picture's time to whole seconds.
constexpr Nanoseconds kExifResolution_ns = base::kNanosecondsPerSecond;
/// A log may set its photo mark up to a few rows (0.1 s each) off the exposure.
constexpr Nanoseconds kMarkJitter_ns = base::kNanosecondsPerSecond / 2;
/// mark - picture time may spread so much over the shots of one flight.
constexpr Nanoseconds kPatternSlack_ns = kExifResolution_ns + kMarkJitter_ns;
/// Gimbal pitch in log and picture come from the same sensor; DJI writes both to 0.1 deg.
constexpr double kGimbalSlack_deg = 3.0;

using Times = std::vector<std::optional<Nanoseconds>>;

std::vector<Nanoseconds> photo_marks(const Track& track) {
  std::vector<Nanoseconds> marks;
  for (const Sample& s : track.samples)
    if (s.is_photo) marks.push_back(s.t_log_ns);
  return marks;
}

template <class Has>
std::size_t count_shots(const std::vector<Shot>& shots, Has has) {
  return static_cast<std::size_t>(std::count_if(shots.begin(), shots.end(), has));
}
bool has_utc(const Shot& shot) {
  return shot.metadata.t_utc_ns.has_value();
}
bool has_local(const Shot& shot) {
  return shot.t_camera_local_ns.has_value();
}
bool has_gimbal(const Shot& shot) {
  return !std::isnan(shot.metadata.gimbal_pitch_deg);
}

/// Places of the shots in the order of their own clock; as given when one has no time.
std::vector<std::size_t> time_order(const std::vector<Shot>& shots) {
  std::vector<std::size_t> order(shots.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (count_shots(shots, has_local) == shots.size())
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return *shots[a].t_camera_local_ns < *shots[b].t_camera_local_ns;
    });
  return order;
}

/// Log time of a reading of another clock that the log carries in `field`; nothing outside.
std::optional<Nanoseconds> to_log_time(const Track& track, std::optional<Nanoseconds> Sample::*field,
                                       Nanoseconds t) {
  const Sample* before = nullptr;
  for (const Sample& s : track.samples) {
    const auto& clock = s.*field;
    if (!clock) continue;
    if (*clock == t) return s.t_log_ns;
    if (*clock > t) {
      if (before == nullptr) return std::nullopt;
      const double w =
          static_cast<double>(t - *(before->*field)) / static_cast<double>(*clock - *(before->*field));
      return before->t_log_ns +
             static_cast<Nanoseconds>(std::llround(w * static_cast<double>(s.t_log_ns - before->t_log_ns)));
    }
    before = &s;
  }
  return std::nullopt;
}

Times by_clock(const std::vector<Shot>& shots, const Track& track, std::optional<Nanoseconds> Sample::*field,
               const std::function<std::optional<Nanoseconds>(const Shot&)>& clock) {
  Times times;
  for (const Shot& shot : shots) {
    const auto t = clock(shot);
    times.push_back(t ? to_log_time(track, field, *t) : std::nullopt);
  }
  return times;
}

bool any(const Times& times) {
  return std::any_of(times.begin(), times.end(), [](const auto& t) { return t.has_value(); });
}
bool all(const Times& times) {
  return std::all_of(times.begin(), times.end(), [](const auto& t) { return t.has_value(); });
}

/// One mark per shot (in time order) such that mark - picture time varies by no more than kPatternSlack_ns,
/// with the first shot at the mark `first`; empty when there is none.
std::vector<std::size_t> follow_pattern(const std::vector<Nanoseconds>& local,
                                        const std::vector<Nanoseconds>& marks, std::size_t first) {
  std::vector<std::size_t> chosen{first};
  Nanoseconds low = marks[first] - local[0], high = low;
  for (std::size_t i = 1; i < local.size(); ++i) {
    const Nanoseconds expected = local[i] + (low + high) / 2;
    std::size_t best = marks.size();
    for (std::size_t k = chosen.back() + 1; k < marks.size(); ++k)
      if (best == marks.size() || std::abs(marks[k] - expected) < std::abs(marks[best] - expected)) best = k;
    if (best == marks.size()) return {};
    low = std::min(low, marks[best] - local[i]);
    high = std::max(high, marks[best] - local[i]);
    if (high - low > kPatternSlack_ns) return {};
    chosen.push_back(best);
  }
  return chosen;
}

/// Log times of the shots when exactly one choice among the marks has the pattern of the pictures' own times.
/// Pictures without a time (unreadable ones) stay without a place as long as most have one.
std::optional<Times> by_pattern(const std::vector<Shot>& shots, const std::vector<Nanoseconds>& marks) {
  constexpr std::size_t kFewest = 3;  // two shots are one difference: any two marks so far apart would do
  std::vector<std::size_t> timed;
  for (std::size_t i = 0; i < shots.size(); ++i)
    if (has_local(shots[i])) timed.push_back(i);
  if (timed.size() < kFewest || 2 * timed.size() <= shots.size() || timed.size() > marks.size())
    return std::nullopt;
  std::stable_sort(timed.begin(), timed.end(), [&](std::size_t a, std::size_t b) {
    return *shots[a].t_camera_local_ns < *shots[b].t_camera_local_ns;
  });
  std::vector<Nanoseconds> local;
  local.reserve(timed.size());
  for (const std::size_t i : timed) local.push_back(*shots[i].t_camera_local_ns);
  std::set<std::vector<std::size_t>> choices;
  for (std::size_t first = 0; first + timed.size() <= marks.size(); ++first)
    if (auto chosen = follow_pattern(local, marks, first); !chosen.empty()) choices.insert(std::move(chosen));
  if (choices.size() != 1) return std::nullopt;
  Times times(shots.size());
  for (std::size_t i = 0; i < timed.size(); ++i) times[timed[i]] = marks[(*choices.begin())[i]];
  return times;
}

/// The i-th shot in time at the i-th mark; says so when the pictures' own times disagree.
Times by_count(const std::vector<Shot>& shots, const std::vector<Nanoseconds>& marks,
               std::vector<std::string>& warnings) {
  const auto order = time_order(shots);
  Times times(shots.size());
  for (std::size_t i = 0; i < order.size(); ++i) times[order[i]] = marks[i];
  if (!std::is_sorted(order.begin(), order.end()))
    warnings.push_back(
        "the pictures' names are not in the order of their times; they were put to the photo marks by time");
  if (count_shots(shots, has_local) != shots.size()) return times;
  std::vector<Nanoseconds> difference;
  difference.reserve(order.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    difference.push_back(marks[i] - *shots[order[i]].t_camera_local_ns);
  auto sorted = difference;
  std::sort(sorted.begin(), sorted.end());
  const Nanoseconds median = sorted[sorted.size() / 2];
  std::size_t off = 0, worst = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (std::abs(difference[i] - median) > kPatternSlack_ns) ++off;
    if (std::abs(difference[i] - median) > std::abs(difference[worst] - median)) worst = i;
  }
  if (off > 0)
    warnings.push_back(
        std::to_string(off) + " of " + std::to_string(shots.size()) +
        " pictures were taken at other times than their photo marks, by their own clock; worst " +
        shots[order[worst]].shot_id + " by " +
        base::format_fixed(base::ns_to_seconds(difference[worst] - median), 1) +
        " s: check that pictures and log belong together");
  return times;
}

/// Numbers that the log lacks, from the picture itself.
void fill_missing(Sample& state, const Sample& metadata) {
  for (const auto& fields :
       {std::vector<double Sample::*>(telemetry::kLinearFields.begin(), telemetry::kLinearFields.end()),
        std::vector<double Sample::*>(telemetry::kHeadingFields.begin(), telemetry::kHeadingFields.end()),
        std::vector<double Sample::*>(telemetry::kSignedAngleFields.begin(),
                                      telemetry::kSignedAngleFields.end())})
    for (const auto field : fields)
      if (std::isnan(state.*field)) state.*field = metadata.*field;
  if (!state.t_utc_ns) state.t_utc_ns = metadata.t_utc_ns;
}

/// The standard deviation of what is even over a step.
double step_sigma_s(double step_s) {
  return step_s / std::sqrt(12.0);
}

/// How well a mark in a row tells the moment: it came after the row before.
double row_sigma_s(const Track& track, Nanoseconds t_log_ns) {
  const auto row = std::lower_bound(track.samples.begin(), track.samples.end(), t_log_ns,
                                    [](const Sample& sample, Nanoseconds t) { return sample.t_log_ns < t; });
  if (row == track.samples.end() || row == track.samples.begin()) return telemetry::kMissing;
  return step_sigma_s(base::ns_to_seconds(row->t_log_ns - (row - 1)->t_log_ns));
}

/// How the times were found, for their sigma.
enum class Source { marks, utc, local };

Located place(const std::vector<Shot>& shots, const Track& track, const Times& times, Source source,
              std::string method, std::vector<std::string> warnings) {
  Located located{std::move(method), {}, std::move(warnings)};
  std::size_t gimbals_apart = 0;
  std::string first_apart;
  for (std::size_t i = 0; i < shots.size(); ++i) {
    ShotPose pose;
    pose.shot_id = shots[i].shot_id;
    pose.state = shots[i].metadata;
    const auto state = times[i] ? interpolate(track, *times[i]) : std::nullopt;
    if (state) {
      pose.located = true;
      pose.state = *state;
      pose.t_sigma_s = source == Source::marks ? row_sigma_s(track, *times[i])
                       : source == Source::utc ? track.utc_sigma_s
                                               : step_sigma_s(base::ns_to_seconds(kExifResolution_ns));
      if (std::abs(std::remainder(state->gimbal_pitch_deg - shots[i].metadata.gimbal_pitch_deg, 360.0)) >
              kGimbalSlack_deg &&
          gimbals_apart++ == 0)
        first_apart = shots[i].shot_id;
      fill_missing(pose.state, shots[i].metadata);
    } else {
      pose.reason = "its time is unknown or outside the log " + track.source;
    }
    located.poses.push_back(std::move(pose));
  }
  if (gimbals_apart > 0)
    located.warnings.push_back("gimbal pitch in log and picture differ by more than " +
                               base::format_fixed(kGimbalSlack_deg, 0) + " deg in " +
                               std::to_string(gimbals_apart) + " shots (first: " + first_apart + ")");
  return located;
}

Located metadata_only(const std::vector<Shot>& shots, std::vector<std::string> warnings) {
  Located located{"picture metadata only", {}, std::move(warnings)};
  for (const Shot& shot : shots) {
    ShotPose pose;
    pose.shot_id = shot.shot_id;
    pose.located = has_gimbal(shot);
    pose.state = shot.metadata;
    if (!pose.located) pose.reason = "no log, and no gimbal pitch in the picture";
    located.poses.push_back(std::move(pose));
  }
  return located;
}

/// "12 shots (12 with a local time, 0 with UTC, 0 with gimbal pitch), 10 photo marks in flight.csv"
std::string counts(const std::vector<Shot>& shots, const Track& track, std::size_t marks) {
  return std::to_string(shots.size()) + " shots (" + std::to_string(count_shots(shots, has_local)) +
         " with a local time, " + std::to_string(count_shots(shots, has_utc)) + " with UTC, " +
         std::to_string(count_shots(shots, has_gimbal)) + " with gimbal pitch) and " + std::to_string(marks) +
         " photo marks in " + track.source;
}

}  // namespace

Result<Located> locate_shots(const std::vector<Shot>& shots, const std::optional<Track>& track) {
  if (!track) return metadata_only(shots, {});
  const auto marks = photo_marks(*track);
  const auto utc = [](const Shot& shot) { return shot.metadata.t_utc_ns; };
  const Times by_utc = by_clock(shots, *track, &Sample::t_utc_ns, utc);
  if (count_shots(shots, has_utc) == shots.size() && any(by_utc))
    return place(shots, *track, by_utc, Source::utc, "picture time", {});
  if (!marks.empty() && marks.size() == shots.size()) {
    std::vector<std::string> warnings;
    const Times times = by_count(shots, marks, warnings);
    return place(shots, *track, times, Source::marks, "isPhoto marks", std::move(warnings));
  }
  const std::string what = counts(shots, *track, marks.size());
  if (const auto times = by_pattern(shots, marks))
    return place(shots, *track, *times, Source::marks, "isPhoto marks by time pattern",
                 {what + ": the shots were put to the only marks with the same time differences"});
  if (any(by_utc))
    return place(shots, *track, by_utc, Source::utc, "picture time",
                 {what + ": only the shots with UTC have a place"});
  const Times by_local =
      by_clock(shots, *track, &Sample::t_local_ns, [](const Shot& shot) { return shot.t_camera_local_ns; });
  if (!shots.empty() && all(by_local))
    return place(
        shots, *track, by_local, Source::local, "picture local time",
        {what + ": placed by local time, which is good to a second and takes both clocks to be in one zone"});
  if (count_shots(shots, has_gimbal) > 0) return metadata_only(shots, {what + ": the log could not be used"});
  return Error{"shots_not_locatable", track->source, what,
               "as many marks as shots, or pictures with times that fit the log",
               "Give only the pictures of this flight, or a log of it that marks its pictures."};
}

}  // namespace furrow::sync
