#include "project/manifest.h"

#include "furrow/base/file.h"
#include "furrow/base/version.h"

namespace furrow::project {
namespace {

base::Value entry(const std::string& name, const std::filesystem::path& file) {
  base::Value value;
  value.set("file", name);
  const auto bytes = base::read_file(file);
  value.set("sha256", bytes.ok() ? base::Value(base::sha256_hex(*bytes)) : base::Value());
  return value;
}

}  // namespace

base::Value hash_inputs(const std::vector<std::filesystem::path>& files) {
  base::Array entries;
  for (const auto& file : files) entries.push_back(entry(file.filename().string(), file));
  return entries;
}

base::Value hash_outputs(const std::filesystem::path& folder, const std::vector<std::string>& files) {
  base::Array entries;
  for (const std::string& file : files) entries.push_back(entry(file, folder / file));
  return entries;
}

Status write_manifest(const std::filesystem::path& out, const std::string& command, base::Value options,
                      base::Value inputs, const std::vector<std::string>& outputs) {
  base::Value manifest;
  manifest.set("program", "furrow");
  manifest.set("version", base::version());
  manifest.set("command", command);
  manifest.set("options", std::move(options));
  manifest.set("inputs", std::move(inputs));
  manifest.set("outputs", hash_outputs(out, outputs));
  return base::write_file(out / "manifest.json", base::to_json(manifest) + "\n");
}

}  // namespace furrow::project
