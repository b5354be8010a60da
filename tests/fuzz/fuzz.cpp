// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/fuzz.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace multum::fuzz {
namespace {

namespace fs = std::filesystem;

class ScratchFolder {
 public:
  ScratchFolder() {
    const fs::path place = fs::is_directory("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path();
    path_ = (place / "multum_fuzz_XXXXXX").string();
    if (mkdtemp(path_.data()) == nullptr) std::abort();
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

void write(const std::string& path, std::string_view bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

const std::string& scratch_folder() {
  static const ScratchFolder folder;
  return folder.path();
}

std::string input_file(const char* name, std::string_view bytes) {
  std::string path = scratch_folder() + "/" + name;
  write(path, bytes);
  return path;
}

std::string file_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

Input split(const std::uint8_t* data, std::size_t size, unsigned count) {
  if (size == 0) return {0, {}};
  return {data[0] % count, {reinterpret_cast<const char*>(data) + 1, size - 1}};
}

}  // namespace multum::fuzz

// libFuzzer calls this function. For tools/fuzz, `--seeds=FOLDER` writes the seeds there and ends.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  constexpr std::string_view kOption = "--seeds=";
  for (int i = 1; i < *argc; ++i) {
    const std::string_view argument = (*argv)[i];
    if (!argument.starts_with(kOption)) continue;
    int number = 0;
    for (const std::string& seed : multum::fuzz::seeds())
      multum::fuzz::write(std::string(argument.substr(kOption.size())) + "/seed-" + std::to_string(number++), seed);
    std::exit(0);
  }
  return 0;
}
