// SPDX-License-Identifier: Apache-2.0
// Fuzzes readers of baked files, as the runtime and `multum verify` use them. OpenEXR is the only library that
// decompresses files in this process (docs/contributing/HOSTILE.md).
#include <functional>

#include "host/fields/inferred/inferred_texture.h"
#include "host/formats/asset/baked_verify.h"
#include "host/formats/asset/lobes/movmf_reader.h"
#include "tests/fixtures/small_baked_files.h"
#include "tests/fuzz/fuzz.h"

namespace multum {
namespace {

void read(const std::string& path) {
  if (is_pyramid_file(path)) {
    read_pyramid(path);
    return;
  }
  switch (read_baked_header(path).representation) {
    case Representation::kMoments: read_moment_mipmap(path, 1); break;
    case Representation::kSh: read_sh_mipmap(path, 1); break;
    default: read_movmf_mipmap(path, 1);
  }
}
void verify(const std::string& path) { verify_baked(path, 1); }
void read_texture(const std::string& path) {
  fuzz::may_refuse([&] { read_texture_provenance(path); });
  read_inferred_texture(path);
}
constexpr void (*kReaders[])(const std::string&) = {read, verify, read_texture};

void write_texture(const std::string& path) {
  InferredTexture texture{8, 4, {}, "{}"};
  texture.texels.assign(static_cast<std::size_t>(MipLayout(8, 4).texel_count) * 3, 0.5f);
  write_inferred_texture(texture, path);
}

}  // namespace

std::vector<std::string> fuzz::seeds() {
  const std::string path = scratch_folder() + "/seed.ndf.exr";
  const std::vector<std::function<void()>> writers = {
      [&] { testing::write_small_lobes(path, Representation::kMovmf, "none"); },
      [&] { testing::write_small_lobes(path, Representation::kMovmf, "zip:1"); },
      [&] { testing::write_small_lobes(path, Representation::kGmm, "piz"); },
      [&] { testing::write_small_moments(path); },
      [&] { testing::write_small_harmonics(path); },
      [&] { testing::write_small_pyramid(path); },
      [&] { write_texture(path); }};
  std::vector<std::string> seeds;
  for (const std::function<void()>& write : writers) {
    write();
    for (char reader = 0; reader < static_cast<char>(std::size(kReaders)); ++reader)
      seeds.push_back(reader + file_bytes(path));
  }
  return seeds;
}

}  // namespace multum

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multum;
  const auto input = fuzz::split(data, size, std::size(kReaders));
  const std::string path = fuzz::input_file("input.ndf.exr", input.bytes);
  fuzz::may_refuse([&] { kReaders[input.kind](path); });
  return 0;
}
