#include "furrow/base/file.h"

#include <fcntl.h>
#include <openssl/evp.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <utility>

#include "furrow/base/folder.h"
#include "furrow/base/text.h"

namespace furrow::base {
namespace {

namespace fs = std::filesystem;

std::string system_reason(int code) {
  return std::strerror(code);
}

Error unwritable(const fs::path& file, const std::string& reason) {
  return {"file_unwritable", file.string(), "cannot be written: " + reason, "", ""};
}

/// A name beside `file` that no other process uses, with the same extension (picture writers choose the
/// format by it).
fs::path temporary_beside(const fs::path& file) {
  return file.parent_path() /
         ("." + file.stem().string() + ".part" + std::to_string(::getpid()) + file.extension().string());
}

bool matches(std::string_view pattern, std::string_view text) {
  std::size_t p = 0;
  std::size_t t = 0;
  std::size_t star = std::string_view::npos;
  std::size_t star_text = 0;
  while (t < text.size()) {
    if (p < pattern.size() && (pattern[p] == '?' || (pattern[p] == text[t] && pattern[p] != '*'))) {
      ++p;
      ++t;
    } else if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      star_text = t;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      t = ++star_text;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

bool write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return false;
    }
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

Result<std::string> read_file(const fs::path& file, std::size_t limit_bytes) {
  std::error_code code;
  const auto status = fs::status(file, code);
  if (!fs::exists(status)) return Error{"file_missing", file.string(), "there is no such file", "", ""};
  if (fs::is_directory(status))
    return Error{"file_unreadable", file.string(), "this is a folder", "a file", ""};
  if (!fs::is_regular_file(status)) {  // a pipe could make the reader wait for ever
    return Error{"file_unreadable", file.string(), "this is no regular file", "a file", ""};
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    return Error{"file_unreadable", file.string(), "cannot be opened: " + system_reason(errno), "", ""};
  std::string bytes;
  std::array<char, 1 << 16> block{};
  while (stream.read(block.data(), block.size()) || stream.gcount() > 0) {
    bytes.append(block.data(), static_cast<std::size_t>(stream.gcount()));
    if (bytes.size() > limit_bytes) {
      return Error{"file_too_large", file.string(), "larger than " + std::to_string(limit_bytes) + " bytes",
                   "", ""};
    }
  }
  if (stream.bad())
    return Error{"file_unreadable", file.string(), "reading stopped: " + system_reason(errno), "", ""};
  return bytes;
}

Result<PartFile> PartFile::create(const fs::path& file) {
  std::error_code code;
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), code);
  if (code) return unwritable(file, "its folder cannot be made: " + code.message());
  return PartFile(file, temporary_beside(file));
}

PartFile::PartFile(fs::path file, fs::path temporary)
    : file_(std::move(file)), temporary_(std::move(temporary)) {}

PartFile::PartFile(PartFile&& other) noexcept
    : file_(std::exchange(other.file_, {})), temporary_(std::exchange(other.temporary_, {})) {}

PartFile& PartFile::operator=(PartFile&& other) noexcept {
  std::swap(file_, other.file_);
  std::swap(temporary_, other.temporary_);
  return *this;
}

PartFile::~PartFile() {
  std::error_code code;
  if (!temporary_.empty()) fs::remove(temporary_, code);
}

Status PartFile::commit() {
  std::error_code code;
  fs::rename(temporary_, file_, code);
  if (code) return unwritable(file_, code.message());
  temporary_.clear();
  return Done{};
}

Status can_hold_results(const fs::path& folder) {
  std::error_code unknown;
  fs::path there = fs::absolute(folder.empty() ? "." : folder, unknown).lexically_normal();
  while (!fs::exists(there, unknown) && there.has_relative_path()) there = there.parent_path();
  if (!fs::is_directory(there, unknown)) {
    return Error{"file_unwritable", folder.string(), "'" + there.string() + "' is no folder",
                 "a folder for the results, new or old", ""};
  }
  if (::access(there.c_str(), W_OK | X_OK) != 0)
    return unwritable(folder, "'" + there.string() + "': " + system_reason(errno));
  return Done{};
}

Status write_file_with(const fs::path& file, const std::function<bool(const fs::path&)>& write) {
  FURROW_TRY(PartFile part, PartFile::create(file));
  errno = 0;
  const bool written = write(part.temporary());
  const int reason = errno;
  if (!written) return unwritable(file, reason != 0 ? system_reason(reason) : "the writer failed");
  return part.commit();
}

Status write_file(const fs::path& file, std::string_view bytes) {
  return write_file_with(file, [bytes](const fs::path& temporary) {
    const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (descriptor < 0) return false;
    const bool written = write_all(descriptor, bytes);
    const int reason = errno;
    const bool closed = ::close(descriptor) == 0;
    if (!written) errno = reason;
    return written && closed;
  });
}

Result<std::vector<fs::path>> expand_pattern(const std::string& pattern, const fs::path& base) {
  const fs::path whole = fs::path(pattern).is_absolute() ? fs::path(pattern) : base / pattern;
  const std::string last = whole.filename().string();
  if (last.find_first_of("*?") == std::string::npos) return std::vector<fs::path>{whole};
  std::vector<fs::path> files;
  std::error_code code;
  const fs::path folder = whole.parent_path().empty() ? fs::path(".") : whole.parent_path();
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
    const std::string name = entry->path().filename().string();
    std::error_code unknown;  // a link that leads round in a circle is no folder, and for its reader to name
    if (name.front() != '.' && matches(last, name) && !entry->is_directory(unknown))
      files.push_back(entry->path());
  }
  if (code)
    return Error{"no_match", folder.string(),
                 "the folder of '" + pattern + "' cannot be read: " + code.message(), "", ""};
  if (files.empty())
    return Error{"no_match", folder.string(), "no file matches '" + last + "'", "at least one", ""};
  std::sort(files.begin(), files.end(),
            [](const fs::path& a, const fs::path& b) { return natural_less(a.string(), b.string()); });
  return files;
}

std::vector<std::string> names_apart(std::vector<std::string> names, const std::vector<fs::path>& files) {
  check(names.size() == files.size(), "names_apart: a name a file");
  const auto count = [&names] {
    std::map<std::string, int> out;
    for (const std::string& name : names) ++out[name];
    return out;
  };
  const auto short_ones = count();
  for (std::size_t i = 0; i < names.size(); ++i) {
    // "../a.jpg" names its folder too.
    if (short_ones.at(names[i]) > 1)
      names[i] = fs::absolute(files[i]).lexically_normal().parent_path().filename().string() + "/" + names[i];
  }
  const auto longer = count();
  std::map<std::string, int> seen;
  for (std::string& name : names) {
    if (const std::string whole = name; longer.at(whole) > 1) name += "#" + std::to_string(++seen[whole]);
  }
  return names;
}

Result<std::string> expand_environment(const std::string& text) {
  std::string result;
  std::size_t at = 0;
  while (at < text.size()) {
    const auto start = text.find("${", at);
    const auto end = start == std::string::npos ? start : text.find('}', start);
    if (end == std::string::npos) break;
    result += text.substr(at, start - at);
    const std::string name = text.substr(start + 2, end - start - 2);
    const char* value = std::getenv(name.c_str());
    if (value == nullptr) {
      return Error{"variable_unset", "", "environment variable " + name + " is not set", "",
                   "It stands in '" + text + "'."};
    }
    result += value;
    at = end + 1;
  }
  return result + text.substr(at);
}

std::string sha256_hex(std::string_view bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  check(EVP_Digest(bytes.data(), bytes.size(), digest.data(), &length, EVP_sha256(), nullptr) == 1,
        "SHA-256 is not available");
  static constexpr char kHex[] = "0123456789abcdef";
  std::string text;
  for (unsigned int i = 0; i < length; ++i) {
    text += kHex[digest[i] >> 4U];
    text += kHex[digest[i] & 15U];
  }
  return text;
}

std::string base64(std::string_view bytes) {
  std::string text((bytes.size() + 2) / 3 * 4 + 1, '\0');
  const int length =
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                      reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(length));
  return text;
}

}  // namespace furrow::base
