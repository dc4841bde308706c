// Prints how good the height is: rows of the independent generator of tests/altitude by flight condition,
// then every simulated flight given as an argument (folders that `furrow simulate` wrote), from its pictures.
// Times are processor times of one thread.
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>

#include "altitude/field_generator.h"
#include "furrow/altitude/flight.h"
#include "furrow/altitude/thesis.h"
#include "furrow/base/csv.h"
#include "furrow/base/text.h"
#include "furrow/camera/model_files.h"
#include "furrow/geom/angles.h"
#include "furrow/image/image.h"
#include "furrow/rows/detect.h"

namespace {

using namespace furrow;
using geom::deg_to_rad;
using geom::rad_to_deg;

struct Truth {
  double height_m, cross_track_m, pitch_rad;
};

/// Relative errors of heights, cross-track and pitch errors, and how often the sigma holds.
struct Score {
  int shots = 0, answered = 0, inside_1 = 0, inside_2 = 0;
  double height2 = 0.0, cross2 = 0.0, pitch2 = 0.0;

  void add(const altitude::RefinedShot& shot, const Truth& truth, double spacing_m) {
    ++shots;
    if (!shot.usable) return;
    ++answered;
    const double error = shot.height_above_canopy_m.value - truth.height_m;
    inside_1 += std::abs(error) < shot.height_above_canopy_m.sigma;
    inside_2 += std::abs(error) < 2.0 * shot.height_above_canopy_m.sigma;
    height2 += std::pow(error / truth.height_m, 2);
    cross2 += std::pow(std::remainder(shot.cross_track_m.value - truth.cross_track_m, spacing_m), 2);
    pitch2 += std::pow(shot.pitch_rad.value - truth.pitch_rad, 2);
  }

