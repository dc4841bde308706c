#include "project/follow_outputs.h"

#include <cmath>
#include <limits>

#include "furrow/base/text.h"
#include "furrow/geom/angles.h"

namespace furrow::project {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Metres to a tenth of a millimetre, px to a thousandth: far below any sigma.
base::Value rounded(double value, double scale = 1e4) {
  return std::isfinite(value) ? base::Value(std::round(value * scale) / scale) : base::Value();
}
base::Value rounded(const std::optional<double>& value) {
  return rounded(value.value_or(kNaN));
}
base::Value whole(const std::optional<int>& value) {
  return value ? base::Value(*value) : base::Value();
}

void add_estimate(base::Value& line, const std::string& name, const std::string& unit,
                  const std::optional<Estimate>& estimate, double scale = 1.0) {
  line.set(name + unit, rounded(estimate ? scale * estimate->value : kNaN));
  line.set(name + "_sigma" + unit, rounded(estimate ? scale * estimate->sigma : kNaN));
}

const char* event_name(follow::RowEvent event) {
  switch (event) {
    case follow::RowEvent::started:
      return "started";
    case follow::RowEvent::changed:
      return "changed";
    default:
      return "";
  }
}

const char* intake_name(follow::Intake intake) {
  switch (intake) {
    case follow::Intake::used:
      return "used";
    case follow::Intake::left_out:
      return "left_out";
    case follow::Intake::restarted:
      return "restarted";
    default:
      return "nothing";
  }
}

std::string csv_cell(const base::Value& value) {
  if (value.is_null()) return "";
  if (const std::string* text = value.string()) return *text;
  return base::to_json(value, -1);
}

std::string csv_line(const base::Value& value, bool is_header) {
  base::CsvTable table;
  for (const auto& [key, cell] : *value.object()) table.columns.push_back(is_header ? key : csv_cell(cell));
  return base::to_csv(table);
}

void add_thesis(base::Value& line, const follow::Following& f) {
  line.set("deviation_px", rounded(f.thesis.deviation_px));
  line.set("average_px", rounded(f.thesis.average_px));
  line.set("steer_px", rounded(f.thesis.steer_px));
  line.set("half_width_px", rounded(f.sighting.half_width_px ? f.sighting.half_width_px->value : kNaN));
  line.set("deviation_cm", rounded(f.deviation_cm));
  line.set("steer_cm", rounded(f.steer_cm));
}

void add_filtered(base::Value& line, const follow::Following& f, bool is_metric) {
  const std::string name = is_metric ? "cross_track" : "offset", unit = is_metric ? "_m" : "_px";
  add_estimate(line, "measured_" + name, unit, f.measured);
  add_estimate(line, name, unit, f.offset);
  line.set("intake", intake_name(f.offset_filter.intake));
  if (!is_metric) return;
  const double degrees = geom::rad_to_deg(1.0);
  add_estimate(line, "measured_heading", "_deg", f.sighting.heading_rad, degrees);
  add_estimate(line, "heading", "_deg", f.heading_rad, degrees);
}

}  // namespace

base::Value followed_value(const FollowedPicture& picture, bool is_metric) {
  const follow::Following& f = picture.following;
  base::Value line;
  line.set("picture", picture.name);
  line.set("index", picture.index);
  line.set("t_s", rounded(base::ns_to_seconds(f.sighting.t_video_ns), 1e6));
  line.set("status", f.sighting.status);
  line.set("reason", f.sighting.reason);
  line.set("confidence", rounded(picture.confidence));
  line.set("steer", f.is_hold ? "hold" : "follow");
  line.set("hold_reason", f.hold_reason);
  line.set("row", whole(f.row));
  line.set("nearest_row", whole(f.nearest_row));
  line.set("row_count", f.count);
  line.set("row_event", event_name(f.event));
  add_thesis(line, f);
  add_filtered(line, f, is_metric);
  const follow::BodyVelocity& v = f.guidance.velocity;
  line.set("forward_mps", rounded(v.forward_mps));
  line.set("right_mps", rounded(v.right_mps));
  line.set("yaw_rate_deg_s", rounded(geom::rad_to_deg(v.yaw_rate_rad_s)));
  return line;
}

