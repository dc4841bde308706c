#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "furrow/audit/budget.h"
#include "furrow/audit/finding.h"
#include "furrow/audit/legs.h"
#include "furrow/audit/shot_record.h"
#include "furrow/audit/truth.h"

namespace furrow::audit {
namespace {

ShotRecord shot(const std::string& id, double height_m, double log_m) {
  ShotRecord record;
  record.shot_id = id;
  record.image = id + ".jpg";
  record.status = "ok";
  record.above_canopy_refined_m = {height_m, 0.05, 20};
  record.height_takeoff_m = log_m;
  record.pitch_log_deg = -12.0;
  record.pitch_deg = {-12.7, 0.2, 20};
  return record;
}

const Finding& find(const std::vector<Finding>& findings, const std::string& id) {
  const auto found =
      std::find_if(findings.begin(), findings.end(), [&](const Finding& f) { return f.id == id; });
  EXPECT_NE(found, findings.end()) << id;
  return *found;
}

TEST(ShotsTable, LeavesEmptyWhatIsNotKnown) {
  ShotRecord record;
  record.shot_id = "a,b";
  record.status = "no_rows";
  const auto table = shots_table({record, shot("b", 2.0, 3.7)});
  const auto cell = [&](std::size_t row, const char* name) {
    return table.rows[row][table.column(name).value()];
  };
  EXPECT_EQ(cell(0, "above_canopy_refined_m"), "");
  EXPECT_EQ(cell(0, "t_utc"), "");
  EXPECT_EQ(cell(1, "above_canopy_refined_m"), "2.0000");
  EXPECT_EQ(cell(1, "above_canopy_refined_sigma_m"), "0.0500");
  EXPECT_EQ(cell(1, "height_takeoff_m"), "3.700");
  for (const auto& row : table.rows) EXPECT_EQ(row.size(), table.columns.size());
}

TEST(AssessShots, NamesWhatIsMissingOncePerReason) {
  std::vector<ShotRecord> records = {shot("a", 2.0, 3.7), shot("b", 2.1, 3.8)};
  for (const char* id : {"c", "d", "e", "f"}) {
    records.push_back({});
    records.back().shot_id = id;
    records.back().status = "no_rows";
    records.back().reason = "nothing green";
  }
  const Finding finding = find(assess_shots(records, 1.7), "shots.with_height");
  EXPECT_EQ(finding.verdict, Verdict::fail);
  EXPECT_EQ(finding.value, "2 of 6 (33 %)");
  EXPECT_EQ(finding.evidence, "4 no_rows (c, d, e, ...): nothing green");
}

TEST(AssessShots, JudgesTheLogAgainstTheRows) {
  const std::vector<ShotRecord> good = {shot("a", 2.0, 3.8), shot("b", 2.1, 3.7)};
  EXPECT_EQ(find(assess_shots(good, 1.7), "heights.log").verdict, Verdict::pass);
  EXPECT_EQ(find(assess_shots(good, 1.7), "pitch.bias").value, "0.70 deg on average, sd 0.00 deg");
  const std::vector<ShotRecord> high = {shot("a", 2.0, 5.7), shot("b", 2.1, 5.8)};
  EXPECT_EQ(find(assess_shots(high, 1.7), "heights.log").verdict, Verdict::fail);
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(find(assess_shots(good, unknown), "heights.log").verdict, Verdict::not_assessed);
  EXPECT_EQ(find(assess_shots({}, 1.7), "shots.with_height").verdict, Verdict::not_assessed);
}

TEST(AssessFocal, ComparesWithTheStatedLens) {
  // A Phantom 4 Pro: 24 mm equivalent on a 3:2 sensor, 8.8 mm of 13.2 mm: 853 px at 1280; the thesis
  // calibrated 874.33.
  EXPECT_EQ(assess_focal(853.3, 1280, 24.0).verdict, Verdict::pass);
  EXPECT_EQ(assess_focal(874.33, 1280, 24.0).verdict, Verdict::pass);
  EXPECT_EQ(assess_focal(964.0, 1280, 24.0).verdict, Verdict::fail);
  EXPECT_EQ(assess_focal(700.0, 1280, 24.0).verdict, Verdict::fail);
  EXPECT_EQ(assess_focal(853.0, 1280, ShotRecord::kMissing).verdict, Verdict::not_assessed);
}

TEST(AssessCalibration, ListsUnusedPictures) {
  calib::Calibration calibration;
  calibration.usable = true;
  calibration.rms_px = 1.5;
  calibration.views.resize(2);
  calibration.views[0].used = true;
  calibration.views[1].image = "b.jpg";
  calibration.views[1].reason = "no board found";
  const Finding finding = assess_calibration(calibration, {})[0];
  EXPECT_EQ(finding.verdict, Verdict::fail);
  EXPECT_NE(finding.evidence.find("b.jpg (no board found)"), std::string::npos);
}

/// Three stretches of four shots at 3, 4 and 5 m by a log that is right; the thesis errs by +0.5 and -0.5 m.
std::vector<ShotRecord> three_legs() {
  std::vector<ShotRecord> records;
  for (int i = 0; i < 12; ++i) {
    const double ground_m = 3.0 + i / 4;
    auto& r = records.emplace_back(shot("s" + std::to_string(i), ground_m - 1.7, ground_m));
    r.above_canopy_thesis_m.value = ground_m - 1.7 + (i % 2 == 0 ? 0.5 : -0.5);
  }
  records[5].above_canopy_thesis_m = {};
  return records;
}

TEST(HeightLegs, FollowTheLogsSteps) {
  const auto legs = height_legs(three_legs());
  ASSERT_EQ(legs.size(), 3U);
  EXPECT_EQ(legs[0].first, 0U);
  EXPECT_EQ(legs[0].last, 3U);
  EXPECT_EQ(legs[2].last, 11U);
  EXPECT_NEAR(legs[1].mean_height_m, 4.0, 1e-12);
  EXPECT_TRUE(height_legs({}).empty());
  EXPECT_TRUE(height_legs(std::vector<ShotRecord>(4)).empty());
}

TEST(LegTable, CountsAsTheThesisDid) {
  const auto table = leg_table(three_legs(), 1.7);
  ASSERT_EQ(table.rows.size(), 8U);  // thesis and refined for three legs and in total
  EXPECT_EQ(table.rows[0], (std::vector<std::string>{"log at 3.0 m", "thesis, automatic half width", "4 of 4",
                                                     "3.000", "0.000", "0.577"}));
  EXPECT_EQ(table.rows[2][2], "3 of 4");
  EXPECT_EQ(table.rows[7][0], "total");
  EXPECT_EQ(table.rows[7][3], "4.000");
  EXPECT_TRUE(leg_table(three_legs(), std::nan("")).rows.empty());
}

TEST(Budget, LargestCauseIsByVarianceRelativeToTheHeight) {
  const std::vector<ShotBudget> budgets = {{"a", {1.0, 0.05, 1}, {{"plants", 0.04}, {"spacing", 0.03}}},
                                           {"b", {10.0, 0.05, 1}, {{"plants", 0.03}, {"spacing", 0.04}}},
                                           {"c", {}, {}}};
  const auto causes = causes_of(budgets);
  ASSERT_EQ(causes.size(), 2U);
  EXPECT_EQ(causes[0].cause, "plants");
  EXPECT_NEAR(causes[0].variance_share + causes[1].variance_share, 1.0, 1e-12);
  const auto table = budget_table(budgets);
  EXPECT_EQ(table.rows[0], (std::vector<std::string>{"a", "1.0000", "0.0500", "0.0400", "0.0300"}));
  EXPECT_EQ(table.rows[2], (std::vector<std::string>{"c", "", "", "", ""}));
  EXPECT_TRUE(causes_of({}).empty());
}

TEST(CompareWithTruth, FormsErrorsPerMethod) {
  std::vector<ShotRecord> records(2);
  records[0].truth_above_canopy_m = 2.0;
  records[0].above_canopy_refined_m = {2.1, 0.1, 5};
  records[1].truth_above_canopy_m = 4.0;
  records[1].above_canopy_refined_m = {4.0, 0.1, 5};
  for (auto& record : records) record.refined_in_flight = true;
  const auto lines = compare_with_truth(records);
  ASSERT_EQ(lines.size(), 1U);  // the other ways gave no height
  EXPECT_EQ(lines[0].method, "refined, whole flight");
  EXPECT_EQ(lines[0].shots, 2);
  EXPECT_NEAR(lines[0].mean_error_m, 0.05, 1e-12);
  EXPECT_NEAR(lines[0].rmse_share, 0.05 / 1.41421356, 1e-8);
  EXPECT_EQ(comparison_table(lines).rows.at(0).at(4), "0.071");
  EXPECT_TRUE(compare_with_truth({{}}).empty());
}

TEST(JoinTruth, NamesATableThatIsNoTruthOfThisFlight) {
  std::vector<ShotRecord> records(2);
  records[0].shot_id = "a";
  records[1].shot_id = "b";
  const auto joined = [&](const char* csv) {
    return join_truth(records, base::parse_csv(csv, "truth.csv").value());
  };
  EXPECT_EQ(joined("shot_id,height\na,2\n").error().code, "truth_column_missing");
  EXPECT_EQ(joined("shot_id,height_above_canopy_m\nc,2\n").error().code, "truth_without_shots");
  ASSERT_TRUE(joined("shot_id,height_above_canopy_m\nb,2.5\n").ok());
  EXPECT_EQ(records[1].truth_above_canopy_m, 2.5);
  EXPECT_TRUE(std::isnan(records[0].truth_above_canopy_m));
}

}  // namespace
}  // namespace furrow::audit
