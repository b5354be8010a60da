// SPDX-License-Identifier: Apache-2.0
// Tests that an output file must differ from all input files and other output files, whatever name is used for it.
#include "host/foundation/base/files/output_paths.h"

#include <gtest/gtest.h>

#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::expect_error;
using testing::TemporaryFolder;
using testing::write_bytes;

TEST(OutputPathsTest, OneFileUnderTwoNamesIsRefused) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.png";
  write_bytes(in, "x");
  std::filesystem::create_symlink(in, folder / "link.png");
  std::filesystem::create_directory_symlink(folder.path(), folder / "same");
  for (const std::string& name : {in, folder / "./in.png", folder / "link.png", folder / "same/in.png"})
    expect_error(ErrorCode::kUsage, {name, "is named twice"}, [&] { check_paths_differ({"", in}, {name}); });
  // Neither file exists yet.
  expect_error(ErrorCode::kUsage, {"is named twice"}, [&] {
    check_paths_differ({in}, {folder / "out.png", "", folder / "same/out.png"});
  });
}

TEST(OutputPathsTest, DifferentFilesAreTaken) {
  const TemporaryFolder folder;
  EXPECT_NO_THROW(check_paths_differ({folder / "a", folder / "a"}, {folder / "b", "", "", folder / "c"}));
}

TEST(OutputPathsTest, FindsWhatIsThereOfAFolder) {
  const TemporaryFolder folder;
  write_bytes(folder / "file", "x");
  EXPECT_EQ(existing_part(folder.path()), folder.path());
  EXPECT_EQ(existing_part(folder / "none/of/these"), folder.path());
  EXPECT_EQ(existing_part(folder / "file/inside"), folder.path());
  EXPECT_EQ(existing_part("none of these"), ".");
  EXPECT_EQ(existing_part("/none of these"), "/");
}

TEST(OutputPathsTest, WritableLeavesNothing) {
  const TemporaryFolder folder;
  EXPECT_NO_THROW(check_writable(folder / "a.png"));
  EXPECT_TRUE(folder.names().empty());
  expect_error(ErrorCode::kEnvironment, {"none/a.png"}, [&] { check_writable(folder / "none/a.png"); });
  expect_error(ErrorCode::kUsage, {"is a folder"}, [&] { check_writable(folder.path()); });
}

// A refused command removes only the empty folders that it made itself.
TEST(OutputPathsTest, NewFoldersThatStayEmptyGoAway) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "old");
  {
    const NewFolders outer;
    {
      const NewFolders inner;
      make_folder(folder / "a/b/c");
      make_folder(folder / "old/new");
      make_folder(folder / "old");
      make_folder(folder / "full/inside/empty");
      write_bytes(folder / "full/inside/file", "x");
    }
    EXPECT_TRUE(std::filesystem::exists(folder / "a/b/c")) << "the outermost decides";
  }
  EXPECT_EQ(folder.names(), (testing::Names{"old", "full"}));
  EXPECT_TRUE(std::filesystem::is_empty(folder / "old"));
  EXPECT_FALSE(std::filesystem::exists(folder / "full/inside/empty"));
  EXPECT_TRUE(std::filesystem::exists(folder / "full/inside/file"));
  make_folder(folder / "kept");  // this folder is made without a guard that removes it
  EXPECT_TRUE(std::filesystem::exists(folder / "kept"));
}

TEST(OutputPathsTest, NamesWithControlCharactersAreRefused) {
  const TemporaryFolder folder;
  for (const char* name : {"a\nb.exr", "\x1b[31m.exr", "a\x7f.exr", "tab\t.exr", "a\xc2\x9b.exr"}) {
    const std::vector<std::string> parts = {folder.path(), "control character"};
    expect_error(ErrorCode::kUsage, parts, [&] { check_writable(folder / name); });
    expect_error(ErrorCode::kUsage, parts, [&] { check_paths_differ({}, {folder / name}); });
    expect_error(ErrorCode::kUsage, parts, [&] { make_folder(folder / name); });
    expect_error(ErrorCode::kUsage, parts, [&] { make_folder(folder / name + "/below"); });
  }
  EXPECT_TRUE(folder.names().empty());
  // An existing folder belongs to the user. Bytes that are not valid UTF-8 do not count as control characters.
  std::filesystem::create_directory(folder / "a\nb");
  EXPECT_NO_THROW(check_writable(folder / "a\nb/c.exr"));
  EXPECT_NO_THROW(make_folder(folder / "a\nb/c"));
  for (const char* name : {"n\xff.exr", "\x9b.exr", "caf\xc3\xa9.exr"}) EXPECT_NO_THROW(check_writable(folder / name));
}

}  // namespace
}  // namespace multum
