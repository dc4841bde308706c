#include "furrow/sim/simulate.h"

#include <gtest/gtest.h>

#include <map>

#include "furrow/base/csv.h"
#include "furrow/base/file.h"
#include "furrow/base/text.h"
#include "furrow/camera/model_files.h"
#include "furrow/sim/world.h"

namespace furrow::sim {
namespace {

namespace fs = std::filesystem;

/// A quarter of the demo's size, two shots, two boards.
Scene small_scene() {
  Scene scene = demo_scene();
  scene.camera = camera::resize_camera(scene.camera, 320, 180);
  scene.camera.provenance = "simulated truth";
  scene.boards.count = 2;
  scene.flight.legs.resize(1);
  scene.flight.legs[0].shots = 2;
  return scene;
}

std::map<std::string, std::string> files_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      files[fs::relative(entry.path(), folder).string()] = base::read_file(entry.path()).value();
    }
  }
  return files;
}

class Folder {
 public:
  explicit Folder(const std::string& name) : path_(fs::path(testing::TempDir()) / ("furrow-" + name)) {
    fs::remove_all(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

TEST(Simulate, SameBytesForAnyNumberOfThreads) {
  const Folder one("sim-one"), two("sim-two");
  std::size_t reports = 0;
  const auto progress = [&](const base::ProgressEvent& event) { reports += event.total == 4; };
  ASSERT_TRUE(simulate(small_scene(), one.path(), progress, {1}).ok());
  ASSERT_TRUE(simulate(small_scene(), two.path(), {}, {2}).ok());
  EXPECT_EQ(reports, 4U);
  const auto a = files_of(one.path()), b = files_of(two.path());
  ASSERT_EQ(a.size(), b.size());
  for (const auto& [name, bytes] : a) EXPECT_TRUE(b.at(name) == bytes) << name;
}

TEST(Simulate, AnotherSeedIsAnotherWorld) {
  Scene scene = small_scene();
  const Image first = Renderer(scene).shot(0);
  EXPECT_EQ(Renderer(scene).shot(0).data, first.data);
  scene.seed += 1;
  EXPECT_NE(Renderer(scene).shot(0).data, first.data);
}

TEST(Simulate, FolderHoldsWhatRunNeeds) {
  const Folder folder("sim-folder");
  const Result<Simulated> made = simulate(small_scene(), folder.path());
  ASSERT_TRUE(made.ok()) << made.error().message();
  EXPECT_EQ(made->boards, 2);
  EXPECT_EQ(made->shots, 2);
  for (const char* name :
       {"boards/board-01.png", "boards/board-02.png", "frames/shot-0001.jpg", "frames/shot-0002.jpg",
        "airdata.csv", "truth.csv", "project.yaml", "board.yaml", "scene.yaml", "boards_truth.csv"}) {
    EXPECT_TRUE(fs::is_regular_file(folder.path() / name)) << name;
  }
  const Result<Camera> camera = camera::read_camera(folder.path() / "camera_true.yaml");
  ASSERT_TRUE(camera.ok()) << camera.error().message();
  EXPECT_EQ(camera->fx, small_scene().camera.fx);
  EXPECT_EQ(camera->distortion, small_scene().camera.distortion);
  const Result<Scene> again = read_scene(folder.path() / "scene.yaml");
  ASSERT_TRUE(again.ok()) << again.error().message();
  EXPECT_EQ(to_yaml(*again), to_yaml(small_scene()));
}

TEST(Simulate, TruthTableIsTheTruth) {
  const Folder folder("sim-truth");
  ASSERT_TRUE(simulate(small_scene(), folder.path()).ok());
  const Result<base::CsvTable> table = base::read_csv(folder.path() / "truth.csv");
  ASSERT_TRUE(table.ok());
  const auto shots = true_shots(small_scene());
  ASSERT_EQ(table->rows.size(), shots.size());
  const auto cell = [&](std::size_t row, const char* name) {
    return base::parse_double(table->rows[row][table->column(name).value()]).value();
  };
  for (std::size_t i = 0; i < shots.size(); ++i) {
    EXPECT_NEAR(cell(i, "height_above_canopy_m"), shots[i].height_above_canopy_m, 1e-5);
    EXPECT_NEAR(cell(i, "height_above_ground_m") - cell(i, "height_above_canopy_m"), 1.7, 2e-5);
    EXPECT_NEAR(cell(i, "cross_track_m"), shots[i].cross_track_m, 1e-5);
    EXPECT_NEAR(cell(i, "east_m"), shots[i].x_in_world.x(), 1e-5);
  }
}

TEST(Simulate, UnwritableFolderIsAnError) {
  const Folder folder("sim-file");
  ASSERT_TRUE(base::write_file(folder.path(), "a file, not a folder").ok());
  const Result<Simulated> made = simulate(small_scene(), folder.path() / "below");
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().code, "file_unwritable");
}

}  // namespace
}  // namespace furrow::sim
