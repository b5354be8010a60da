// SPDX-License-Identifier: Apache-2.0
// Lobes as a GPU takes them, `multum export FILE.ndf.exr --lobes`: a KTX2 file of one 2D array texture, one or two
// layers a lobe, and of each lobe the affine map from what the layers hold to (a r, a)
// (docs/reference/lobe_textures.md, "Lobes for GPUs"). The map is affine, so that filters may mix texels as they lie.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec4.hpp>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

constexpr char kLobeTextureKey[] = "multumLobes";  // in the key/value data
constexpr int kLobeTextureVersion = 1;
constexpr int kLobeChannels = 4;

int layers_per_lobe(LobeTexels texels);
/// Of a layer of a level.
std::uint64_t layer_bytes(LobeTexels texels, int width, int height);

/// (a r, a) = offset + the sum of columns, each times its channel: those of a lobe's first layer, then its second.
struct LobeUnpacking {
  std::array<glm::vec4, kLobeChannels> columns{};
  glm::vec4 offset{0.0f};

  glm::vec4 lobe(const float* channels) const {
    glm::vec4 sum = offset;
    for (std::size_t c = 0; c < columns.size(); ++c) sum += channels[c] * columns[c];
    return sum;
  }
};

/// All but the texels.
struct LobeTextureHeader {
  BakedHeader map;  // first_level is that of the texture's level 0; the encoding means nothing
  LobeTexels texels = LobeTexels::kRgba16f;
  std::vector<LobeUnpacking> lobes;

  int layer_count() const { return layers_per_lobe(texels) * static_cast<int>(lobes.size()); }
  int level_count() const { return map.level_count() - map.first_level; }
};

struct LobeTexture {
  LobeTextureHeader header;
  std::vector<std::vector<std::uint8_t>> levels;  // texture's level 0 first; layers behind one another
};

/// What the key holds, JSON.
std::string lobe_texture_text(const LobeTextureHeader& header);

/// Is it a KTX2 file? No for what cannot be read.
bool is_ktx2_file(const std::string& path);

/// The header alone, and all. Throws Error(kInput) naming the file, what was found and what was expected.
LobeTextureHeader read_lobe_texture_header(const std::string& path);
LobeTexture read_lobe_texture(const std::string& path);

/// Bytes of all layers and levels on a GPU.
std::uint64_t lobe_texture_bytes(const LobeTextureHeader& header);

/// Channels of a lobe's texels of a level, as shaders see them: [texel * kLobeChannels + channel].
std::vector<float> lobe_channels(const LobeTexture& texture, int level, int lobe);

/// The lobes that are stored, unpacked, as a baked file's: encoding kFloat.
MovmfMipmap unpacked_mipmap(const LobeTexture& texture);

}  // namespace multum
