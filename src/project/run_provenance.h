#pragma once
#include <optional>
#include <string>
#include <vector>

#include "furrow/base/value.h"
#include "furrow/sync/locate.h"
#include "furrow/telemetry/track.h"
#include "project/shot_chain.h"

namespace furrow::project {

/// Where the camera is from, and how it was carried to the shots' sizes; sentences.
std::vector<std::string> camera_words(const Camera& camera, const std::vector<ShotResult>& results);

/// Which log, how the shots were found in it, and what was odd; sentences.
std::vector<std::string> log_words(const Project& project, const std::optional<telemetry::Track>& track,
                                   const sync::Located& located, const std::vector<telemetry::Shot>& shots);

/// What the project asked for, for the manifest.
base::Value options_value(const Project& project);

/// Hashes of all files that the project names.
base::Value inputs_value(const Project& project);

}  // namespace furrow::project
