#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "furrow/base/result.h"

namespace furrow::base {

/// The whole file. Errors: file_missing, file_unreadable (a directory, no permission), file_too_large (over
/// `limit_bytes`).
Result<std::string> read_file(const std::filesystem::path& file,
                              std::size_t limit_bytes = std::size_t{1} << 30);

/// Writes under a temporary name beside `file`, then renames: a killed run leaves the old file or the new
/// one, never half. Makes the folder when it is missing. Errors: file_unwritable (folder, permission, disk
/// full).
Status write_file(const std::filesystem::path& file, std::string_view bytes);

/// The same for a writer that needs a path (an image or video library): `write` gets the temporary path, with
/// `file`'s extension, and returns whether it went well.
Status write_file_with(const std::filesystem::path& file,
                       const std::function<bool(const std::filesystem::path&)>& write);

/// A file that grows over a long run: everything goes to a temporary name beside it, with the same extension,
/// until commit() renames it. One that is destroyed before leaves nothing; a killed run leaves the old file
/// or none.
class PartFile {
 public:
  /// Makes the folder when it is missing. Errors: file_unwritable.
  static Result<PartFile> create(const std::filesystem::path& file);
  PartFile(PartFile&& other) noexcept;
  PartFile& operator=(PartFile&& other) noexcept;
  ~PartFile();

  /// Where to write until commit().
  const std::filesystem::path& temporary() const { return temporary_; }
  /// Errors: file_unwritable.
  Status commit();

 private:
  PartFile(std::filesystem::path file, std::filesystem::path temporary);
  std::filesystem::path file_, temporary_;  ///< both empty once committed or moved from
};

/// Files that match `pattern` ('*' and '?' in the last part only), in natural order; relative patterns start
/// at `base`. A pattern without wildcards is returned as it is, existing or not. Errors: no_match (names the
/// pattern and the folder).
Result<std::vector<std::filesystem::path>> expand_pattern(const std::string& pattern,
                                                          const std::filesystem::path& base);

/// Names of files as results show them: `names`, with the folder's name in front of every one that occurs
/// twice
/// ("left/DJI_0001"), and, should that not be enough, a number behind ("left/DJI_0001#2").
std::vector<std::string> names_apart(std::vector<std::string> names,
                                     const std::vector<std::filesystem::path>& files);

/// `text` with ${NAME} replaced by environment variables. Errors: variable_unset.
Result<std::string> expand_environment(const std::string& text);

/// SHA-256 in lower-case hex.
std::string sha256_hex(std::string_view bytes);

/// RFC 4648 base64, for data URIs.
std::string base64(std::string_view bytes);

}  // namespace furrow::base
