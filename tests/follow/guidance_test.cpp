#include "furrow/follow/guidance.h"

#include <gtest/gtest.h>

namespace furrow::follow {
namespace {

TEST(Pid, PartsByHand) {
  // 2 x 0.5 + (0.1 + 1 x 0.5 x 0.2) + 0.3 x (-1) = 0.9.
  const PidOptions options{.kp = 2.0, .ki = 1.0, .kd = 0.3, .limit = 5.0, .integral_limit = 1.0};
  const PidStep step = pid_step({0.1}, options, 0.5, -1.0, 0.2);
  EXPECT_NEAR(step.output, 0.9, 1e-12);
  EXPECT_NEAR(step.state.integral, 0.2, 1e-12);
  EXPECT_FALSE(step.is_limited);
}

TEST(Pid, OutputIsLimitedAndTheIntegralDoesNotWindUp) {
  const PidOptions options{.kp = 1.0, .ki = 1.0, .kd = 0.0, .limit = 0.5, .integral_limit = 10.0};
  PidState state;
  for (int i = 0; i < 1000; ++i) {
    const PidStep step = pid_step(state, options, 2.0, 0.0, 0.1);
    EXPECT_DOUBLE_EQ(step.output, 0.5);
    EXPECT_TRUE(step.is_limited);
    state = step.state;
  }
  // Without the guard the integral would stand at 10 and the output at its limit for seconds after the error
  // is gone.
  EXPECT_LE(state.integral, 0.5);
  EXPECT_LT(pid_step(state, options, -0.1, 0.0, 0.1).output, 0.5);
}

TEST(Pid, AConstantWindIsTakenOutByTheIntegral) {
  const PidOptions options{.kp = 0.5, .ki = 0.05, .kd = 0.1, .limit = 0.5, .integral_limit = 0.2};
  constexpr double kDt = 1.0 / 30.0, kWind = 0.1;
  PidState state;
  double offset = 1.0, rate = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const PidStep step = pid_step(state, options, offset, rate, kDt);
    state = step.state;
    rate = kWind - step.output;
    offset += rate * kDt;
  }
  EXPECT_NEAR(offset, 0.0, 0.01);
}

TEST(Guidance, SteersBackToTheRow) {
  GuidanceOptions options;
  options.forward_mps = 1.0;
  // Camera left of the row and turned to the left: to the right, and clockwise.
  const Guidance right = guidance_step({}, SteeringError{0.4, 0.0, 0.1}, 0.1, options);
  EXPECT_GT(right.velocity.right_mps, 0.0);
  EXPECT_GT(right.velocity.yaw_rate_rad_s, 0.0);
  EXPECT_DOUBLE_EQ(right.velocity.forward_mps, 1.0);
  EXPECT_LT(guidance_step({}, SteeringError{-0.4, 0.0, -0.1}, 0.1, options).velocity.right_mps, 0.0);
}

TEST(Guidance, HoldStandsStillAndForgets) {
  GuidanceOptions options;
  options.forward_mps = 1.0;
  const Guidance before = guidance_step({}, SteeringError{0.4, 0.0, 0.1}, 1.0, options);
  const Guidance hold = guidance_step(before, std::nullopt, 0.1, options);
  EXPECT_TRUE(hold.is_hold);
  EXPECT_EQ(hold.velocity.forward_mps, 0.0);
  EXPECT_EQ(hold.velocity.right_mps, 0.0);
  EXPECT_EQ(hold.velocity.yaw_rate_rad_s, 0.0);
  EXPECT_EQ(hold.lateral.integral, 0.0);
}

}  // namespace
}  // namespace furrow::follow
