#include <gtest/gtest.h>
#include <chrono>
#include <cmath>
#include <Eigen/LU>

#include "altitude/arrow.h"
#include "field_generator.h"
#include "furrow/altitude/flight.h"
#include "furrow/geom/angles.h"
#include "furrow/stats/agreement.h"

namespace furrow::altitude {
namespace {

using geom::deg_to_rad;
using testing::Noise;
using testing::World;

struct TestFlight {
  std::vector<ShotInput> shots;
  std::vector<World> worlds;
  FieldKnowledge field;
};

struct Bias {
  double pitch_rad = 0.0, roll_rad = 0.0;
};

/// A straight flight at slowly changing height whose gimbal log is biased.
TestFlight fly(int count, const Bias& bias, const Noise& noise, base::Random& random) {
  TestFlight flight;
  World world;
  flight.field = testing::knowledge_of(world, 0.01);
  flight.field.half_width_m.sigma = 0.06;
  flight.field.foliage_depth_m = {};
  flight.field.base_width_ratio = {};
  const Camera camera = testing::thesis_camera();
  for (int i = 0; i < count; ++i) {
    world.height_above_canopy_m = 2.3 + 0.5 * std::sin(0.3 * i);
    world.cross_track_m = random.normal(0.0, 0.3);
    world.attitude = {deg_to_rad(random.normal(0.0, 2.0)), deg_to_rad(-13.8 + random.normal(0.0, 0.3)),
                      deg_to_rad(random.normal(0.0, 0.2))};
    ShotInput shot;
    shot.shot_id = "shot" + std::to_string(i);
    shot.lines = testing::picture_of(world, camera, noise, random.bits());
    const double log_noise = deg_to_rad(0.2);
    shot.attitude.pitch_rad = {world.attitude.pitch_rad + bias.pitch_rad + random.normal(0.0, log_noise),
                               deg_to_rad(1.0), 1};
    shot.attitude.roll_rad = {world.attitude.roll_rad + bias.roll_rad + random.normal(0.0, log_noise),
                              deg_to_rad(1.0), 1};
    shot.log_height_m = world.height_above_canopy_m + 20.0 + random.normal(0.0, 0.1);
    flight.shots.push_back(shot);
    flight.worlds.push_back(world);
  }
  return flight;
}

const Noise kNoise{
    .edge_sigma_px = 1.5, .correlation = 0.6, .planting_sigma_m = 0.03, .growth_sigma_m = 0.03};

FlightOptions level_ground() {
  FlightOptions options;
  options.angle_noise_rad = deg_to_rad(0.2);
  options.shots_per_stretch = 1.0;  // each shot draws its own plants here
  return options;
}

TEST(Arrow, InverseEqualsTheDenseOne) {
  base::Random random(3);
  constexpr int n = 3, m = 2, shots = 4, size = n * shots + m;
  Eigen::MatrixXd root(size, size);
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < size; ++j) root(i, j) = random.normal();
  }
  Eigen::MatrixXd full = root * root.transpose() + 5.0 * Eigen::MatrixXd::Identity(size, size);
  ArrowMatrix arrow;
  for (int i = 0; i < shots; ++i) {
    for (int j = i + 2; j < shots; ++j)
      full.block(n * i, n * j, n, n).setZero(), full.block(n * j, n * i, n, n).setZero();
    arrow.diagonal.push_back(full.block(n * i, n * i, n, n));
    arrow.border.push_back(full.block(n * i, n * shots, n, m));
    if (i + 1 < shots) arrow.next.push_back(full.block(n * i, n * (i + 1), n, n));
  }
  // Zeroed blocks can cost definiteness; the shift keeps it.
  full += 20.0 * Eigen::MatrixXd::Identity(size, size);
  for (auto& block : arrow.diagonal) block += 20.0 * Eigen::MatrixXd::Identity(n, n);
  arrow.corner = full.bottomRightCorner(m, m);
  arrow.corner_prior = Eigen::MatrixXd::Zero(m, m);
  const Eigen::MatrixXd expected = full.inverse();
  const auto inverse = invert(arrow);
  ASSERT_TRUE(inverse);
  for (int i = 0; i < shots; ++i) {
    EXPECT_LT((inverse->diagonal[static_cast<std::size_t>(i)] - expected.block(n * i, n * i, n, n)).norm(),
              1e-12);
    EXPECT_LT((inverse->border[static_cast<std::size_t>(i)] - expected.block(n * i, n * shots, n, m)).norm(),
              1e-12);
  }
  EXPECT_LT((inverse->corner - expected.bottomRightCorner(m, m)).norm(), 1e-12);
  arrow.diagonal[1].setZero();
  EXPECT_FALSE(invert(arrow));
}

