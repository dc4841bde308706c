#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "furrow/base/result.h"
#include "furrow/base/value.h"

namespace furrow::project {

/// Name (last part) and SHA-256 of each input, in the given order; a missing one has a null hash.
base::Value hash_inputs(const std::vector<std::filesystem::path>& files);

/// Name (relative to `folder`) and SHA-256 of each output.
base::Value hash_outputs(const std::filesystem::path& folder, const std::vector<std::string>& files);

/// Writes manifest.json: which program, which inputs, which options, which outputs. The same run writes the
/// same bytes.
Status write_manifest(const std::filesystem::path& out, const std::string& command, base::Value options,
                      base::Value inputs, const std::vector<std::string>& outputs);

}  // namespace furrow::project
