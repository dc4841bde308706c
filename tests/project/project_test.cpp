#include "furrow/project/project.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <tuple>

#include "damaged.h"
#include "furrow/base/file.h"
#include "furrow/base/text.h"
#include "furrow/base/value.h"
#include "furrow/project/jobs.h"
#include "project/hand_widths.h"
#include "project/shot_chain.h"

namespace furrow::project {
namespace {

namespace fs = std::filesystem;

class ProjectTest : public ::testing::Test {
 protected:
  ProjectTest() : folder_(fs::temp_directory_path() / ("furrow_project_test_" + std::to_string(::getpid()))) {
    fs::remove_all(folder_);
    for (const char* name : {"frames/a10.jpg", "frames/a2.jpg", "camera.yaml", "airdata.csv"}) {
      EXPECT_TRUE(base::write_file(folder_ / name, "").ok());
    }
  }
  ~ProjectTest() override { fs::remove_all(folder_); }

  Result<Project> read(const std::string& yaml) {
    EXPECT_TRUE(base::write_file(folder_ / "project.yaml", yaml).ok());
    return read_project(folder_ / "project.yaml");
  }

  fs::path folder_;
};

// The smallest form that every user may write.
constexpr const char* kSmallest = R"(name: vineyard-3m
camera: { model: camera.yaml }
shots:  { images: frames/*.jpg }
telemetry: { file: airdata.csv }
rows:   { spacing_m: 3.0, spacing_sigma_m: 0.03, half_width_m: 0.60, height_m: 1.70 }
)";

TEST_F(ProjectTest, ReadsTheSmallestForm) {
  const auto project = read(kSmallest);
  ASSERT_TRUE(project.ok()) << project.error().message();
  EXPECT_EQ(project->name, "vineyard-3m");
  EXPECT_EQ(project->camera_model, folder_ / "camera.yaml");
  ASSERT_EQ(project->images.size(), 2U);
  EXPECT_EQ(project->images[0].filename(), "a2.jpg");
  EXPECT_EQ(project->telemetry, folder_ / "airdata.csv");
  EXPECT_EQ(project->field.row_spacing_m.value, 3.0);
  EXPECT_EQ(project->field.row_spacing_m.sigma, 0.03);
  EXPECT_EQ(project->field.half_width_m.sigma, 0.60 * kDefaultHalfWidthSigmaShare);
  EXPECT_FALSE(project->field.foliage_depth_m.usable());
}

TEST_F(ProjectTest, TheOutlinesRiseMayBeNegativeAndComesWithItsSigma) {
  const auto with_rows = [&](const std::string& keys) {
    std::string text = kSmallest;
    text.replace(text.find("height_m: 1.70"), 14, "height_m: 1.70, " + keys);
    return read(text);
  };
  const auto given = with_rows("outline_rise_m: -0.02, outline_rise_sigma_m: 0.01");
  ASSERT_TRUE(given.ok()) << given.error().message();
  EXPECT_EQ(given->field.outline_rise_m.value, -0.02);
  EXPECT_EQ(given->field.outline_rise_m.sigma, 0.01);
  EXPECT_EQ(given->slope_sigma_deg, 0.5);
  EXPECT_EQ(given->slope_across_sigma_deg, 3.0);
  EXPECT_EQ(with_rows("slope_sigma_deg: 3")->slope_sigma_deg, 3.0);
  EXPECT_EQ(with_rows("slope_across_sigma_deg: 1")->slope_across_sigma_deg, 1.0);
  EXPECT_FALSE(with_rows("slope_sigma_deg: 0").ok());
  EXPECT_FALSE(with_rows("slope_across_sigma_deg: 0").ok());
  EXPECT_FALSE(with_rows("outline_rise_m: 0.02").ok());
  EXPECT_FALSE(with_rows("outline_rise_m: 0.02, outline_rise_sigma_m: -1").ok());
}

TEST_F(ProjectTest, APitchThatNobodyLoggedMayBeStated) {
  const std::string head =
      "name: f\ncamera: { model: c.yaml }\nshots: { images: a.jpg }\nrows: { spacing_m: 3 }\n";
  const auto project = read(head + "telemetry: { gimbal_pitch_deg: -60 }\n");
  ASSERT_TRUE(project.ok()) << project.error().message();
  EXPECT_EQ(project->gimbal_pitch_deg, -60.0);
  for (const char* pitch : {"60", "-91"}) {
    const auto wrong = read(head + "telemetry: { gimbal_pitch_deg: " + pitch + " }\n");
    ASSERT_FALSE(wrong.ok()) << pitch;
    EXPECT_NE(wrong.error().message().find("gimbal_pitch_deg"), std::string::npos);
  }
}

TEST_F(ProjectTest, ReadsHalfWidthsMeasuredByHand) {
  const auto read_widths = [&](const std::string& csv) {
    EXPECT_TRUE(base::write_file(folder_ / "widths.csv", csv).ok());
    return read_hand_widths(folder_ / "widths.csv");
  };
  const auto widths = read_widths("shot_id,half_width_px\na2,40\na10,\n");
  ASSERT_TRUE(widths.ok()) << widths.error().message();
  EXPECT_EQ(*widths, (std::map<std::string, double>{{"a2", 40.0}}));
  EXPECT_EQ(read_widths("shot,px\na,1\n").error().code, "missing_column");
  EXPECT_EQ(read_widths("shot_id,half_width_px\na2,40\na10,wide\n").error().message(),
            "widths.csv:3: half_width_px is 'wide'; wanted pixels above 0, or an empty cell.");
  const std::string whole = "shot_id,half_width_px\na2,40\n\"a,10\",12.5\n";
  base::Random random(27112026);
  for (int i = 0; i < 1000; ++i) {
    const auto damaged = read_widths(testing::damaged(whole, random));
    if (!damaged.ok()) {
      EXPECT_FALSE(damaged.error().code.empty());
      continue;
    }
    for (const auto& [shot, width] : *damaged) EXPECT_GT(width, 0.0);
  }
}

// f 873.35, dm 0.60, pix 95, 13.8 deg: the thesis's worked example (section 5).
TEST(ThesisHeight, IsTheWorkedExampleWithAWidthByHand) {
  Camera camera;
  camera.fx = 873.35;
  altitude::FieldKnowledge field;
  field.half_width_m = {0.60, 0.05, 1};
  const altitude::AttitudePrior prior{{-13.8 * 3.14159265358979 / 180.0, 0.01, 1}, {}};
  EXPECT_NEAR(thesis_height(95.0, camera, field, prior).value, 1.31, 0.01);
  EXPECT_FALSE(std::isfinite(thesis_height(95.0, camera, {}, prior).value));
}

TEST_F(ProjectTest, RefusesUnknownKeysWithTheNearestNameAndTheLine) {
  std::string yaml = kSmallest;
  yaml.replace(yaml.find("spacing_sigma_m"), 15, "spacing_sgima_m");
  EXPECT_EQ(read(yaml).error().message(),
            "project.yaml:5: unknown key 'spacing_sgima_m' in 'rows'; wanted 'spacing_sigma_m' perhaps.");
  EXPECT_NE(
      read(std::string(kSmallest) + "row: {}\n").error().message().find("project.yaml:6: unknown key 'row'"),
      std::string::npos);
}

TEST_F(ProjectTest, NamesWhatIsMissingOrWrong) {
  EXPECT_EQ(read("name: x\nshots: { images: frames/*.jpg }\n").error().message(),
            "project.yaml: 'camera' is missing.");
  EXPECT_EQ(read("name: x\ncamera: {}\nshots: { images: frames/*.jpg }\n").error().code, "bad_value");
  EXPECT_EQ(read("name: x\ncamera: { model: camera.yaml }\nshots: { images: frames/*.tif }\n").error().code,
            "no_match");
  EXPECT_EQ(read("name: x\ncamera: { model: camera.yaml }\nshots: { images: \"${FURROW_NOT_SET}/*.jpg\" }\n")
                .error()
                .code,
            "variable_unset");
  EXPECT_EQ(read("name: [\n").error().code, "malformed_yaml");
  const auto negative = read(
      "name: x\ncamera: { model: camera.yaml }\nshots: { images: frames/*.jpg }\nrows: { spacing_m: -3 }\n");
  EXPECT_EQ(negative.error().message(),
            "project.yaml:4: rows.spacing_m is -3; wanted metres, from 0.001 to 100.");
  EXPECT_EQ(read_project(folder_ / "none.yaml").error().code, "file_missing");
}

// Each of these was measured with once, and told of shot by shot or not at all.
TEST_F(ProjectTest, RefusesFarmsThatCannotBeWithTheLine) {
  const std::string head = "name: x\ncamera: { model: camera.yaml }\nshots: { images: frames/*.jpg }\n";
  for (const auto& [rows, words] : std::map<std::string, std::string>{
           {"spacing_m: 3000", "rows.spacing_m is 3000; wanted metres, from 0.001 to 100."},
           {"spacing_m: 1e-300", "rows.spacing_m is 1e-300; wanted metres, from 0.001 to 100."},
           {"spacing_m: 3, height_m: 1e9", "rows.height_m is 1e+09; wanted metres, from 0.001 to 100."},
           {"spacing_m: .nan", "rows.spacing_m is '.nan'; wanted a number."},
           {"spacing_m: 3, half_width_m: 2",
            "rows.half_width_m is 2 for rows 3 m apart; wanted at most half of that."}}) {
    const auto project = read(head + "rows: { " + rows + " }\n");
    ASSERT_FALSE(project.ok()) << rows;
    EXPECT_EQ(project.error().message(), "project.yaml:4: " + words);
  }
}

TEST_F(ProjectTest, AnEmptyListOfPicturesIsASlip) {
  const auto project = read("name: x\ncamera: { model: camera.yaml }\nshots: { images: [] }\n");
  ASSERT_FALSE(project.ok());
  EXPECT_EQ(project.error().message(),
            "project.yaml:3: shots.images is an empty list; wanted a pattern, or a list of them.");
}

// A damaged project is a project whose numbers can be, or an error that says where.
TEST_F(ProjectTest, DamagedFilesGiveProjectsOrErrors) {
  const std::string whole =
      std::string(kSmallest) + "depth: { maps: [frames/a2.jpg], values: metres, unit_per_count: 0.004 }\n";
  base::Random random(27112026);
  for (int i = 0; i < 3000; ++i) {
    const auto project = read(testing::damaged(whole, random));
    if (!project.ok()) {
      EXPECT_FALSE(project.error().code.empty());
      EXPECT_FALSE(project.error().message().empty());
      continue;
    }
    EXPECT_FALSE(project->images.empty());
    for (const Estimate& length : {project->field.row_spacing_m, project->field.row_height_m})
      EXPECT_TRUE(std::isnan(length.value) || (length.value > 0.0 && length.value <= 100.0));
  }
}

// "one of a, b" of an unknown key's error must name the schema's properties: the two are written apart and
// must not drift.
TEST_F(ProjectTest, SchemaNamesTheSameKeys) {
  const auto schema = base::read_json(fs::path(FURROW_SOURCE_DIR) / "projects/project.schema.json");
  ASSERT_TRUE(schema.ok());
  const base::Value* top = schema->find("properties");
  const std::string images = "images: frames/*.jpg";
  const std::vector<std::tuple<std::string, const base::Value*, std::string>> sections = {
      {"", top, "name: x\nqqqqqqqqqqqqqq: 1\n"},
      {"camera", top->find("camera")->find("properties"),
       "name: x\nshots: {}\ncamera: { qqqqqqqqqqqqqq: 1 }\n"},
      {"camera.calibrate", top->find("camera")->find("properties")->find("calibrate")->find("properties"),
       "name: x\nshots: {}\ncamera: { calibrate: { " + images + ", target: t, qqqqqqqqqqqqqq: 1 } }\n"},
      {"shots", top->find("shots")->find("properties"),
       "name: x\ncamera: { model: camera.yaml }\nshots: { " + images + ", qqqqqqqqqqqqqq: 1 }\n"},
      {"telemetry", top->find("telemetry")->find("properties"),
       "name: x\ncamera: { model: camera.yaml }\nshots: { " + images +
           " }\ntelemetry: { qqqqqqqqqqqqqq: 1 }\n"},
      {"depth", top->find("depth")->find("properties"),
       "name: x\ncamera: { model: camera.yaml }\nshots: { " + images +
           " }\ndepth: { maps: frames/*.jpg, qqqqqqqqqqqqqq: 1 }\n"},
      {"rows", top->find("rows")->find("properties"),
       "name: x\ncamera: { model: camera.yaml }\nshots: { " + images + " }\nrows: { qqqqqqqqqqqqqq: 1 }\n"}};
  for (const auto& [section, properties, yaml] : sections) {
    const auto project = read(yaml);
    ASSERT_FALSE(project.ok()) << section;
    ASSERT_EQ(project.error().code, "unknown_key") << section << ": " << project.error().message();
    std::set<std::string> accepted;
    const std::string names = project.error().wanted.substr(std::string("one of ").size());
    for (const auto part : base::split(names, ',')) {
      accepted.insert(std::string(base::trim(part)));
    }
    std::set<std::string> described;
    for (const auto& [key, property] : *properties->object()) described.insert(key);
    EXPECT_EQ(accepted, described) << section;
  }
}

TEST_F(ProjectTest, DepthMapsHaveAUnit) {
  const std::string start = "name: x\ncamera: { model: camera.yaml }\nshots: { images: frames/*.jpg }\n";
  EXPECT_FALSE(read(start)->depth);
  const auto disparity = read(start + "depth: { maps: frames/*.jpg }\n");
  ASSERT_TRUE(disparity.ok()) << disparity.error().message();
  EXPECT_TRUE(disparity->depth->disparity);
  EXPECT_NEAR(disparity->depth->unit_per_count, 1.0 / 65535.0, 1e-12);
  EXPECT_EQ(disparity->depth->maps.size(), disparity->images.size());
  const auto metres = read(start + "depth: { maps: frames/*.jpg, values: metres, scale_sigma: 0.02 }\n");
  ASSERT_TRUE(metres.ok()) << metres.error().message();
  EXPECT_NEAR(metres->depth->unit_per_count, 1.0 / 256.0, 1e-12);
  EXPECT_NEAR(metres->depth->scale_sigma, 0.02, 1e-12);
  EXPECT_EQ(read(start + "depth: { maps: frames/*.jpg, values: feet }\n").error().code, "bad_value");
  EXPECT_EQ(read(start + "depth: { maps: none/*.npy }\n").error().code, "no_match");
}

TEST_F(ProjectTest, BundledProjectsAreReadable) {
  for (const auto& entry : fs::directory_iterator(fs::path(FURROW_SOURCE_DIR) / "projects")) {
    if (!fs::exists(entry.path() / "project.yaml")) continue;
    const auto project = read_project(entry.path() / "project.yaml");
    // Pictures may be absent on this machine; the file itself must be right.
    EXPECT_TRUE(project.ok() || project.error().code == "no_match") << project.error().message();
  }
}

}  // namespace
}  // namespace furrow::project
