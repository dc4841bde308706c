#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "furrow/rows/detect.h"
#include "furrow/rows/planar_field.h"
#include "rows/index_rows.h"
#include "rows/simplex.h"

namespace furrow::rows {
namespace {

PlanarField oblique_field() {
  PlanarField field;
  field.u0 = 319.5, field.v0 = 479.0, field.length = 480.0;
  field.convergence = 0.8, field.spacing = 200.0, field.offset = 30.0, field.slope = -40.0;
  return field;
}

TEST(PlanarField, StraightRowsMeetInTheVanishingPoint) {
  const PlanarField field = oblique_field();
  const auto point = field.vanishing_point();
  ASSERT_TRUE(point.has_value());
  EXPECT_NEAR(point->y(), 479.0 - 480.0 / 0.8, 1e-9);
  // The line through two points of a row, continued, passes there.
  for (const int k : {-3, 0, 4}) {
    const double a = field.u_at(100.0, k), b = field.u_at(400.0, k);
    EXPECT_NEAR(a + (b - a) * (point->y() - 100.0) / 300.0, point->x(), 1e-9) << k;
  }
}

TEST(PlanarField, NadirIsTheRegularLimit) {
  PlanarField field = oblique_field();
  field.convergence = 1e-12;
  const double almost = field.u_at(0.0, 2.0);
  field.convergence = 0.0;
  EXPECT_NEAR(field.u_at(0.0, 2.0), almost, 1e-6);
  EXPECT_FALSE(field.vanishing_point().has_value());
  EXPECT_FALSE(field.horizon_v().has_value());
}

TEST(PlanarField, RowNumberAndPlaceAreInverse) {
  PlanarField field = oblique_field();
  field.bend = 12.0, field.bend2 = -1.5;
  for (const double v : {20.0, 200.0, 460.0})
    for (const double k : {-2.0, 0.25, 5.0}) EXPECT_NEAR(field.k_at(field.u_at(v, k), v), k, 1e-12);
}

// A parabola on the ground, X = X0 + c Z^2 / 2 seen by a pinhole camera, is bend y^2 exactly: y and the
// ground depth are related affinely (docs/formulation/rows.md).
TEST(PlanarField, GroundParabolaIsABend) {
  const double f = 500.0, height = 2.0, pitch = 0.6, curvature = 0.02;  // px, m, rad below the horizon, 1/m
  const auto project = [&](double x, double z) {  // ground point to picture: x right, z ahead
    const double depth = z * std::cos(pitch) + height * std::sin(pitch);
    return Eigen::Vector2d(319.5 + f * x / depth,
                           239.5 + f * (height * std::cos(pitch) - z * std::sin(pitch)) / depth);
  };
  const auto u_of_row = [&](double x0, double v) {  // by bisection over z
    double near = 0.2, far = 500.0;
    for (int i = 0; i < 200; ++i) {
      const double z = 0.5 * (near + far);
      (project(0.0, z).y() > v ? near : far) = z;
    }
    return project(x0 + 0.5 * curvature * near * near, near).x();
  };
  PlanarField field;
  field.u0 = 319.5, field.v0 = 479.0, field.length = 480.0;
  const double horizon = 239.5 - f * std::tan(pitch);
  field.convergence = field.length / (field.v0 - horizon);
  field.spacing = u_of_row(1.0, 479.0) - u_of_row(0.0, 479.0);
  field.offset = u_of_row(0.0, 479.0) - field.u0;
  // Slope and bend from two more rows of the picture; every other row must then agree.
  const auto rest = [&](double v) { return (u_of_row(0.0, v) - field.u0) / field.scale(v) - field.offset; };
  const double ya = field.t(300.0) / field.scale(300.0), yb = field.t(100.0) / field.scale(100.0);
  field.bend = (rest(300.0) / ya - rest(100.0) / yb) / (ya - yb);
  field.slope = rest(300.0) / ya - field.bend * ya;
  for (const double v : {0.0, 50.0, 180.0, 250.0, 400.0, 470.0})
    for (const double k : {-2.0, 0.0, 3.0})
      EXPECT_NEAR(field.u_at(v, k), u_of_row(k, v), 1e-6) << v << " " << k;
}

TEST(Rows, UAtInterpolatesAndReachesTenPixels) {
  RowLine row;
  row.samples.push_back({.centre_px = {10.0, 20.0}});
  row.samples.push_back({.centre_px = {14.0, 28.0}});
  EXPECT_NEAR(*u_at(row, 24.0), 12.0, 1e-12);
  EXPECT_NEAR(*u_at(row, 12.0), 6.0, 1e-12);
  EXPECT_NEAR(*u_at(row, 38.0), 19.0, 1e-12);
  EXPECT_FALSE(u_at(row, 9.0).has_value());
  EXPECT_FALSE(u_at(row, 38.5).has_value());
  EXPECT_FALSE(u_at(RowLine{}, 5.0).has_value());
}

TEST(Rows, SamplesReachBothEndsAndAreClose) {
  for (const int height : {1, 2, 11, 180, 721}) {
    const auto v = sample_rows(height, 10.0);
    EXPECT_EQ(v.front(), 0.0);
    EXPECT_EQ(v.back(), height - 1.0);
    for (std::size_t i = 1; i < v.size(); ++i) EXPECT_LE(v[i] - v[i - 1], 10.0);
  }
}

TEST(Rows, IndexZeroIsNearestTheMiddleColumn) {
  RowLines lines;
  lines.width = 101, lines.height = 101;
  for (const double u : {90.0, 10.0, 55.0}) {
    RowLine row;
    row.samples.push_back({.centre_px = {u, 0.0}});
    row.samples.push_back({.centre_px = {u, 100.0}});
    lines.rows.push_back(row);
  }
  index_rows(lines);
  EXPECT_EQ(lines.rows[0].index, -1);
  EXPECT_EQ(lines.rows[1].index, 0);
  EXPECT_EQ(lines.rows[1].samples[0].centre_px.x(), 55.0);
}

// Rosenbrock's valley (1960): minimum 0 at (1, 1).
TEST(Simplex, RosenbrockValley) {
  const auto valley = [](const std::array<double, 2>& x) {
    return 100.0 * std::pow(x[1] - x[0] * x[0], 2) + std::pow(1.0 - x[0], 2);
  };
  const auto x = minimise_simplex<2>(valley, {-1.2, 1.0}, {0.5, 0.5}, 1000, 1e-14);
  EXPECT_NEAR(x[0], 1.0, 1e-4);
  EXPECT_NEAR(x[1], 1.0, 1e-4);
}

TEST(Simplex, AParameterWithoutStepStays) {
  const auto bowl = [](const std::array<double, 2>& x) { return x[0] * x[0] + x[1] * x[1]; };
  const auto x = minimise_simplex<2>(bowl, {3.0, 2.0}, {0.5, 0.0}, 500, 1e-12);
  EXPECT_NEAR(x[0], 0.0, 1e-4);
  EXPECT_EQ(x[1], 2.0);
}

}  // namespace
}  // namespace furrow::rows
