// SPDX-License-Identifier: Apache-2.0
// Lobes as GPU textures (`multum export FILE.ndf.exr --lobes`). A KTX2 file holds one 2D array texture with one or two
// layers per lobe. For each lobe, an affine map turns the values of the layers into (a r, a)
// (docs/reference/lobe_textures.md, "Lobes for GPUs"). Because the map is affine, filters may mix stored texels.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec4.hpp>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

constexpr char kLobeTextureKey[] = "multumLobes";  // key in the key/value data
constexpr int kLobeTextureVersion = 1;
constexpr int kLobeChannels = 4;

int layers_per_lobe(LobeTexels texels);
/// Returns the bytes of one layer of one level.
std::uint64_t layer_bytes(LobeTexels texels, int width, int height);

/// (a r, a) = offset + the sum of all columns, each times its channel. The first layer of a lobe holds the first
/// channels, and a second layer holds the others.
struct LobeUnpacking {
  std::array<glm::vec4, kLobeChannels> columns{};
  glm::vec4 offset{0.0f};

  glm::vec4 lobe(const float* channels) const {
    glm::vec4 sum = offset;
    for (std::size_t c = 0; c < columns.size(); ++c) sum += channels[c] * columns[c];
    return sum;
  }
};

/// Everything except the texels.
struct LobeTextureHeader {
  BakedHeader map;  // first_level is level 0 of the texture; the encoding has no meaning
  LobeTexels texels = LobeTexels::kRgba16f;
  std::vector<LobeUnpacking> lobes;

  int layer_count() const { return layers_per_lobe(texels) * static_cast<int>(lobes.size()); }
  int level_count() const { return map.level_count() - map.first_level; }
};

struct LobeTexture {
  LobeTextureHeader header;
  std::vector<std::vector<std::uint8_t>> levels;  // from level 0 of the texture on; the layers of a level follow one
                                                  // another
};

/// Returns the key's value as JSON.
std::string lobe_texture_text(const LobeTextureHeader& header);

/// Returns whether the file is a KTX2 file. Returns false if the file cannot be read.
bool is_ktx2_file(const std::string& path);

/// Read only the header, or the whole file. Both functions throw Error(kInput), which names the file, what was found
/// and what was expected.
LobeTextureHeader read_lobe_texture_header(const std::string& path);
LobeTexture read_lobe_texture(const std::string& path);

/// Returns the bytes of all layers and levels on a GPU.
std::uint64_t lobe_texture_bytes(const LobeTextureHeader& header);

/// Returns the channels of the texels of a lobe in a level, as shaders see them: [texel * kLobeChannels + channel].
std::vector<float> lobe_channels(const LobeTexture& texture, int level, int lobe);

/// Unpacks the stored lobes into a mipmap with encoding kFloat.
MovmfMipmap unpacked_mipmap(const LobeTexture& texture);

}  // namespace multum
