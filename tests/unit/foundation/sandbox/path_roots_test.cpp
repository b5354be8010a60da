// SPDX-License-Identifier: Apache-2.0
// Tests names of files below the root folders, and opening files by these names after the folders have changed.
#include "host/foundation/sandbox/path_roots.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using testing::TemporaryFolder;

class PathRootsTest : public ::testing::Test {
 protected:
  PathRootsTest() {
    fs::create_directories(root_ + "/sub");
    fs::create_directories(outside_);
    write_text_file(root_ + "/sub/map.png", "inside");
    write_text_file(outside_ + "/map.png", "secret");
  }
  template <typename Call>
  void refused(ErrorCode code, const Call& call) const {
    try {
      call();
      ADD_FAILURE() << "not refused";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
    }
  }

  TemporaryFolder folder_;
  const std::string base_ = fs::canonical(folder_ / "").string(), root_ = base_ + "/root",
                    outside_ = base_ + "/outside";
  const std::string file_ = root_ + "/sub/map.png";
};

TEST_F(PathRootsTest, OpensWhatItNamed) {
  const PathRoots roots({root_});
  fs::create_symlink(file_, root_ + "/link.png");
  EXPECT_EQ(roots.input(root_ + "/link.png"), file_);
  const OpenFile file = roots.open_input(file_);
  char text[7] = {};
  EXPECT_EQ(::read(file.descriptor(), text, 6), 6);
  EXPECT_STREQ(text, "inside");
  EXPECT_TRUE(roots.open_folder_of(file_).is_open());
}

TEST_F(PathRootsTest, WhatHasBecomeALinkIsNotOpened) {
  const PathRoots roots({root_});
  for (const std::string& path : {root_ + "/sub", file_}) {
    SCOPED_TRACE(path);
    fs::rename(path, path + ".real");
    fs::create_symlink(path == file_ ? outside_ + "/map.png" : outside_, path);
    refused(ErrorCode::kUsage, [&] { roots.open_input(file_); });
    if (path != file_) refused(ErrorCode::kUsage, [&] { roots.open_folder_of(file_); });
    // A link to the right place is also refused, because the name was resolved when it was checked.
    fs::remove(path);
    fs::create_symlink(path + ".real", path);
    refused(ErrorCode::kUsage, [&] { roots.open_input(file_); });
    fs::remove(path);
    fs::rename(path + ".real", path);
    EXPECT_TRUE(roots.open_input(file_).is_open());
  }
}

TEST_F(PathRootsTest, WhatIsNoFileIsNotWaitedFor) {
  const PathRoots roots({root_});
  fs::remove(file_);
  refused(ErrorCode::kUsage, [&] { roots.open_input(file_); });
  ASSERT_EQ(::mkfifo(file_.c_str(), 0600), 0);
  refused(ErrorCode::kUsage, [&] { roots.open_input(file_); });
  refused(ErrorCode::kUsage, [&] { roots.open_input(root_ + "/sub"); });
  refused(ErrorCode::kUsage, [&] { roots.open_input(outside_ + "/map.png"); });
  refused(ErrorCode::kUsage, [&] { roots.open_input(root_ + "/../outside/map.png"); });
}

// No message reveals whether something exists outside the roots: through a path, a link, or a folder that is a link.
TEST_F(PathRootsTest, NothingIsToldOfWhatIsOutside) {
  const PathRoots roots({root_});
  const auto message = [&](const std::string& path, bool is_output) {
    try {
      is_output ? roots.output(path) : roots.input(path);
    } catch (const Error& error) {
      const std::string text = error.what();
      EXPECT_TRUE(text.starts_with(path + ": ")) << text;
      return text.substr(path.size());
    }
    return std::string("not refused");
  };
  std::string words[2];
  for (const char* name : {"map.png", "nothing.png"}) {
    const std::string target = outside_ + "/" + name, link = root_ + "/link";
    fs::create_symlink(target, link);
    fs::create_symlink("../outside/" + std::string(name), root_ + "/relative");
    fs::create_symlink("link", root_ + "/twice");
    fs::create_directory_symlink(outside_, root_ + "/door");
    for (const std::string& path : {target, link, root_ + "/relative", root_ + "/twice", root_ + "/door/" + name,
                                    root_ + "/sub/../door/" + name, root_ + "/../outside/" + name}) {
      const std::string found = message(path, false);
      EXPECT_NE(found.find("not below a folder"), std::string::npos) << path << found;
      if (words[0].empty()) words[0] = found;
      EXPECT_EQ(found, words[0]) << path;
    }
    for (const std::string& path : {target + "/a", root_ + "/door/" + name + "/a", link + "/a"}) {
      const std::string found = message(path, true);
      EXPECT_NE(found.find("not below a folder"), std::string::npos) << path << found;
    }
    for (const char* made : {"link", "relative", "twice", "door"}) fs::remove(root_ + "/" + made);
  }
  // Messages name files inside the roots.
  fs::create_symlink(root_ + "/sub/nothing.png", root_ + "/link");
  EXPECT_NE(message(root_ + "/link", false).find("no such file"), std::string::npos);
}

// The usual cause is that the root was unmounted, which leaves an empty folder.
TEST_F(PathRootsTest, ARootThatIsAnotherFolderIsNotUsed) {
  const PathRoots roots({root_});
  fs::rename(root_, root_ + ".old");
  refused(ErrorCode::kEnvironment, [&] { roots.open_input(file_); });
  fs::create_directories(root_ + "/sub");
  write_text_file(file_, "another");
  refused(ErrorCode::kEnvironment, [&] { roots.open_input(file_); });
  refused(ErrorCode::kEnvironment, [&] { roots.open_folder_of(file_); });
}

// A disk is mounted within another root. Once it is unmounted, the folder at its mount point holds none of its files.
TEST_F(PathRootsTest, ARootWithinARootIsTheOneThatCounts) {
  const PathRoots outer_first({base_, root_}), inner_first({root_, base_});
  EXPECT_TRUE(inner_first.open_input(outside_ + "/map.png").is_open());
  fs::rename(root_, root_ + ".old");
  fs::create_directories(root_ + "/sub");
  write_text_file(file_, "another");
  for (const PathRoots* roots : {&outer_first, &inner_first})
    refused(ErrorCode::kEnvironment, [&] { roots->open_input(file_); });
}

TEST_F(PathRootsTest, NamesOfResults) {
  const PathRoots roots({root_});
  EXPECT_EQ(roots.output(root_ + "/sub/../sub/a.ndf.exr"), root_ + "/sub/a.ndf.exr");
  for (const std::string& wrong :
       {root_ + "/sub/..", root_ + "/sub/.multum-1-2", root_ + "/nowhere/a.exr", file_ + "/a.exr", outside_ + "/a.exr",
        root_ + "/" + std::string(201, 'a'), std::string("a.exr")})
    refused(ErrorCode::kUsage, [&] { roots.output(wrong); });
  roots.output(root_ + "/" + std::string(200, 'a'));
}

TEST_F(PathRootsTest, ARootMustBeAFolder) {
  refused(ErrorCode::kUsage, [&] { PathRoots({file_}); });
  refused(ErrorCode::kUsage, [&] { PathRoots({base_ + "/none"}); });
}

}  // namespace
}  // namespace multum
