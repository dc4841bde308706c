#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "furrow/base/result.h"
#include "furrow/camera/camera.h"

namespace furrow::sim {

/// The simulator's input; grows with the world it can show. The file form is scene.yaml.
struct Scene {
  std::string name = "scene";
  std::uint64_t seed = 1;
};

/// Errors: file_*, malformed_yaml, scene_invalid, unknown_key.
Result<Scene> read_scene(const std::filesystem::path& file);

}  // namespace furrow::sim
