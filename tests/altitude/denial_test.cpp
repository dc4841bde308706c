// Which shots a flight leaves out, by what each says alone.
#include "altitude/denial.h"

#include <gtest/gtest.h>

namespace furrow::altitude {
namespace {

JudgedShot shot_of(double height_m, double sigma_m, double log_m, double residual_rms = 1.0) {
  return {"shot", {height_m, sigma_m, 10}, log_m, residual_rms};
}

std::vector<std::string> codes(const std::vector<JudgedShot>& shots) {
  std::vector<std::string> codes;
  for (const auto& error : denied_shots(shots, {})) codes.push_back(error ? error->code : "");
  return codes;
}

// Two good heights, three that say little, and one at twice the height: what the unsure ones scatter by is
// what they claim, and does not make the wrong one credible.
TEST(Denial, UnsureNeighboursDoNotHideAMiscount) {
  const auto found = codes({shot_of(1.15, 0.04, 0.0), shot_of(0.94, 0.25, 0.0), shot_of(2.11, 0.07, -0.1),
                            shot_of(1.16, 0.11, -0.1), shot_of(1.52, 0.30, -0.3), shot_of(1.11, 0.25, -0.1)});
  EXPECT_EQ(found, (std::vector<std::string>{"", "", "denied_by_neighbours", "", "", ""}));
}

// Seven heights over corn of which one counts every second row: neighbours that scatter leave it within five
// sigmas, but half of it is what they say.
TEST(Denial, TwiceTheNeighboursHeightIsAMiscount) {
  const std::vector<JudgedShot> shots = {shot_of(1.10, 0.06, 0.0),  shot_of(1.05, 0.10, 0.0),
                                        shot_of(2.12, 0.08, -0.1), shot_of(1.15, 0.07, -0.1),
                                        shot_of(1.34, 0.16, -0.3), shot_of(1.35, 0.07, -0.1)};
  EXPECT_EQ(codes(shots), (std::vector<std::string>{"", "", "denied_by_neighbours", "", "", ""}));
  auto right = shots;
  right[2].height_above_canopy_m.value = 1.75;  // as sure, and half or twice of it is no better
  EXPECT_EQ(codes(right), std::vector<std::string>(6, ""));
}

// The same heights, all claimed to 2 cm: nobody can say who is right.
TEST(Denial, SureNeighboursThatDisagreeDenyNobody) {
  const auto found = codes({shot_of(1.15, 0.02, 0.0), shot_of(0.64, 0.02, 0.0), shot_of(2.11, 0.02, 0.0),
                            shot_of(1.16, 0.02, 0.0), shot_of(1.82, 0.02, 0.0), shot_of(0.61, 0.02, 0.0)});
  EXPECT_EQ(found, std::vector<std::string>(6, ""));
}

TEST(Denial, AShotWithoutALogHeightIsNoNeighbour) {
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  const auto found = codes({shot_of(1.1, 0.05, 0.0), shot_of(9.0, 0.05, unknown), shot_of(1.2, 0.05, 0.0),
                            shot_of(9.0, 0.05, unknown), shot_of(9.0, 0.05, unknown), shot_of(3.0, 0.05, 0.0),
                            shot_of(1.1, 0.05, 0.0), shot_of(1.2, 0.05, 0.0)});
  EXPECT_EQ(found, (std::vector<std::string>{"", "", "", "", "", "denied_by_neighbours", "", ""}));
}

TEST(Denial, RowsThatFitFarWorseThanTheOthersAreNamedFirst) {
  auto shots = std::vector<JudgedShot>(5, shot_of(2.0, 0.05, 0.0, 1.1));
  shots[1].residual_rms = 3.5;
  EXPECT_EQ(codes(shots), (std::vector<std::string>{"", "rows_do_not_fit", "", "", ""}));
  for (JudgedShot& shot : shots) shot.residual_rms *= 3.0;
  shots[1].residual_rms = 7.0;  // where all fit badly, the claims are wrong
  EXPECT_EQ(codes(shots), std::vector<std::string>(5, ""));
}

TEST(Denial, ThreeShotsCannotOutvoteOne) {
  EXPECT_EQ(codes({shot_of(1.0, 0.05, 0.0, 9.0), shot_of(1.0, 0.05, 0.0), shot_of(4.0, 0.05, 0.0)}),
            std::vector<std::string>(3, ""));
}

}  // namespace
}  // namespace furrow::altitude