  void print(const char* name) const {
    const double n = std::max(1, answered);
    std::printf("%-34s %4d %4d  %6.2f %%  %4.0f %% %4.0f %%  %6.3f m  %6.3f deg\n", name, shots, answered,
                100.0 * std::sqrt(height2 / n), 100.0 * inside_1 / n, 100.0 * inside_2 / n,
                std::sqrt(cross2 / n), rad_to_deg(std::sqrt(pitch2 / n)));
  }
};

void header(const char* title) {
  std::printf("\n%s\n%-34s shots  ans  height    1 s    2 s   cross     pitch\n", title, "");
}

/// Gimbal log with the bias of 0.7 deg; farm numbers exact in value, spacing known to 1 %.
altitude::AttitudePrior biased_prior(double pitch_rad, base::Random& random) {
  const double logged = pitch_rad + deg_to_rad(0.7 + random.normal(0.0, 0.1));
  return {{logged, deg_to_rad(1.0), 1}, {0.0, deg_to_rad(0.7), 1}};
}

altitude::FieldKnowledge farm(double spacing_m, double half_width_m, double row_height_m) {
  altitude::FieldKnowledge field;
  field.row_spacing_m = {spacing_m, 0.01 * spacing_m, 1};
  field.half_width_m = {half_width_m, 0.1 * half_width_m, 1};
  field.row_height_m = {row_height_m, 0.1, 1};
  return field;
}

void run(const char* name, const std::vector<altitude::ShotInput>& shots, const std::vector<Truth>& truths,
         const Camera& camera, const altitude::FieldKnowledge& field) {
  Score alone, together;
  const std::clock_t start = std::clock();
  for (std::size_t i = 0; i < shots.size(); ++i) {
    const auto shot = altitude::refine_shot(shots[i].lines, camera, field, shots[i].attitude);
    alone.add(shot.ok() ? *shot : altitude::RefinedShot{}, truths[i], field.row_spacing_m.value);
  }
  const std::clock_t middle = std::clock();
  altitude::FlightOptions options;
  options.threads = 1;
  const auto flight = altitude::refine_flight(shots, camera, field, options);
  const std::clock_t end = std::clock();
  alone.print((std::string(name) + ", shot").c_str());
  if (const auto failure = altitude::failure_of(flight)) {
    std::printf("  flight: %s\n", failure->message().c_str());
    return;
  }
  for (std::size_t i = 0; i < shots.size(); ++i)
    together.add(flight->shots[i], truths[i], field.row_spacing_m.value);
  together.print((std::string(name) + ", flight").c_str());
  const double per_shot = 1e3 / CLOCKS_PER_SEC / static_cast<double>(shots.size());
  std::printf("    pitch bias %.3f +- %.3f deg; %.2f ms a shot alone, %.2f ms in the flight\n",
              rad_to_deg(flight->pitch_bias_rad.value), rad_to_deg(flight->pitch_bias_rad.sigma),
              static_cast<double>(middle - start) * per_shot, static_cast<double>(end - middle) * per_shot);
}

struct Condition {
  const char* name;
  double low_m, high_m, pitch_deg;
  bool timed = false;  ///< also time long flights of it
};

/// Time of a long flight: the same shots over and over.
void time_flight(const std::vector<altitude::ShotInput>& shots, const Camera& camera, std::size_t count) {
  std::vector<altitude::ShotInput> many;
  for (std::size_t i = 0; i < count; ++i) many.push_back(shots[i % shots.size()]);
  altitude::FlightOptions options;
  options.threads = 1;
  const std::clock_t start = std::clock();
  const auto flight = altitude::refine_flight(many, camera, farm(3.0, 0.6, 1.7), options);
  const auto failure = altitude::failure_of(flight);
  std::printf("flight of %zu shots: %.1f s, %s\n", count,
              static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC,
              failure ? failure->message().c_str() : flight->termination.c_str());
}

/// What the farm writes down: spacing to 1 %, half width to 10 %, each off by a draw of its sigma.
altitude::FieldKnowledge drawn_farm(const altitude::testing::World& world, base::Random& random) {
  altitude::FieldKnowledge field = farm(world.spacing_m, world.half_width_m, 1.7);
  for (Estimate* number : {&field.row_spacing_m, &field.half_width_m})
    number->value += random.normal(0.0, number->sigma);
  field.outline_rise_m = {0.0, 0.0, 1};  // rows end where they end
  return field;
}

/// One flight's shots and their truths.
struct Generated {
  std::vector<altitude::ShotInput> shots;
  std::vector<Truth> truths;
};

Generated generate(const Condition& c, const altitude::testing::World& field, int count, const Camera& camera,
                   base::Random& random) {
  Generated flight;
  for (int i = 0; i < count; ++i) {
    altitude::testing::World world = field;
    world.height_above_canopy_m = random.uniform(c.low_m, c.high_m);
    world.attitude = {deg_to_rad(random.normal(0.0, 2.0)), deg_to_rad(c.pitch_deg),
                      deg_to_rad(random.normal(0.0, 0.3))};
    if (c.pitch_deg < -80.0) world.attitude.roll_rad = 0.0;
    world.cross_track_m = random.normal(0.0, 0.2);
    world.base_half_width_m = 0.25;
    altitude::testing::Noise noise{
        .edge_sigma_px = 2.0, .correlation = 0.7, .planting_sigma_m = 0.03, .growth_sigma_m = 0.03};
    noise.leaf_against_leaf = false;
    noise.foot_anywhere = true;
    noise.top_sigma_px = 3.0;
    altitude::ShotInput shot;
    shot.shot_id = std::to_string(i);
    shot.lines = altitude::testing::picture_of(world, camera, noise, random.bits());
    shot.attitude = biased_prior(world.attitude.pitch_rad, random);
    flight.shots.push_back(shot);
    flight.truths.push_back({world.height_above_canopy_m, world.cross_track_m, world.attitude.pitch_rad});
  }
  return flight;
}

/// The table's quantities over many flights of one condition.
struct Table {
  int shots = 0, answered = 0, inside_1 = 0, inside_2 = 0, flights = 0;
  double height2 = 0.0, cross2 = 0.0, bias2 = 0.0;
  std::clock_t time = 0;

  /// `spacing_share` is known over true spacing: its error is taken out of the height's, not of the coverage.
  void add(const altitude::RefinedFlight& flight, const std::vector<Truth>& truths, double spacing_m,
           double spacing_share) {
    ++flights;
    bias2 += std::pow(rad_to_deg(flight.pitch_bias_rad.value) - 0.7, 2);
    for (std::size_t i = 0; i < truths.size(); ++i) {
      ++shots;
      const altitude::RefinedShot& shot = flight.shots[i];
      if (!shot.usable) continue;
      ++answered;
      const Estimate& height = shot.height_above_canopy_m;
      const double error = std::abs(height.value - truths[i].height_m);
      inside_1 += error < height.sigma, inside_2 += error < 2.0 * height.sigma;
      height2 += std::pow(height.value / spacing_share / truths[i].height_m - 1.0, 2);
      cross2 += std::pow(std::remainder(shot.cross_track_m.value - truths[i].cross_track_m, spacing_m), 2);
    }
  }

