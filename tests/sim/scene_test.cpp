#include <gtest/gtest.h>

#include "damaged.h"
#include "furrow/sim/simulate.h"

namespace furrow::sim {
namespace {

const std::filesystem::path kProjects = std::filesystem::path(FURROW_SOURCE_DIR) / "projects";
constexpr const char* kLegs = "flight:\n  legs:\n    - { shots: 2 }\n";

TEST(Scene, FileOfTheDemoIsTheDemo) {
  const Result<Scene> read = read_scene(kProjects / "vineyard-demo" / "scene.yaml");
  ASSERT_TRUE(read.ok()) << read.error().message();
  EXPECT_EQ(to_yaml(*read), to_yaml(demo_scene()));
}

TEST(Scene, EveryExampleReads) {
  for (const char* name : {"sim-oblique-8m", "sim-nadir-30m", "sim-climb", "sim-hills", "sim-corn"}) {
    const Result<Scene> read = read_scene(kProjects / name / "scene.yaml");
    ASSERT_TRUE(read.ok()) << name << ": " << read.error().message();
    EXPECT_EQ(read->name, name);
  }
}

TEST(Scene, WritesWhatItReads) {
  Scene scene = demo_scene();
  scene.field.crop = Crop::corn;
  scene.flight.follow_terrain = false;
  scene.camera.model = camera::CameraModel::pinhole;
  scene.camera.distortion.clear();
  const Result<Scene> read = parse_scene(to_yaml(scene), "copy.yaml");
  ASSERT_TRUE(read.ok()) << read.error().message();
  EXPECT_EQ(to_yaml(*read), to_yaml(scene));
  EXPECT_NE(to_yaml(*read), to_yaml(demo_scene()));
}

TEST(Scene, UnknownKeyIsRefusedWithLineAndNearestName) {
  const Result<Scene> read =
      parse_scene(std::string(kLegs) + "field:\n  spacing_m: 3\n  half_widht_m: 0.6\n", "a.yaml");
  ASSERT_FALSE(read.ok());
  const std::string message = read.error().message();
  EXPECT_EQ(read.error().code, "unknown_key") << message;
  EXPECT_NE(message.find("a.yaml:6"), std::string::npos) << message;
  EXPECT_NE(message.find("half_width_m"), std::string::npos) << message;
}

TEST(Scene, ValueOutOfRangeIsRefusedWithLine) {
  const Result<Scene> read = parse_scene(std::string(kLegs) + "field: { spacing_m: -3 }\n", "a.yaml");
  ASSERT_FALSE(read.ok());
  EXPECT_NE(read.error().message().find("a.yaml:4"), std::string::npos) << read.error().message();
  EXPECT_NE(read.error().message().find("-3"), std::string::npos) << read.error().message();
}

TEST(Scene, ContradictionsAreRefused) {
  for (const char* part :
       {"field: { half_width_m: 1.6 }", "field: { foliage_bottom_m: 1.8 }",
        "field: { base_half_width_m: 0.7 }", "camera: { distortion: [0.1] }",
        "field: { soil_rgb: [0.1, 0.2] }", "flight: { legs: [] }", "flight: 3",
        "flight: { legs: [ { shots: 0 } ] }",
        "flight: { legs: [ { shots: 1 } ], start_utc: \"2024-13-01 00:00:00\" }", "field: { crop: rice }",
        "flight: { legs: { shots: 1 } }", "pictures: { noise: .nan }", "seed: -1"}) {
    const std::string text = std::string(part);
    const bool has_legs = text.find("flight") != std::string::npos;
    EXPECT_FALSE(parse_scene((has_legs ? "" : kLegs) + text + "\n", "a.yaml").ok()) << part;
  }
  EXPECT_TRUE(parse_scene(kLegs, "a.yaml").ok());
  EXPECT_FALSE(parse_scene("", "a.yaml").ok()) << "a scene without legs";
}

// A damaged scene is a scene that can be rendered or an error that says where.
TEST(Scene, DamagedFilesGiveScenesOrErrors) {
  const std::string whole = to_yaml(demo_scene());
  base::Random random(27112026);
  for (int i = 0; i < 500; ++i) {
    const Result<Scene> read = parse_scene(testing::damaged(whole, random), "a.yaml");
    if (read.ok()) {
      EXPECT_TRUE(validate(*read).ok());
    } else {
      EXPECT_NE(read.error().where.find("a.yaml"), std::string::npos);
    }
  }
}

TEST(Scene, ProgramsScenesAreChecked) {
  EXPECT_TRUE(validate(demo_scene()).ok());
  EXPECT_FALSE(validate(empty_scene()).ok());
  Scene scene = demo_scene();
  scene.field.spacing_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(validate(scene).error().code, "scene_invalid");
  EXPECT_FALSE(simulate(scene, std::filesystem::temp_directory_path() / "furrow-sim-none").ok());
}

}  // namespace
}  // namespace furrow::sim