// Issue: pitch bias from one flight of 12 shots to 0.1 deg.
TEST(RefineFlight, FindsTheGimbalBiasFromTwelveShots) {
  base::Random random(5);
  double squares = 0.0;
  int inside = 0;
  constexpr int kFlights = 12;
  for (int i = 0; i < kFlights; ++i) {
    const TestFlight flight = fly(12, {deg_to_rad(0.7), deg_to_rad(-0.4)}, kNoise, random);
    const auto result = refine_flight(flight.shots, testing::thesis_camera(), flight.field, level_ground());
    ASSERT_TRUE(result.ok()) << result.error().message();
    const double error = result->pitch_bias_rad.value - deg_to_rad(0.7);
    squares += error * error;
    inside += std::abs(error) < 2.0 * result->pitch_bias_rad.sigma;
    EXPECT_LT(result->pitch_bias_rad.sigma, deg_to_rad(0.1));
    EXPECT_NEAR(result->roll_bias_rad.value, deg_to_rad(-0.4), 4.0 * result->roll_bias_rad.sigma);
  }
  EXPECT_LT(std::sqrt(squares / kFlights), deg_to_rad(0.1));
  EXPECT_GE(inside, 9);
  std::printf("pitch bias rms error of 12-shot flights: %.3f deg\n",
              geom::rad_to_deg(std::sqrt(squares / kFlights)));
}

TEST(RefineFlight, SigmaOfTheHeightsHolds) {
  base::Random random(6);
  std::vector<Estimate> estimates;
  std::vector<double> truths;
  for (int i = 0; i < 20; ++i) {
    TestFlight flight = fly(12, {deg_to_rad(0.7), 0.0}, kNoise, random);
    flight.field.row_spacing_m.value += random.normal(0.0, flight.field.row_spacing_m.sigma);
    flight.field.half_width_m.value += random.normal(0.0, flight.field.half_width_m.sigma);
    const auto result = refine_flight(flight.shots, testing::thesis_camera(), flight.field, level_ground());
    ASSERT_TRUE(result.ok()) << result.error().message();
    // One shot a flight: the spacing's error is common to a flight.
    estimates.push_back(result->shots[5].height_above_canopy_m);
    truths.push_back(flight.worlds[5].height_above_canopy_m);
  }
  const stats::Coverage coverage = stats::coverage(estimates, truths);
  // 20 flights scatter by 0.104 and 0.047.
  EXPECT_NEAR(coverage.within_1_sigma, 0.683, 0.05 + 2.0 * 0.104);
  EXPECT_NEAR(coverage.within_2_sigma, 0.954, 0.05 + 2.0 * 0.047);
}

