#include <algorithm>
#include <map>
#include <mutex>

#include "furrow/base/file.h"
#include "furrow/base/parallel.h"
#include "furrow/target/detect.h"
#include "target/board_words.h"

namespace furrow::target {
namespace {

/// Reasons that need all files at once: copies, and sizes that differ from most.
void name_copies_and_strays(std::vector<BoardDetection>& all) {
  std::map<std::string, std::string> first_with;
  for (BoardDetection& one : all) {
    if (one.sha256.empty() || one.width == 0) continue;
    const auto [it, is_new] = first_with.emplace(one.sha256, one.image);
    if (is_new) continue;
    one.found = false;
    one.corners_px.clear();
    one.sigma_px.clear();
    one.reason = "byte-identical to " + it->second;
  }
  std::map<std::pair<int, int>, int> count;
  for (const BoardDetection& one : all) {
    if (one.width > 0) ++count[{one.width, one.height}];
  }
  if (count.size() < 2) return;
  const auto most = std::max_element(count.begin(), count.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  for (BoardDetection& one : all) {
    if (one.width == 0 || std::pair(one.width, one.height) == most->first || !one.reason.empty()) continue;
    one.found = false;
    one.corners_px.clear();
    one.sigma_px.clear();
    one.reason = "size " + size_name(one.width, one.height) + " differs from the other pictures' " +
                 size_name(most->first.first, most->first.second);
  }
}

BoardDetection read_and_detect(const std::filesystem::path& file, const BoardSpec& board,
                               const DetectOptions& options) {
  BoardDetection out;
  const auto refused = [&](const Error& error) {
    out.reason = "picture unreadable: " + error.found;
    return out;
  };
  const auto bytes = base::read_file(file);
  std::string sha;
  if (bytes.ok()) {
    sha = base::sha256_hex(*bytes);
    const auto picture = image::decode_image(*bytes, file.string());
    if (picture.ok()) {
      out = detect_board(*picture, board, options);
    } else {
      refused(picture.error());
    }
  } else {
    refused(bytes.error());
  }
  out.sha256 = sha;
  out.exif_orientation = bytes.ok() ? image::exif_orientation(*bytes) : 1;
  return out;
}

}  // namespace

std::vector<BoardDetection> detect_boards(const std::vector<std::filesystem::path>& files,
                                          const BoardSpec& board, const DetectOptions& options, int threads,
                                          const base::Progress& progress) {
  std::vector<BoardDetection> all(files.size());
  std::vector<std::string> names;
  for (const auto& file : files) names.push_back(file.filename().string());
  names = base::names_apart(std::move(names), files);
  std::mutex mutex;
  std::size_t done = 0;
  base::report(progress, "detecting boards", 0, files.size());
  base::parallel_for(files.size(), threads, [&](std::size_t i) {
    all[i] = read_and_detect(files[i], board, options);
    all[i].image = names[i];
    const std::lock_guard lock(mutex);
    base::report(progress, "detecting boards", ++done, files.size());
  });
  name_copies_and_strays(all);
  return all;
}

}  // namespace furrow::target
