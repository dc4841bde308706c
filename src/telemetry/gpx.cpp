#include <algorithm>
#include <pugixml.hpp>

#include "furrow/base/text.h"
#include "furrow/telemetry/formats.h"
#include "reader_tools.h"

namespace furrow::telemetry {
namespace {

double number(const char* text) {
  return base::parse_double(text).value_or(kMissing);
}

/// Points that share a time are spread evenly up to the next one, or over a second at the end.
std::size_t spread_equal_times(std::vector<Sample>& samples) {
  std::size_t shared = 0;
  for (std::size_t begin = 0; begin < samples.size();) {
    std::size_t end = begin + 1;
    while (end < samples.size() && *samples[end].t_utc_ns == *samples[begin].t_utc_ns) ++end;
    const auto count = static_cast<base::Nanoseconds>(end - begin);
    base::Nanoseconds gap_ns = base::kNanosecondsPerSecond;
    if (end < samples.size())
      gap_ns = std::clamp(*samples[end].t_utc_ns - *samples[begin].t_utc_ns, base::Nanoseconds{0}, gap_ns);
    for (std::size_t i = begin + 1; i < end; ++i)
      *samples[i].t_utc_ns += gap_ns * static_cast<base::Nanoseconds>(i - begin) / count;
    shared += end - begin - 1;
    begin = end;
  }
  return shared;
}

}  // namespace

Result<Track> read_gpx(std::string_view text, const std::string& name) {
  pugi::xml_document document;
  const auto parsed = document.load_buffer(text.data(), text.size());
  Track track;
  track.source = name;
  track.format = "gpx";
  std::vector<int> points;
  std::size_t without_time = 0;
  int count = 0;
  for (const pugi::xml_node trk : document.child("gpx").children("trk"))
    for (const pugi::xml_node segment : trk.children("trkseg"))
      for (const pugi::xml_node point : segment.children("trkpt")) {
        ++count;
        Sample s;
        s.latitude_deg = number(point.attribute("lat").value());
        s.longitude_deg = number(point.attribute("lon").value());
        s.height_geoid_m = number(point.child("ele").text().get());
        s.speed_mps = number(point.child("speed").text().get());
        s.t_utc_ns = base::parse_date_time(point.child("time").text().get());
        if (!s.t_utc_ns) {
          ++without_time;
          continue;
        }
        track.samples.push_back(s);
        points.push_back(count);
      }
  if (track.samples.empty())
    return Error{"telemetry_empty", name, std::to_string(count) + " track points, none with a time",
                 "a GPX track with times",
                 parsed ? "" : std::string("The XML is broken: ") + parsed.description() + "."};
  if (!parsed)
    track.warnings.push_back(std::string("the XML breaks off (") + parsed.description() +
                             "): read up to there");
  if (without_time > 0)
    track.warnings.push_back(std::to_string(without_time) + " track points without a time: left out");
  if (const std::size_t shared = spread_equal_times(track.samples); shared > 0)
    track.warnings.push_back(std::to_string(shared) +
                             " track points share their second with another: spread evenly");
  track.warnings.emplace_back(
      "GPX does not say what 'ele' is measured from: taken as above the receiver's geoid");
  reader::log_time_from_utc(track);
  reader::finish(track, points);
  return track;
}

}  // namespace furrow::telemetry
