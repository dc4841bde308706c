#include "rows/follow_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "furrow/base/random.h"

namespace furrow::rows {
namespace {

constexpr int kWidth = 320, kHeight = 240, kStrips = 80;

PlanarField oblique() {
  PlanarField field;
  field.u0 = 159.5, field.v0 = 239.0, field.length = 240.0;
  field.convergence = 0.8, field.spacing = 100.0, field.offset = 10.0;
  return field;
}

/// Strips that respond with cos(2 pi k) times `strength` to rows `shift(v)` spacings beside the field's.
Response response_of(const PlanarField& field, double strength, double noise,
                     const std::function<double(double)>& shift) {
  base::Random random(1);
  Response response;
  response.width = kWidth;
  for (int j = 0; j < kStrips; ++j) {
    const double v = (j + 0.5) * kHeight / kStrips;
    response.v.push_back(static_cast<float>(v));
    for (int u = 0; u < kWidth; ++u)
      response.value.push_back(static_cast<float>(
          strength * std::cos(2.0 * std::numbers::pi * (field.k_at(u, v) - shift(v))) +
          random.normal(0.0, noise)));
  }
  return response;
}

/// Departure of a followed field's middle row from the plane, spacings, at its i-th strip.
double departure(const FollowedField& followed, const PlanarField& field, std::size_t i) {
  const double v = followed.v[i];
  return (followed.centre[i] - field.u_at(v, followed.centre_k)) / field.spacing_at(v);
}

TEST(FollowField, RowsThatLeaveThePlaneAreFollowed) {
  const PlanarField field = oblique();
  // A quarter of a spacing aside beyond the picture's middle, as over a crest.
  const auto shift = [](double v) { return 0.125 * (1.0 + std::tanh((100.0 - v) / 15.0)); };
  const FollowedField followed = follow(response_of(field, 0.6, 0.3, shift), field, 0.0, 2.0);
  ASSERT_EQ(followed.v.size(), static_cast<std::size_t>(kStrips));
  for (std::size_t i = 0; i < followed.v.size(); ++i)
    EXPECT_NEAR(departure(followed, field, i), shift(followed.v[i]), 0.05) << followed.v[i];
}

// Of all ways through noise one fits best; it says nothing, and the mean over all ways stays near the plane.
TEST(FollowField, NoiseIsNotFollowed) {
  const PlanarField field = oblique();
  const auto none = [](double) { return 0.0; };
  const FollowedField followed = follow(response_of(field, 0.0, 0.3, none), field, 0.0, 2.0);
  for (std::size_t i = 0; i < followed.v.size(); ++i) {
    EXPECT_LT(std::abs(departure(followed, field, i)), 0.2) << followed.v[i];
    EXPECT_NEAR(followed.spacing[i] / field.spacing_at(followed.v[i]), 1.0, 0.08) << followed.v[i];
  }
}

TEST(FollowField, NothingBelowTheHorizonIsNothingToFollow) {
  PlanarField field = oblique();
  field.v0 = -500.0;
  const auto none = [](double) { return 0.0; };
  field.convergence = -4.0;
  EXPECT_TRUE(follow(response_of(oblique(), 0.6, 0.0, none), field, 0.0, 2.0).v.empty());
}

}  // namespace
}  // namespace furrow::rows
