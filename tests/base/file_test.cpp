#include "furrow/base/file.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "furrow/base/folder.h"

namespace furrow::base {
namespace {

namespace fs = std::filesystem;

struct Folder {
  Folder()
      : path(fs::temp_directory_path() /
             ("furrow_file_test_" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()))) {
    fs::remove_all(path);
    fs::create_directories(path);
  }
  ~Folder() { fs::remove_all(path); }
  fs::path path;
};

TEST(File, WritesWholeFilesOrNone) {
  const Folder folder;
  const fs::path file = folder.path / "sub" / "a.txt";
  ASSERT_TRUE(write_file(file, "hello").ok());
  EXPECT_EQ(*read_file(file), "hello");
  EXPECT_FALSE(write_file_with(file, [](const fs::path& part) {
                 return write_file(part, "half").ok() && false;
               }).ok());
  EXPECT_EQ(*read_file(file), "hello");
  EXPECT_EQ(std::distance(fs::directory_iterator(file.parent_path()), fs::directory_iterator()), 1)
      << "a part file was left behind";
}

TEST(File, SaysWhatIsWrong) {
  const Folder folder;
  EXPECT_EQ(read_file(folder.path / "none").error().code, "file_missing");
  EXPECT_EQ(read_file(folder.path).error().code, "file_unreadable");
  ASSERT_TRUE(write_file(folder.path / "big", std::string(100, 'x')).ok());
  EXPECT_EQ(read_file(folder.path / "big", 10).error().code, "file_too_large");
  EXPECT_EQ(write_file(folder.path / "big" / "x", "1").error().code, "file_unwritable");
}

TEST(File, SaysBeforehandWhetherAFolderCanHoldResults) {
  const Folder folder;
  ASSERT_TRUE(write_file(folder.path / "notes", "x").ok());
  EXPECT_TRUE(can_hold_results(folder.path).ok());
  EXPECT_TRUE(can_hold_results(folder.path / "new" / "one").ok());
  EXPECT_TRUE(can_hold_results("").ok()) << "the current folder";
  EXPECT_FALSE(fs::exists(folder.path / "new")) << "asked, not made";
  for (const fs::path& wrong : {folder.path / "notes", folder.path / "notes" / "a" / "b"}) {
    const Status status = can_hold_results(wrong);
    ASSERT_FALSE(status.ok()) << wrong;
    EXPECT_EQ(status.error().code, "file_unwritable");
    EXPECT_NE(status.error().message().find("notes' is no folder"), std::string::npos);
  }
}

TEST(File, ExpandsPatternsInNaturalOrder) {
  const Folder folder;
  for (const char* name : {"a10.jpg", "a2.jpg", "b.png", ".hidden.jpg"})
    ASSERT_TRUE(write_file(folder.path / name, "").ok());
  const auto files = expand_pattern("*.jpg", folder.path);
  ASSERT_TRUE(files.ok());
  ASSERT_EQ(files->size(), 2U);
  EXPECT_EQ((*files)[0].filename(), "a2.jpg");
  EXPECT_EQ(expand_pattern("*.tif", folder.path).error().code, "no_match");
  EXPECT_EQ(expand_pattern("nowhere/*.jpg", folder.path).error().code, "no_match");
}

TEST(File, ExpandsTheEnvironment) {
  ::setenv("FURROW_TEST_VARIABLE", "x y", 1);
  EXPECT_EQ(*expand_environment("a/${FURROW_TEST_VARIABLE}/b"), "a/x y/b");
  EXPECT_EQ(expand_environment("${FURROW_TEST_NOT_SET}").error().code, "variable_unset");
  EXPECT_EQ(*expand_environment("a/${unfinished"), "a/${unfinished");
}

TEST(File, HashesAndEncodes) {
  // FIPS 180-2, appendix B.1; RFC 4648, section 10.
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64(""), "");
}

}  // namespace
}  // namespace furrow::base