TEST(RefineFlight, SaysWhatTheFlightTellsAndWhatNot) {
  base::Random random(7);
  const TestFlight flight = fly(12, {deg_to_rad(0.7), 0.0}, kNoise, random);
  FlightOptions options = level_ground();
  options.mean_slope_sigma_rad = deg_to_rad(0.5);
  const auto result = refine_flight(flight.shots, testing::thesis_camera(), flight.field, options);
  ASSERT_TRUE(result.ok()) << result.error().message();
  const auto shared = [&](const std::string& name) {
    for (const SharedQuantity& q : result->shared) {
      if (q.name == name) return q;
    }
    ADD_FAILURE() << name;
    return SharedQuantity{};
  };
  // Seen from one side only, slope and pitch bias are one number; height over spacing is all a picture knows.
  EXPECT_EQ(shared("pitch_bias").most_correlated, "terrain_slope");
  EXPECT_LT(shared("pitch_bias").correlation, -0.9);
  EXPECT_GT(shared("row_spacing").sigma_ratio, 0.8);
  EXPECT_LT(shared("half_width").sigma_ratio, 0.5);

  TestFlight there_and_back = flight;
  for (std::size_t i = 0; i < 12; i += 2) there_and_back.shots[i].direction = -1.0;
  const auto told = refine_flight(there_and_back.shots, testing::thesis_camera(), flight.field, options);
  ASSERT_TRUE(told.ok());
  EXPECT_LT(told->pitch_bias_rad.sigma, deg_to_rad(0.1));
}

double share_of(const RefinedShot& shot, const std::string& cause) {
  for (const SigmaShare& share : shot.height_budget) {
    if (share.cause == cause) return share.sigma_m;
  }
  return 0.0;
}

double squares_of(const RefinedShot& shot) {
  double squares = 0.0;
  for (const SigmaShare& share : shot.height_budget) squares += share.sigma_m * std::abs(share.sigma_m);
  return squares;
}

// The rest goes to the other shots, so the parts are checked where there are none.
TEST(RefineFlight, BudgetSplitsTheSigmaOfAHeight) {
  base::Random random(11);
  const TestFlight flight = fly(12, {deg_to_rad(0.7), 0.0}, kNoise, random);
  Camera camera = testing::thesis_camera();
  camera.covariance = Eigen::MatrixXd::Identity(9, 9);
  camera.covariance.diagonal().tail(5).setConstant(1e-6);
  const auto one = refine_flight({flight.shots[3]}, camera, flight.field, level_ground());
  ASSERT_TRUE(one.ok()) << one.error().message();
  const RefinedShot& alone = one->shots[0];
  EXPECT_NEAR(squares_of(alone) / std::pow(alone.height_above_canopy_m.sigma, 2), 1.0, 1e-6);
  EXPECT_LT(share_of(alone, "other"), 0.01 * alone.height_above_canopy_m.sigma);
  EXPECT_GT(share_of(alone, "distortion"), 0.0);

  const auto all = refine_flight(flight.shots, camera, flight.field, level_ground());
  ASSERT_TRUE(all.ok()) << all.error().message();
  for (const RefinedShot& shot : all->shots) {
    const Estimate& height = shot.height_above_canopy_m;
    EXPECT_NEAR(squares_of(shot) / (height.sigma * height.sigma), 1.0, 1e-6);
    // Height is proportional to the spacing, which the flight does not tell: 1 %.
    EXPECT_NEAR(share_of(shot, "spacing") / height.value, 0.01, 0.002);
    double shared = 0.0;
    for (const SigmaShare& cause : shot.height_shared) shared += cause.sigma_m * cause.sigma_m;
    EXPECT_GT(std::sqrt(shared), share_of(shot, "spacing"));
    EXPECT_LT(std::sqrt(shared), height.sigma);
  }
}

TEST(RefineFlight, ABadShotIsNamedAndSkipped) {
  base::Random random(8);
  TestFlight flight = fly(5, {}, kNoise, random);
  flight.shots[2].lines.rows.resize(1);
  flight.shots[3].lines.status = "no_rows";
  const auto result = refine_flight(flight.shots, testing::thesis_camera(), flight.field);
  ASSERT_TRUE(result.ok()) << result.error().message();
  EXPECT_EQ(result->status, (std::vector<std::string>{"ok", "ok", "not_enough_rows", "rows_not_ok", "ok"}));
  EXPECT_FALSE(result->shots[2].usable);
  EXPECT_TRUE(result->shots[4].usable);
  EXPECT_EQ(refine_flight({}, testing::thesis_camera(), flight.field).error().code, "no_shots");
  const auto none = refine_flight({flight.shots[2]}, testing::thesis_camera(), flight.field);
  ASSERT_TRUE(none.ok()) << none.error().message();
  ASSERT_TRUE(none->failure);
  EXPECT_EQ(none->failure->code, "no_usable_shot");
  EXPECT_EQ(none->status, std::vector<std::string>{"not_enough_rows"});
}