  void print(const char* name) const {
    const double n = std::max(1, answered), f = std::max(1, flights);
    std::printf("%-30s %5d  %5.1f %%  %6.2f %%  %6.3f deg  %6.3f m  %4.1f %% %5.1f %%  %6.2f ms\n", name,
                shots, 100.0 * answered / std::max(1, shots), 100.0 * std::sqrt(height2 / n),
                std::sqrt(bias2 / f), std::sqrt(cross2 / n), 100.0 * inside_1 / n, 100.0 * inside_2 / n,
                1e3 * static_cast<double>(time) / CLOCKS_PER_SEC / std::max(1, shots));
  }
};

void generated(const Condition& c, int flights) {
  constexpr int kShotsPerFlight = 12;
  base::Random random(20240618);
  const Camera camera = altitude::testing::thesis_camera();
  altitude::FlightOptions options;
  options.threads = 1;
  options.shots_per_stretch = 1.0;  // each shot has plants of its own
  Table table;
  Generated last;
  for (int i = 0; i < flights; ++i) {
    altitude::testing::World world;
    world.softness_m = altitude::kSoftnessPerHalfWidth * world.half_width_m *
                       std::exp(random.normal(0.0, altitude::kLogSoftnessSigma));
    world.rounding_m = altitude::kRoundingPerHalfWidth * world.half_width_m *
                       std::exp(random.normal(0.0, altitude::kLogRoundingSigma));
    const altitude::FieldKnowledge field = drawn_farm(world, random);
    last = generate(c, world, kShotsPerFlight, camera, random);
    const std::clock_t start = std::clock();
    const auto flight = altitude::refine_flight(last.shots, camera, field, options);
    table.time += std::clock() - start;
    if (altitude::failure_of(flight)) {
      table.shots += kShotsPerFlight;
      continue;
    }
    table.add(*flight, last.truths, world.spacing_m, field.row_spacing_m.value / world.spacing_m);
  }
  table.print(c.name);
  if (c.timed) {
    for (const std::size_t long_flight : {std::size_t{1000}, std::size_t{10000}})
      time_flight(last.shots, camera, long_flight);
  }
}

/// A number of truth.csv.
double number(const base::CsvTable& table, std::size_t row, const char* column) {
  const auto place = table.column(column);
  return place ? base::parse_double(table.rows[row][*place]).value_or(std::nan("")) : std::nan("");
}

int simulated(const std::filesystem::path& folder) {
  const auto truth = base::read_csv(folder / "truth.csv");
  const auto camera = camera::read_camera(folder / "camera_true.yaml");
  if (!truth.ok() || !camera.ok() || truth->rows.empty() || !truth->column("image")) {
    std::fprintf(stderr, "%s: no simulated flight\n", folder.string().c_str());
    return 2;
  }
  base::Random random(1);
  std::vector<altitude::ShotInput> shots;
  std::vector<Truth> truths;
  for (std::size_t i = 0; i < truth->rows.size(); ++i) {
    const auto picture = image::read_image(folder / truth->rows[i][*truth->column("image")]);
    if (!picture.ok()) continue;
    altitude::ShotInput shot;
    const double pitch = deg_to_rad(number(*truth, i, "pitch_deg"));
    shot.attitude = biased_prior(pitch, random);
    rows::DetectOptions options;
    if (pitch > deg_to_rad(-80.0)) {
      options.priors.horizon_v_px = camera->cy + camera->fy * std::tan(shot.attitude.pitch_rad.value);
      options.priors.horizon_sigma_px = camera->fy * shot.attitude.pitch_rad.sigma;
    }
    shot.lines = rows::detect(*picture, options);
    shots.push_back(shot);
    truths.push_back({number(*truth, i, "height_above_canopy_m"), number(*truth, i, "cross_track_m"), pitch});
  }
  run(folder.filename().string().c_str(), shots, truths, *camera,
      farm(number(*truth, 0, "row_spacing_m"), number(*truth, 0, "half_width_m"),
           number(*truth, 0, "row_height_m")));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  constexpr int kFlights = 84;  // of 12 shots: 1,008 a condition
  std::printf(
      "generated rows in flights of 12: tops of any rounding, 2 px edges correlated 0.7 against soil, 3 px "
      "tops "
      "against\nleaves, 3 cm plants, feet of walls anywhere, pitch log +0.7 deg, spacing known to 1 %%; "
      "height without "
      "the\nspacing's own error, coverage with it\n"
      "%-30s shots  answer  height    pitch bias  cross     1 s    2 s     a shot\n",
      "");
  for (const Condition& c :
       {Condition{"3 m above ground, -12.4 deg", 1.1, 1.5, -12.4},
        Condition{"4 m above ground, -13.8 deg", 2.1, 2.5, -13.8},
        Condition{"5 m above ground, -13.8 deg", 3.1, 3.5, -13.8, true},
        Condition{"3 to 6 m, -20 deg", 1.3, 4.3, -20.0}, Condition{"8 m, -45 deg", 6.0, 6.6, -45.0},
        Condition{"30 m, nadir", 27.5, 29.0, -90.0}}) {
    generated(c, kFlights);
  }
  int status = 0;
  if (argc > 1) header("rendered flights, rows found in the pictures");
  for (int i = 1; i < argc; ++i) status = std::max(status, simulated(argv[i]));
  return status;
}
