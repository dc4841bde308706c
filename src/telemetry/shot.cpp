#include "furrow/telemetry/shot.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal_priv.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <pugixml.hpp>

#include "furrow/base/file.h"
#include "furrow/base/text.h"
#include "reader_tools.h"

namespace furrow::telemetry {
namespace {

/// DJI's RtkFlag of a fixed solution (DJI, "Image metadata"): 16 single point, 32 to 49 float, 50 fixed.
constexpr double kRtkFixed = 50.0;
/// EXIF GPSAltitude and XMP AbsoluteAltitude are the same number, written by the same camera; more apart
/// means another program's hand.
constexpr double kAltitudeSlack_m = 1.0;
/// Below this a RelativeAltitude says no more than that the barometer's zero is somewhere near.
constexpr double kUselessHeight_m = 0.5;

using Tags = std::map<std::string, std::string, std::less<>>;

struct CloseDataset {
  void operator()(GDALDataset* dataset) const { GDALClose(dataset); }
};
using Dataset = std::unique_ptr<GDALDataset, CloseDataset>;

/// Opens a picture without looking at the files beside it.
Dataset open_picture(const std::filesystem::path& image) {
  static std::once_flag registered;
  std::call_once(registered, [] { GDALAllRegister(); });
  static constexpr const char* kDrivers[] = {"JPEG", "PNG", "GTiff", "BMP", "WEBP", nullptr};
  static constexpr const char* kNoSiblings[] = {nullptr};
  return Dataset(
      GDALDataset::Open(image.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, kDrivers, nullptr, kNoSiblings));
}

/// "EXIF_Model=FC7203" lines of one metadata domain.
void add_exif(GDALDataset& dataset, const char* domain, Tags& tags) {
  for (char** line = dataset.GetMetadata(domain); line != nullptr && *line != nullptr; ++line) {
    const std::string_view text(*line);
    const auto equals = text.find('=');
    if (text.starts_with("EXIF_") && equals != std::string_view::npos)
      tags.emplace(text.substr(0, equals), base::trim(text.substr(equals + 1)));
  }
}

/// Simple properties of an XMP packet, as attributes or as child elements of rdf:Description, by their usual
/// prefixes.
Tags xmp_tags(const char* packet) {
  Tags tags;
  pugi::xml_document document;
  // A packet cut short still gives what stands before the cut.
  document.load_string(packet);
  for (const pugi::xml_node meta : document.children())
    for (const pugi::xml_node rdf : meta.children())
      for (const pugi::xml_node description : rdf.children()) {
        for (const pugi::xml_attribute attribute : description.attributes())
          tags.emplace(attribute.name(), base::trim(attribute.value()));
        for (const pugi::xml_node child : description.children())
          tags.emplace(child.name(), base::trim(child.text().get()));
      }
  return tags;
}

double number(const Tags& tags, std::string_view key) {
  const auto found = tags.find(key);
  if (found == tags.end()) return kMissing;
  return base::parse_double(found->second).value_or(kMissing);
}

std::string text_of(const Tags& tags, std::string_view key) {
  const auto found = tags.find(key);
  return found == tags.end() ? std::string() : found->second;
}

double first_known(double a, double b) {
  return std::isnan(a) ? b : a;
}

/// The numbers of GDAL's "(45) (1) (53.7)".
std::vector<double> bracketed_numbers(std::string_view text) {
  std::vector<double> numbers;
  for (std::size_t open = text.find('('); open != std::string_view::npos; open = text.find('(', open + 1)) {
    const auto close = text.find(')', open);
    if (close == std::string_view::npos) break;
    const auto value = base::parse_double(text.substr(open + 1, close - open - 1));
    numbers.push_back(value.value_or(kMissing));
  }
  return numbers;
}

/// EXIF degrees, minutes and seconds with their hemisphere.
double exif_angle_deg(const Tags& exif, const std::string& key, char negative) {
  const auto dms = bracketed_numbers(text_of(exif, key));
  const std::string hemisphere = text_of(exif, key + "Ref");
  if (dms.size() != 3 || hemisphere.empty()) return kMissing;
  const double angle_deg = dms[0] + dms[1] / 60.0 + dms[2] / 3600.0;
  return hemisphere.front() == negative ? -angle_deg : angle_deg;
}

std::optional<base::Nanoseconds> exif_utc(const Tags& exif) {
  const auto day = base::parse_date_time(text_of(exif, "EXIF_GPSDateStamp") + " 00:00:00");
  const auto clock = bracketed_numbers(text_of(exif, "EXIF_GPSTimeStamp"));
  if (!day || clock.size() != 3) return std::nullopt;
  const double seconds = clock[0] * 3600.0 + clock[1] * 60.0 + clock[2];
  constexpr double kDay_s = 86401.0;
  if (!(seconds >= 0.0 && seconds < kDay_s)) return std::nullopt;
  return *day + base::seconds_to_ns(seconds);
}

void read_position(const Tags& exif, const Tags& xmp, Sample& s) {
  s.latitude_deg =
      first_known(number(xmp, "drone-dji:GpsLatitude"), exif_angle_deg(exif, "EXIF_GPSLatitude", 'S'));
  s.longitude_deg =
      first_known(first_known(number(xmp, "drone-dji:GpsLongitude"), number(xmp, "drone-dji:GpsLongtitude")),
                  exif_angle_deg(exif, "EXIF_GPSLongitude", 'W'));
}

void read_attitude(const Tags& xmp, Sample& s, std::vector<std::string>& warnings) {
  s.yaw_deg = number(xmp, "drone-dji:FlightYawDegree");
  s.pitch_deg = number(xmp, "drone-dji:FlightPitchDegree");
  s.roll_deg = number(xmp, "drone-dji:FlightRollDegree");
  s.gimbal_heading_deg = number(xmp, "drone-dji:GimbalYawDegree");
  s.gimbal_pitch_deg = number(xmp, "drone-dji:GimbalPitchDegree");
  s.gimbal_roll_deg = number(xmp, "drone-dji:GimbalRollDegree");
  if (s.gimbal_heading_deg == 0.0 && s.gimbal_pitch_deg == 0.0 && s.gimbal_roll_deg == 0.0) {
    s.gimbal_heading_deg = s.gimbal_pitch_deg = s.gimbal_roll_deg = kMissing;
    warnings.push_back(
        "all gimbal angles are exactly 0: taken as unknown (programs that rewrite XMP leave them so)");
  }
  if (!std::isnan(s.gimbal_pitch_deg) || !xmp.contains("Camera:Pitch")) return;
  constexpr double kNadirPitch_deg = -90.0;  // Pix4D's Camera:Pitch is 0 straight down and 90 forward
  s.gimbal_pitch_deg = number(xmp, "Camera:Pitch") + kNadirPitch_deg;
  s.gimbal_heading_deg = number(xmp, "Camera:Yaw");
  s.gimbal_roll_deg = number(xmp, "Camera:Roll");
}

void read_heights(const Tags& exif, const Tags& xmp, Sample& s, std::vector<std::string>& warnings) {
  s.height_takeoff_m = number(xmp, "drone-dji:RelativeAltitude");
  if (std::abs(s.height_takeoff_m) < kUselessHeight_m)
    warnings.push_back("RelativeAltitude is " + base::format_fixed(s.height_takeoff_m, 2) +
                       " m: at the height of take-off by the barometer; useless as a height above ground");
  const double absolute_m = number(xmp, "drone-dji:AbsoluteAltitude");
  if (number(xmp, "drone-dji:RtkFlag") == kRtkFixed) s.height_ellipsoid_m = absolute_m;
  const auto gps = bracketed_numbers(text_of(exif, "EXIF_GPSAltitude"));
  if (gps.size() != 1 || std::isnan(absolute_m)) return;
  const std::string reference = text_of(exif, "EXIF_GPSAltitudeRef");
  const bool below = reference.find('1') != std::string::npos;
  const double exif_m = below ? -gps[0] : gps[0];
  if (std::abs(exif_m - absolute_m) > kAltitudeSlack_m)
    warnings.push_back("EXIF GPSAltitude " + base::format_fixed(exif_m, 2) + " m and XMP AbsoluteAltitude " +
                       base::format_fixed(absolute_m, 2) +
                       " m differ: the picture was rewritten by another program");
}

}  // namespace

Result<Shot> read_shot(const std::filesystem::path& image) {
  std::error_code failure;
  if (!std::filesystem::exists(image, failure))
    return Error{"file_missing", image.string(), "no such file", "a picture", ""};
  const CPLConfigOptionSetter no_side_files("GDAL_PAM_ENABLED", "NO", false);
  const CPLErrorHandlerPusher quiet(CPLQuietErrorHandler);
  CPLErrorReset();
  const Dataset dataset = open_picture(image);
  if (!dataset) {
    const std::string reason = CPLGetLastErrorMsg();
    return Error{"picture_unreadable", image.string(),
                 reason.empty() ? "not a picture that can be read" : reason,
                 "a JPEG, PNG, TIFF, BMP or WebP picture", ""};
  }
  Shot shot;
  shot.shot_id = image.stem().string();
  shot.image = image;
  shot.width = dataset->GetRasterXSize();
  shot.height = dataset->GetRasterYSize();
  Tags exif;
  add_exif(*dataset, "", exif);
  add_exif(*dataset, "EXIF", exif);
  Tags xmp;
  if (char** packet = dataset->GetMetadata("xml:XMP"); packet != nullptr && *packet != nullptr)
    xmp = xmp_tags(*packet);
  shot.camera_model = text_of(exif, "EXIF_Model");
  if (shot.camera_model.empty()) shot.camera_model = text_of(xmp, "tiff:Model");
  const double focal_35mm = base::parse_double(text_of(exif, "EXIF_FocalLengthIn35mmFilm")).value_or(0.0);
  if (focal_35mm > 0.0) shot.focal_length_35mm_mm = focal_35mm;
  shot.t_camera_local_ns = base::parse_date_time(text_of(exif, "EXIF_DateTimeOriginal"));
  Track one;
  one.samples.resize(1);
  Sample& s = one.samples.front();
  s.t_utc_ns = base::parse_date_time(text_of(xmp, "drone-dji:UTCAtExposure"));
  if (!s.t_utc_ns) s.t_utc_ns = exif_utc(exif);
  read_position(exif, xmp, s);
  read_attitude(xmp, s, shot.warnings);
  read_heights(exif, xmp, s, shot.warnings);
  if (reader::clear_impossible_heights(s)) shot.warnings.push_back("a height beyond 20 km: taken as unknown");
  if (s.latitude_deg == 0.0 && s.longitude_deg == 0.0) s.latitude_deg = s.longitude_deg = kMissing;
  reader::normalise(one);
  shot.metadata = s;
  return shot;
}

std::vector<Shot> with_unique_ids(std::vector<Shot> shots) {
  std::vector<std::string> names;
  std::vector<std::filesystem::path> files;
  for (const Shot& shot : shots) {
    names.push_back(shot.shot_id);
    files.push_back(shot.image);
  }
  names = base::names_apart(std::move(names), files);
  for (std::size_t i = 0; i < shots.size(); ++i) shots[i].shot_id = names[i];
  return shots;
}

}  // namespace furrow::telemetry
