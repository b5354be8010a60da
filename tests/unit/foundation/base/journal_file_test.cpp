// SPDX-License-Identifier: Apache-2.0
// Journals of stopped work: a torn end is cut before anything is appended, and a disk that refuses leaves whole
// records.
#include "host/foundation/base/files/journal_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "host/foundation/base/files/record_journal.h"
#include "tests/unit/foundation/base/file_limit.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using testing::expect_error;
using testing::read_bytes;
using testing::TemporaryFolder;
using testing::write_bytes;

using Record = std::vector<std::uint8_t>;

Record record(std::size_t size, std::uint8_t value) { return Record(size, value); }

class JournalFileTest : public ::testing::Test {
 protected:
  std::unique_ptr<RecordJournal> open(bool resume, const std::string& key = "key") {
    found_.clear();
    return RecordJournal::open(output_, "rows", key, resume, [&](std::span<const std::uint8_t> bytes, std::uint64_t) {
      found_.push_back({bytes.begin(), bytes.end()});
      return true;
    });
  }
  void stopped_after(const std::vector<Record>& records) {
    const auto journal = open(false);
    for (const auto& one : records) journal->add({one});
    journal->leave();
  }

  TemporaryFolder folder_;
  const std::string output_ = folder_ / "map.exr", rows_ = partial_folder_of(output_) + "/rows";
  std::vector<Record> found_;
};

TEST_F(JournalFileTest, WhatFollowsATornEndIsReadAgain) {
  const auto one = record(100, 1), two = record(50, 2), three = record(30, 3);
  stopped_after({one, two});
  const std::string whole = read_bytes(rows_);
  // However much of the last record is there.
  for (std::size_t size = 4 + 100 + 16 + 4; size < whole.size(); size += 7) {
    write_bytes(rows_, whole.substr(0, size));
    {
      const auto journal = open(true);
      ASSERT_EQ(found_, std::vector<Record>{one}) << size;
      journal->add({three});
      journal->leave();
    }
    {
      const auto journal = open(true);
      EXPECT_EQ(found_, (std::vector<Record>{one, three})) << size;
      journal->leave();
    }
  }
}

TEST_F(JournalFileTest, AnotherKeyRemovesAll) {
  stopped_after({record(10, 1)});
  write_bytes(partial_folder_of(output_) + "/level-3.lobes", "of other settings");
  const auto journal = open(true, "another key");
  EXPECT_TRUE(found_.empty());
  EXPECT_FALSE(fs::exists(partial_folder_of(output_) + "/level-3.lobes"));
  EXPECT_EQ(read_bytes(rows_), "another key\n");
}

// A file without a line's end is not read in search of one.
TEST_F(JournalFileTest, AKeyOfAnyLengthIsReadUpToTheKeysOwn) {
  stopped_after({});
  fs::resize_file(rows_, std::uint64_t{1} << 40);  // sparse: a terabyte of zeros
  const auto journal = open(true);
  EXPECT_TRUE(found_.empty());
  EXPECT_EQ(read_bytes(rows_), "key\n");
}

TEST_F(JournalFileTest, ADiskThatRefusesLeavesWholeRecords) {
  const auto one = record(1000, 1);
  const auto journal = open(false);
  journal->add({one});
  const std::string before = read_bytes(rows_);
  {
    const testing::FileLimit low(before.size() + 500);
    expect_error(ErrorCode::kEnvironment, {rows_, "cannot be written", "File too large"}, [&] { journal->add({one}); });
  }
  EXPECT_EQ(read_bytes(rows_), before);
  journal->add({one});
  journal->leave();
}

TEST_F(JournalFileTest, OnlyAFileIsAJournal) {
  const auto work = WorkFolder::take(folder_ / "work");
  ASSERT_EQ(mkfifo((folder_ / "work/pipe").c_str(), 0600), 0);
  write_bytes(folder_ / "precious", "kept");
  fs::create_symlink(folder_ / "precious", folder_ / "work/link");
  fs::create_directory(folder_ / "work/folder");
  for (const char* name : {"pipe", "link", "folder"})
    expect_error(ErrorCode::kEnvironment, {folder_ / "work/" + name}, [&] { JournalFile(*work, name); });
  EXPECT_EQ(read_bytes(folder_ / "precious"), "kept");
}

}  // namespace
}  // namespace multum
