#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "furrow/base/csv.h"
#include "furrow/base/file.h"
#include "furrow/base/text.h"
#include "furrow/geo/geodesy.h"
#include "furrow/geom/angles.h"
#include "furrow/sim/simulate.h"
#include "furrow/sim/world.h"
#include "sim/airdata.h"

namespace furrow::sim {
namespace {

std::filesystem::path data_folder() {
  const char* set = std::getenv("FURROW_DATA");
  return set != nullptr ? std::filesystem::path(set)
                        : std::filesystem::path(FURROW_SOURCE_DIR).parent_path() / "shared" / "data";
}

/// Columns of a log as numbers; NaN where a cell is no number.
std::map<std::string, std::vector<double>> columns_of(const std::string& csv) {
  const Result<base::CsvTable> table = base::parse_csv(csv, "airdata.csv");
  EXPECT_TRUE(table.ok());
  std::map<std::string, std::vector<double>> columns;
  for (std::size_t c = 0; c < table->columns.size(); ++c) {
    for (const auto& row : table->rows) {
      columns[table->columns[c]].push_back(base::parse_double(row[c]).value_or(std::nan("")));
    }
  }
  return columns;
}

constexpr double kFeet = 0.3048;

TEST(Airdata, HeaderIsThatOfARealLog) {
  const auto folder = data_folder() / "telemetry" / "airdata";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no real AirData log: " << folder << " is absent";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".csv") continue;
    const std::string real = base::read_file(entry.path()).value();
    const std::string ours = airdata_csv(demo_scene());
    EXPECT_EQ(std::string(base::trim(ours.substr(0, ours.find('\n')))),
              std::string(base::trim(real.substr(0, real.find('\n')))));
    return;
  }
  FAIL() << "no CSV in " << folder;
}

TEST(Airdata, TenRowsASecondAndAMarkForEachShot) {
  const Scene scene = demo_scene();
  auto columns = columns_of(airdata_csv(scene));
  const auto& time = columns["time(millisecond)"];
  for (std::size_t i = 1; i < time.size(); ++i) ASSERT_EQ(time[i] - time[i - 1], 100.0);
  const auto shots = true_shots(scene);
  ASSERT_EQ(shots.size(), 39U);
  std::size_t marks = 0;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (columns["isPhoto"][i] != 1.0) continue;
    ASSERT_LT(marks, shots.size());
    EXPECT_GE(time[i] * 1e-3, shots[marks].t_log_s - 1e-9);
    EXPECT_LE(time[i] * 1e-3, shots[marks].t_log_s + 0.1);
    ++marks;
  }
  EXPECT_EQ(marks, shots.size());
}

TEST(Airdata, ValuesAreTheTruthPlusTheStatedErrors) {
  Scene scene = demo_scene();
  auto columns = columns_of(airdata_csv(scene));
  const auto shots = true_shots(scene);
  const geo::LocalFrame world(
      {scene.flight.latitude_deg, scene.flight.longitude_deg, scene.flight.height_ellipsoid_m});
  double pitch_sum = 0.0;
  int canopy = 0, soil = 0;
  for (const ShotTruth& shot : shots) {
    const auto i = static_cast<std::size_t>(std::ceil(shot.t_log_s * 10.0 - 1e-9));
    pitch_sum += columns["gimbal_pitch(degrees)"][i] - geom::rad_to_deg(shot.attitude.pitch_rad);
    EXPECT_NEAR(columns["gimbal_pitch(degrees)"][i] * 10.0,
                std::round(columns["gimbal_pitch(degrees)"][i] * 10.0), 1e-6);
    // Drift of 0.5 m and gusts of 0.1 m on steps of 0.1 m, from the camera's 0.15 m over the soil at
    // take-off.
    const double height_m = columns["height_above_takeoff(feet)"][i] * kFeet;
    EXPECT_NEAR(height_m, shot.height_above_ground_m - 0.15 + 0.25, 0.25 + 5 * 0.12);
    const Eigen::Vector3d at = world.x_in_world({columns["latitude"][i], columns["longitude"][i],
                                                 scene.flight.height_ellipsoid_m + shot.x_in_world.z()});
    EXPECT_LT((at - shot.x_in_world).head<2>().norm(), 0.8 + 5 * 0.25);
    EXPECT_NEAR(columns["speed(mph)"][i] * 0.44704, scene.flight.speed_mps, 0.35);
    const double sonar_m = columns["height_sonar(feet)"][i] * kFeet;
    const bool is_canopy = std::abs(sonar_m - shot.height_above_canopy_m) < 0.3;
    const bool is_soil = std::abs(sonar_m - shot.height_above_ground_m) < 0.3;
    EXPECT_TRUE(is_canopy || is_soil) << shot.shot_id << " " << sonar_m;
    canopy += is_canopy;
    soil += is_soil;
  }
  EXPECT_NEAR(pitch_sum / static_cast<double>(shots.size()), scene.log.gimbal_pitch_bias_deg, 0.06);
  EXPECT_GT(canopy, 5);
  EXPECT_GT(soil, 5);
}

TEST(Airdata, DropoutsTakeRowsButNoMarks) {
  Scene scene = demo_scene();
  scene.log.dropout_probability = 0.3;
  auto columns = columns_of(airdata_csv(scene));
  auto whole = columns_of(airdata_csv(demo_scene()));
  const auto count = [](const std::vector<double>& marks) {
    return std::count(marks.begin(), marks.end(), 1.0);
  };
  EXPECT_EQ(count(columns["isPhoto"]), count(whole["isPhoto"]));
  const double left =
      static_cast<double>(columns["isPhoto"].size()) / static_cast<double>(whole["isPhoto"].size());
  EXPECT_NEAR(left, 0.7, 0.12);
}

TEST(Airdata, LatencyShiftsTheValues) {
  Scene scene = demo_scene();
  scene.log = LogErrors{};
  scene.log.gimbal_noise_deg = scene.log.baro_gust_m = scene.log.baro_drift_m = 0.0;
  auto now = columns_of(airdata_csv(scene));
  scene.log.latency_s = 0.5;
  auto late = columns_of(airdata_csv(scene));
  for (std::size_t i = 5; i < now["isPhoto"].size(); ++i) {
    ASSERT_EQ(late["height_above_takeoff(feet)"][i], now["height_above_takeoff(feet)"][i - 5])
        << i << " " << late["time(millisecond)"][i];
    ASSERT_EQ(late["isPhoto"][i], now["isPhoto"][i]);
  }
}

}  // namespace
}  // namespace furrow::sim
