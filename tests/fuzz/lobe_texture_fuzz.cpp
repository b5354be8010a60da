// SPDX-License-Identifier: Apache-2.0
// Fuzzes the reader of lobes as GPU textures: KTX2 files with a key of JSON (docs/reference/lobe_textures.md). Unpacked
// texels must be as many as the header states.
#include "host/foundation/base/size_of.h"
#include "tests/fixtures/lobe_texture_file.h"
#include "tests/fuzz/fuzz.h"

namespace multum {
namespace {

using testing::lobe_texture_file;

LobeTextureHeader header_of(LobeTexels texels) {
  LobeTextureHeader header;
  header.texels = texels;
  header.map.width = 16;
  header.map.height = 8;
  header.map.first_level = 1;
  header.map.provenance.source_name = "map.png";
  header.lobes.resize(2);
  for (LobeUnpacking& lobe : header.lobes)
    for (int c = 0; c < kLobeChannels; ++c) lobe.columns[size_of(c)][c] = 1.0f;
  return header;
}

}  // namespace

std::vector<std::string> fuzz::seeds() {
  return {lobe_texture_file(header_of(LobeTexels::kRgba8), false),
          lobe_texture_file(header_of(LobeTexels::kRgba16f), true),
          lobe_texture_file(header_of(LobeTexels::kBlocks), true)};
}

}  // namespace multum

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multum;
  const std::string path = fuzz::input_file("input.ktx2", {reinterpret_cast<const char*>(data), size});
  fuzz::may_refuse([&] {
    MULTUM_CHECK(lobe_texture_bytes(read_lobe_texture_header(path)) > 0);
    const LobeTexture texture = read_lobe_texture(path);
    const MovmfMipmap mipmap = unpacked_mipmap(texture);
    for (int l = texture.header.map.first_level; l < texture.header.map.level_count(); ++l)
      for (std::size_t j = 0; j < texture.header.lobes.size(); ++j)
        MULTUM_CHECK(mipmap.levels[size_of(l)].lobes[j].size() ==
                     size_of(mip_level_size(texture.header.map.width, l)) *
                         size_of(mip_level_size(texture.header.map.height, l)));
  });
  return 0;
}