// Random pixels, edges, indices and sigmas, with NaN, infinities and huge numbers among them: an answer is
// finite, or it is an error.
TEST(RefineFlight, AShotThatItsNeighboursDenyIsLeftOutAndNamed) {
  base::Random random(31);
  const Camera camera = testing::thesis_camera();
  TestFlight flight = fly(12, {}, kNoise, random);
  World wrong = flight.worlds[5];
  wrong.height_above_canopy_m *= 2.0;  // a line between two rows taken for a row
  flight.shots[5].lines = testing::picture_of(wrong, camera, kNoise, 7);
  const auto refined = refine_flight(flight.shots, camera, flight.field, level_ground());
  ASSERT_TRUE(refined.ok()) << refined.error().message();
  EXPECT_EQ(refined->status[5], "denied_by_neighbours");
  EXPECT_FALSE(refined->shots[5].usable);
  EXPECT_NE(refined->reason[5].find("shot5"), std::string::npos);
  for (const std::size_t i : {4, 6}) {
    EXPECT_EQ(refined->status[i], "ok");
    const Estimate& height = refined->shots[i].height_above_canopy_m;
    EXPECT_NEAR(height.value, flight.worlds[i].height_above_canopy_m, 4.0 * height.sigma);
  }
  for (ShotInput& shot : flight.shots) shot.log_height_m = std::nan("");
  const auto blind = refine_flight(flight.shots, camera, flight.field, level_ground());
  ASSERT_TRUE(blind.ok()) << blind.error().message();
  EXPECT_EQ(blind->status[5], "ok");  // nobody to ask
}

// Rows half as wide fit a shot alone, whose field is told to a tenth only; beside the flight's they do not.
TEST(RefineFlight, AShotThatFitsAloneButNotTheFlightIsLeftOutAndNamed) {
  base::Random random(33);
  const Camera camera = testing::thesis_camera();
  TestFlight flight = fly(12, {}, kNoise, random);
  for (ShotInput& shot : flight.shots) shot.log_height_m = std::nan("");  // nobody to ask
  World wrong = flight.worlds[5];
  wrong.half_width_m = wrong.base_half_width_m = 0.3;
  flight.shots[5].lines = testing::picture_of(wrong, camera, kNoise, 7);
  const auto alone = refine_shot(flight.shots[5].lines, camera, flight.field, flight.shots[5].attitude);
  ASSERT_TRUE(alone.ok()) << alone.error().message();
  EXPECT_LT(alone->residual_rms, 1.5);
  const auto refined = refine_flight(flight.shots, camera, flight.field, level_ground());
  ASSERT_TRUE(refined.ok()) << refined.error().message();
  EXPECT_EQ(refined->status[5], "rows_do_not_fit");
  EXPECT_FALSE(refined->shots[5].usable);
  EXPECT_NE(refined->reason[5].find("shot5"), std::string::npos);
  for (std::size_t i = 0; i < 12; ++i) {
    if (i == 5) continue;
    EXPECT_EQ(refined->status[i], "ok") << i;
    EXPECT_TRUE(refined->reason[i].empty()) << i;
  }
  EXPECT_NEAR(refined->half_width_m.value, 0.6, 4.0 * refined->half_width_m.sigma);
}

