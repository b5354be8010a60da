// SPDX-License-Identifier: Apache-2.0
// Tests that every function that opens a file by name immediately refuses everything except regular files, without
// waiting for a writer and without reading a device. If a reader waited, the test would not end.
#include "host/foundation/base/files/regular_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <cerrno>
#include <cstring>
#include <iterator>

#include "host/foundation/base/files/byte_file.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/exr_survey.h"
#include "host/foundation/base/files/json_file.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

struct Special {
  std::string path, kind;
};

class RegularFileTest : public ::testing::Test {
 protected:
  RegularFileTest() {
    EXPECT_EQ(::mkfifo((folder_ / "fifo").c_str(), 0600), 0);
    std::filesystem::create_symlink("fifo", folder_ / "link.png");
    std::filesystem::create_symlink("/dev/zero", folder_ / "zero.obj");
    sockaddr_un name{};
    name.sun_family = AF_UNIX;
    const std::string path = folder_ / "socket";
    std::strncpy(name.sun_path, path.c_str(), sizeof(name.sun_path) - 1);
    EXPECT_EQ(::bind(socket_.descriptor(), reinterpret_cast<const sockaddr*>(&name), sizeof(name)), 0);
    special_ = {{folder_ / "fifo", "a FIFO"}, {folder_ / "link.png", "a FIFO"},   {path, "a socket"},
                {"/dev/zero", "a device"},    {folder_ / "zero.obj", "a device"}, {"/dev/null", "a device"}};
  }

  const TemporaryFolder folder_;
  const OpenFile socket_{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  std::vector<Special> special_;
};

TEST_F(RegularFileTest, EveryReaderRefusesWhatIsNoFile) {
  for (const Special& special : special_) {
    const std::string& path = special.path;
    const std::vector<std::string> parts = {path, special.kind, "expected a regular file"};
    expect_error(ErrorCode::kInput, parts, [&] { open_regular_file(path); });
    expect_error(ErrorCode::kInput, parts, [&] { open_regular_file(path, StandardInput::kAllowed); });
    expect_error(ErrorCode::kInput, parts, [&] { open_file_beneath(folder_.path(), path); });
    expect_error(ErrorCode::kInput, parts, [&] { RegularFileStream{path}; });
    expect_error(ErrorCode::kInput, parts, [&] { first_bytes(path, 4); });
    expect_error(ErrorCode::kInput, parts, [&] { ByteFile{path}; });
    expect_error(ErrorCode::kInput, parts, [&] { hash_file(path); });
    expect_error(ErrorCode::kInput, parts, [&] { json_of_file(path); });
    expect_error(ErrorCode::kInput, parts, [&] { check_exr_headers(path, "not a readable baked file"); });
  }
}

TEST_F(RegularFileTest, FoldersAreRefusedButHaveNoBytes) {
  expect_error(ErrorCode::kInput, {folder_.path(), "is a folder"}, [&] { open_regular_file(folder_.path()); });
  EXPECT_EQ(first_bytes(folder_.path(), 4), "");
}

TEST_F(RegularFileTest, WhatIsNotThereIsNotOpen) {
  EXPECT_FALSE(open_regular_file(folder_ / "none").is_open());
  EXPECT_EQ(errno, ENOENT);
  EXPECT_FALSE(RegularFileStream(folder_ / "none"));
  EXPECT_EQ(errno, ENOENT);
  EXPECT_EQ(first_bytes(folder_ / "none", 4), "");
  EXPECT_EQ(json_of_file(folder_ / "none"), std::nullopt);
}

TEST_F(RegularFileTest, FilesAreReadAsTheyAre) {
  write_bytes(folder_ / "file", "0123456789");
  const OpenFile file = open_regular_file(folder_ / "file");
  EXPECT_EQ(::fcntl(file.descriptor(), F_GETFL) & O_NONBLOCK, 0);
  EXPECT_EQ(first_bytes(folder_ / "file", 4), "0123");
  EXPECT_EQ(first_bytes(folder_ / "file", 40), "0123456789");
  RegularFileStream stream(folder_ / "file");
  EXPECT_EQ(stream.seekg(0, std::ios::end).tellg(), 10);
  stream.seekg(4);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(stream), {}), "456789");
}

// Makes standard input the end of a pipe during its lifetime.
class PipedInput {
 public:
  explicit PipedInput(const std::string& text) : before_(::dup(STDIN_FILENO)) {
    int ends[2] = {};
    EXPECT_EQ(::pipe(ends), 0);
    const OpenFile out(ends[0]), in(ends[1]);
    EXPECT_EQ(::write(in.descriptor(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
    EXPECT_EQ(::dup2(out.descriptor(), STDIN_FILENO), STDIN_FILENO);
  }
  ~PipedInput() {
    if (before_.is_open()) ::dup2(before_.descriptor(), STDIN_FILENO);
    else ::close(STDIN_FILENO);
  }
  PipedInput(const PipedInput&) = delete;
  PipedInput& operator=(const PipedInput&) = delete;

 private:
  const OpenFile before_;
};

TEST_F(RegularFileTest, StandardInputIsReadWhereItIsAllowed) {
  const PipedInput input("{\"a\": 1}");
  expect_error(ErrorCode::kInput, {"/dev/stdin", "a FIFO"}, [] { json_of_file("/dev/stdin"); });
  EXPECT_EQ(json_of_file("/dev/stdin", StandardInput::kAllowed), "{\"a\": 1}");
}

TEST_F(RegularFileTest, LinksOutOfTheFolderAreRefused) {
  const std::string model = folder_ / "model";
  std::filesystem::create_directories(model + "/below");
  write_bytes(folder_ / "secret", "s");
  write_bytes(model + "/below/own", "o");
  std::filesystem::create_symlink("../secret", model + "/out");
  std::filesystem::create_directory_symlink("..", model + "/up");
  std::filesystem::create_symlink("below/own", model + "/in");
  std::filesystem::create_directory_symlink(model, folder_ / "other name");
  for (const char* name : {"/out", "/up/secret", "/../secret"})
    expect_error(ErrorCode::kInput, {model + name, folder_ / "secret", "not in the model's folder"},
                 [&] { open_file_beneath(model, model + name); });
  for (const char* name : {"/in", "/below/own", "/up/model/in"})
    EXPECT_TRUE(open_file_beneath(model, model + name).is_open()) << name;
  EXPECT_TRUE(open_file_beneath(folder_ / "other name", folder_ / "other name/in").is_open());
  EXPECT_FALSE(open_file_beneath(model, model + "/none").is_open());
}

}  // namespace
}  // namespace multum::testing
