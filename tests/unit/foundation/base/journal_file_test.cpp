// SPDX-License-Identifier: Apache-2.0
// Tests files of records. An incomplete last record is removed before another record is appended, only complete records
// remain after the disk is full, and files of an earlier format are refused with a message that names them.
#include "host/foundation/base/files/record_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

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

const std::string kBegin = "multum records 1\nkey\n";

Record record(std::size_t size, std::uint8_t value) { return Record(size, value); }

class RecordFileTest : public ::testing::Test {
 protected:
  std::unique_ptr<RecordJournal> open(bool resume, const std::string& key = "key") {
    found_.clear();
    return RecordJournal::open(output_, "rows", key, resume, [&](RecordFile::Bytes bytes, const RecordFile::Place&) {
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

TEST_F(RecordFileTest, WhatFollowsATornEndIsReadAgain) {
  const auto one = record(100, 1), two = record(50, 2), three = record(30, 3);
  stopped_after({one, two});
  const std::string whole = read_bytes(rows_);
  // Tries every length of the incomplete last record.
  for (std::size_t size = kBegin.size() + 8 + 100 + 16 + 4; size < whole.size(); size += 7) {
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

TEST_F(RecordFileTest, AnotherKeyRemovesAll) {
  stopped_after({record(10, 1)});
  write_bytes(partial_folder_of(output_) + "/level-3.lobes", "of other settings");
  const auto journal = open(true, "another key");
  EXPECT_TRUE(found_.empty());
  EXPECT_FALSE(fs::exists(partial_folder_of(output_) + "/level-3.lobes"));
  EXPECT_EQ(read_bytes(rows_), "multum records 1\nanother key\n");
}

// The reader stops after as many bytes as the key has. It does not search a whole file without line breaks for a line
// break.
TEST_F(RecordFileTest, AKeyOfAnyLengthIsReadUpToTheKeysOwn) {
  stopped_after({});
  fs::resize_file(rows_, std::uint64_t{1} << 40);  // a sparse file with a terabyte of zeros
  const auto journal = open(true);
  EXPECT_TRUE(found_.empty());
  EXPECT_EQ(read_bytes(rows_), kBegin);
}

TEST_F(RecordFileTest, ADiskThatRefusesLeavesWholeRecords) {
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

// The user decides about such files, because resuming with a later version must not lose an earlier version's records.
TEST_F(RecordFileTest, AFileOfAFormerFormatIsRefusedAndStays) {
  for (const std::string& former : {std::string("0123456789abcdef\n2 0 8 0123456789abcdef\n"),
                                    std::string("key\n\4\0\0\0"), std::string("multum records 2\nkey\n")}) {
    stopped_after({});
    write_bytes(rows_, former);
    expect_error(ErrorCode::kEnvironment, {rows_, "multum records 1", "another version", "delete it"},
                 [&] { open(true); });
    EXPECT_EQ(read_bytes(rows_), former);
    fs::remove(rows_);
    EXPECT_NE(open(true), nullptr);
  }
  stopped_after({});
  write_bytes(rows_, "0123456789abcdef\n");
  EXPECT_NE(open(false), nullptr) << "the file is not to be resumed";
}

TEST_F(RecordFileTest, ABeginningThatIsTornIsNone) {
  stopped_after({record(10, 1)});
  const std::string whole = read_bytes(rows_);
  for (const std::string& torn :
       {std::string(), whole.substr(0, 5), whole.substr(0, kBegin.size() - 1), std::string(whole.size(), '\0')}) {
    write_bytes(rows_, torn);
    const auto journal = open(true);
    EXPECT_TRUE(found_.empty());
    EXPECT_EQ(read_bytes(rows_), kBegin);
    journal->leave();
  }
}

TEST_F(RecordFileTest, OnlyAFileIsAJournal) {
  const std::string partial = partial_folder_of(output_);
  write_bytes(folder_ / "precious", "kept");
  for (const char* kind : {"pipe", "link", "folder"}) {
    WorkFolder::take(partial)->leave();
    if (kind == std::string("pipe")) ASSERT_EQ(mkfifo(rows_.c_str(), 0600), 0);
    else if (kind == std::string("link")) fs::create_symlink(folder_ / "precious", rows_);
    else fs::create_directory(rows_);
    expect_error(ErrorCode::kEnvironment, {rows_}, [&] { open(true); });
    fs::remove_all(partial);
  }
  EXPECT_EQ(read_bytes(folder_ / "precious"), "kept");
}

}  // namespace
}  // namespace multum