// Every second shot counts a line between two rows: each is denied by those beside it, and nobody is left.
TEST(RefineFlight, AFlightWhoseShotsAllDenyOneAnotherNamesEach) {
  base::Random random(31);
  const Camera camera = testing::thesis_camera();
  TestFlight flight = fly(12, {}, kNoise, random);
  for (std::size_t i = 1; i < flight.shots.size(); i += 2) {
    World wrong = flight.worlds[i];
    wrong.height_above_canopy_m *= 2.0;
    flight.shots[i].lines = testing::picture_of(wrong, camera, kNoise, 7 + i);
  }
  const auto refined = refine_flight(flight.shots, camera, flight.field, level_ground());
  ASSERT_TRUE(refined.ok()) << refined.error().message();
  EXPECT_FALSE(refined->usable());
  ASSERT_TRUE(refined->failure);
  EXPECT_EQ(refined->failure->code, "no_usable_shot");
  EXPECT_NE(refined->failure->message().find("shot0"), std::string::npos);
  for (std::size_t i = 0; i < flight.shots.size(); ++i) {
    EXPECT_EQ(refined->status[i], "denied_by_neighbours") << i;
    EXPECT_TRUE(refined->denies(i));
    EXPECT_FALSE(refined->shots[i].usable);
    EXPECT_NE(refined->reason[i].find(flight.shots[i].shot_id), std::string::npos) << refined->reason[i];
  }
}

TEST(RefineFlight, ATerraceDeniesNobody) {
  base::Random random(32);
  TestFlight flight = fly(12, {}, kNoise, random);
  for (std::size_t i = 6; i < 12; ++i) flight.shots[i].log_height_m += 2.0;
  const auto refined = refine_flight(flight.shots, testing::thesis_camera(), flight.field, level_ground());
  ASSERT_TRUE(refined.ok()) << refined.error().message();
  for (std::size_t i = 0; i < 12; ++i) EXPECT_EQ(refined->status[i], "ok") << i;
}

TEST(RefineFlight, GarbageGivesErrorsOrFiniteNumbers) {
  base::Random random(10);
  const auto number = [&](double scale) {
    const double kind = random.uniform();
    if (kind < 0.03) return std::nan("");
    if (kind < 0.06) return kind < 0.045 ? HUGE_VAL : -1e300;
    return random.uniform(-0.2, 1.2) * scale;
  };
  FieldKnowledge field;
  field.row_spacing_m = {3.0, 0.03, 1};
  std::vector<ShotInput> shots;
  for (int i = 0; i < 200; ++i) {
    ShotInput shot;
    shot.lines.width = 1280, shot.lines.height = 720, shot.lines.status = "ok";
    const std::uint32_t rows = random.below(6);
    for (std::uint32_t k = 0; k < rows; ++k) {
      rows::RowLine row;
      row.index = random.uniform() < 0.8 ? static_cast<int>(k) : static_cast<int>(random.below(2000000000));
      const std::uint32_t samples = random.below(12);
      for (std::uint32_t j = 0; j < samples; ++j) {
        row.samples.push_back(
            {{number(1280.0), number(720.0)}, number(3.0), number(1280.0), number(1280.0), number(3.0)});
      }
      shot.lines.rows.push_back(row);
    }
    shot.attitude.pitch_rad = {number(-1.5), 0.02, 1};
    const auto alone = refine_shot(shot.lines, testing::thesis_camera(), field, shot.attitude);
    if (alone.ok()) {
      EXPECT_TRUE(alone->height_above_canopy_m.usable());
      EXPECT_GT(alone->height_above_canopy_m.value, 0.0);
    } else {
      EXPECT_FALSE(alone.error().code.empty());
    }
    shots.push_back(shot);
  }
  const auto flight = refine_flight(shots, testing::thesis_camera(), field);
  if (!flight.ok()) return;
  for (const RefinedShot& shot : flight->shots)
    EXPECT_TRUE(!shot.usable || shot.height_above_canopy_m.usable());
}

TEST(RefineFlight, SameBytesWhateverTheThreads) {
  base::Random random(9);
  const TestFlight flight = fly(6, {}, kNoise, random);
  FlightOptions one, two;
  one.threads = 1, two.threads = 2;
  const auto a = refine_flight(flight.shots, testing::thesis_camera(), flight.field, one);
  const auto b = refine_flight(flight.shots, testing::thesis_camera(), flight.field, two);
  ASSERT_TRUE(a.ok() && b.ok());
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_EQ(a->shots[i].height_above_canopy_m.value, b->shots[i].height_above_canopy_m.value);
}

}  // namespace
}  // namespace furrow::altitude
