// SPDX-License-Identifier: Apache-2.0
#include "host/formats/decoder/libraries/model_files.h"

#include <sys/stat.h>
#include <sys/types.h>

#include <cstdio>
#include <filesystem>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/regular_file.h"

namespace multum {
namespace {

// Reads the size from the open file. assimp's own stream would look up the file name again.
class ModelStream : public Assimp::IOStream {
 public:
  explicit ModelStream(std::FILE* file) : file_(file) {}
  ~ModelStream() override { std::fclose(file_); }
  ModelStream(const ModelStream&) = delete;
  ModelStream& operator=(const ModelStream&) = delete;

  std::size_t Read(void* buffer, std::size_t size, std::size_t count) override {
    return size == 0 || count == 0 ? 0 : std::fread(buffer, size, count, file_);
  }
  std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
  aiReturn Seek(std::size_t offset, aiOrigin origin) override {
    const int from = origin == aiOrigin_SET ? SEEK_SET : origin == aiOrigin_CUR ? SEEK_CUR : SEEK_END;
    return fseeko(file_, static_cast<off_t>(offset), from) == 0 ? aiReturn_SUCCESS : aiReturn_FAILURE;
  }
  std::size_t Tell() const override { return static_cast<std::size_t>(ftello(file_)); }
  std::size_t FileSize() const override {
    struct stat found {};
    return ::fstat(fileno(file_), &found) == 0 ? static_cast<std::size_t>(found.st_size) : 0;
  }
  void Flush() override {}

 private:
  std::FILE* const file_;
};

}  // namespace

ModelFiles::ModelFiles(std::string model)
    : model_(std::move(model)), folder_(std::filesystem::path(model_).parent_path().string()) {}

bool ModelFiles::Exists(const char* name) const {
  try {
    return (name == model_ ? open_regular_file(name) : open_file_beneath(folder_, name)).is_open();
  } catch (const Error&) {
    return false;
  }
}

Assimp::IOStream* ModelFiles::Open(const char* name, const char* mode) {
  if (*mode != 'r') return nullptr;
  try {
    OpenFile file = name == model_ ? open_regular_file(name) : open_file_beneath(folder_, name);
    std::FILE* const stream = file.is_open() ? ::fdopen(file.descriptor(), "rb") : nullptr;
    if (stream == nullptr) return nullptr;
    file.release();
    return new ModelStream(stream);
  } catch (const Error&) {
    return nullptr;
  }
}

void ModelFiles::Close(Assimp::IOStream* stream) { delete stream; }

}  // namespace multum
