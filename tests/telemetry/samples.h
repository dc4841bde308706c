#pragma once
#include <cstdlib>
#include <filesystem>
#include <string>

/// Where the real data lies that never enters the project: $FURROW_DATA, else ../shared/data beside the
/// project.
inline std::filesystem::path furrow_data(const std::string& relative) {
  const char* folder = std::getenv("FURROW_DATA");
  const std::filesystem::path root =
      folder != nullptr && *folder != '\0' ? folder : FURROW_SOURCE_DIR "/../shared/data";
  return root / relative;
}

/// Skips the test with a clear line when a file of the data folder is absent.
#define FURROW_NEEDS_DATA(file) \
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << (file).string() << ": set FURROW_DATA"