void SteeringSender::send(const follow::Following& following) {
  const base::Nanoseconds t = following.sighting.t_video_ns;
  if (!last_heartbeat_ || t - *last_heartbeat_ >= base::kNanosecondsPerSecond) {
    link_.send(follow::heartbeat_frame(address_, sequence_++));
    last_heartbeat_ = t;
  }
  const auto since_start_ms = static_cast<std::uint32_t>(t / 1'000'000);
  link_.send(follow::velocity_frame(address_, sequence_++, since_start_ms, following.guidance.velocity));
}

FollowFiles::FollowFiles(const FollowJobOptions& options, double rate_hz, base::PartFile csv)
    : options_(&options), rate_hz_(rate_hz), csv_file_(std::move(csv)), csv_(csv_file_.temporary()) {
  curves_.is_metric = options.follower.is_metric;
}

Result<FollowFiles> FollowFiles::create(const FollowJobOptions& options, double nominal_rate_hz) {
  FURROW_TRY(base::PartFile csv, base::PartFile::create(*options.out / "follow.csv"));
  FollowFiles files(options, nominal_rate_hz, std::move(csv));
  if (!files.csv_)
    return Error{"file_unwritable", (*options.out / "follow.csv").string(), "cannot be opened", "", ""};
  return files;
}

void FollowFiles::keep_for_figure(const follow::Following& f) {
  // A figure shows no more; an hour's pictures are thinned evenly as they come.
  constexpr std::size_t kMostPoints = 2000;
  if (since_kept_++ % keep_every_ != 0) return;
  const double filtered = f.offset ? f.offset->value : kNaN, sigma = f.offset ? f.offset->sigma : kNaN;
  const std::optional<double> steer = curves_.is_metric ? f.steer_cm : f.thesis.steer_px;
  const bool guides = !f.guidance.is_hold;
  curves_.t_s.push_back(base::ns_to_seconds(f.sighting.t_video_ns));
  curves_.measured.push_back(f.measured.value);
  curves_.filtered.push_back(filtered);
  curves_.filtered_sigma.push_back(sigma);
  curves_.thesis_steer.push_back(steer ? (curves_.is_metric ? *steer / 100.0 : *steer) : kNaN);
  curves_.right_mps.push_back(guides ? f.guidance.velocity.right_mps : kNaN);
  curves_.is_hold.push_back(f.is_hold);
  if (curves_.t_s.size() <= kMostPoints) return;
  keep_every_ *= 2;
  const auto thin = [](auto& values) {
    for (std::size_t i = 0; 2 * i < values.size(); ++i) values[i] = values[2 * i];
    values.resize((values.size() + 1) / 2);
  };
  for (auto* values : {&curves_.t_s, &curves_.measured, &curves_.filtered, &curves_.filtered_sigma,
                       &curves_.thesis_steer, &curves_.right_mps})
    thin(*values);
  thin(curves_.is_hold);
}

Status FollowFiles::add(const FollowedPicture& picture, SeenPicture seen) {
  const base::Value line = followed_value(picture, curves_.is_metric);
  if (csv_.tellp() == 0) csv_ << csv_line(line, true);
  csv_ << csv_line(line, false);
  if (!csv_)
    return Error{"file_unwritable", (*options_->out / "follow.csv").string(), "writing stopped: disk full?",
                 "", ""};
  keep_for_figure(picture.following);
  const Image& shown = seen.source.picture;
  if (!options_->overlay || shown.empty()) return Done{};
  if (!overlay_) {
    FURROW_TRY(image::VideoWriter writer, image::VideoWriter::create(*options_->out / "overlay.mp4",
                                                                     shown.width, shown.height, rate_hz_));
    overlay_ = std::make_unique<OverlayVideo>(std::move(writer), options_->follower);
  }
  return overlay_->add({std::move(seen.source.picture), std::move(seen.lines), picture.following});
}

Result<std::vector<std::string>> FollowFiles::finish() {
  std::vector<std::string> names;
  csv_.close();
  if (!csv_)
    return Error{"file_unwritable", (*options_->out / "follow.csv").string(), "cannot be finished", "", ""};
  FURROW_DO(csv_file_.commit());
  names.push_back("follow.csv");
  if (overlay_) {
    FURROW_DO(overlay_->finish());
    names.push_back("overlay.mp4");
  }
  if (curves_.t_s.empty()) return names;
  FURROW_TRY(const figures::Figure figure, figures::following_over_time(curves_));
  FURROW_DO(figures::write_figure(*options_->out / "figures", figure));
  names.push_back("figures/" + figure.name + ".png");
  return names;
}

}  // namespace furrow::project
