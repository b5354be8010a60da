// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/textures/lobe_texture.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/formats/asset/textures/scalar_block.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/half_bits.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr int kBlockSide = 4, kBlockBytes = 16;  // for BC5

nlohmann::ordered_json vector_json(const glm::vec4& v) { return {v.x, v.y, v.z, v.w}; }

void decode_lobe_blocks(const std::uint8_t* block, int width, int height, float* channels) {
  for (int y = 0; y < height; y += kBlockSide)
    for (int x = 0; x < width; x += kBlockSide, block += kBlockBytes)
      for (int c = 0; c < 2; ++c) {
        const std::array<float, 16> values = decode_scalar_block(block + 8 * c);
        for (int j = 0; j < std::min(kBlockSide, height - y); ++j)
          for (int i = 0; i < std::min(kBlockSide, width - x); ++i)
            channels[(size_of(y + j) * size_of(width) + size_of(x + i)) * kLobeChannels + size_of(c)] =
                values[size_of(kBlockSide * j + i)];
      }
}

}  // namespace

int layers_per_lobe(LobeTexels texels) { return texels == LobeTexels::kBlocks ? 2 : 1; }

std::uint64_t layer_bytes(LobeTexels texels, int width, int height) {
  if (texels != LobeTexels::kBlocks) return (texels == LobeTexels::kRgba8 ? 4u : 8u) * size_of(width) * size_of(height);
  const auto blocks = [](int side) { return size_of((side + kBlockSide - 1) / kBlockSide); };
  return blocks(width) * blocks(height) * kBlockBytes;
}

std::uint64_t lobe_texture_bytes(const LobeTextureHeader& header) {
  std::uint64_t bytes = 0;
  for (int l = header.map.first_level; l < header.map.level_count(); ++l)
    bytes += size_of(header.layer_count()) *
             layer_bytes(header.texels, mip_level_size(header.map.width, l), mip_level_size(header.map.height, l));
  return bytes;
}

std::string lobe_texture_text(const LobeTextureHeader& header) {
  const BakedHeader& map = header.map;
  nlohmann::ordered_json json = {{"version", kLobeTextureVersion},
                                 {"mapWidth", map.width},
                                 {"mapHeight", map.height},
                                 {"firstLevel", map.first_level},
                                 {"wrapS", wrap_mode_name(map.wrap_s)},
                                 {"wrapT", wrap_mode_name(map.wrap_t)},
                                 {"layersPerLobe", layers_per_lobe(header.texels)},
                                 {"lobes", nlohmann::ordered_json::array()}};
  for (const LobeUnpacking& lobe : header.lobes) {
    nlohmann::ordered_json columns = nlohmann::ordered_json::array();
    for (const glm::vec4& column : lobe.columns) columns.push_back(vector_json(column));
    json["lobes"].push_back({{"columns", columns}, {"offset", vector_json(lobe.offset)}});
  }
  if (map.has_roughness) json["meanCosine"] = map.mean_cosine;
  json["source"] = {{"name", text_of_path(map.provenance.source_name)},
                    {"sha256", map.provenance.source_hash},
                    {"settings", map.provenance.settings},
                    {"contentHash", map.provenance.content_hash}};
  return json_text(json);
}

std::vector<float> lobe_channels(const LobeTexture& texture, int level, int lobe) {
  const LobeTextureHeader& header = texture.header;
  const int width = mip_level_size(header.map.width, header.map.first_level + level);
  const int height = mip_level_size(header.map.height, header.map.first_level + level);
  const std::size_t texels = size_of(width) * size_of(height);
  const std::uint64_t bytes = layer_bytes(header.texels, width, height);
  std::vector<float> channels(texels * kLobeChannels);
  const int layers = layers_per_lobe(header.texels);
  for (int k = 0; k < layers; ++k) {
    const std::uint8_t* layer = texture.levels[size_of(level)].data() + bytes * size_of(lobe * layers + k);
    if (header.texels == LobeTexels::kBlocks) {
      decode_lobe_blocks(layer, width, height, channels.data() + 2 * k);
      continue;
    }
    for (std::size_t i = 0; i < 4 * texels; ++i)
      channels[i] = header.texels == LobeTexels::kRgba8
                        ? static_cast<float>(layer[i]) / 255.0f
                        : half_to_float(static_cast<std::uint16_t>(layer[2 * i] | layer[2 * i + 1] << 8));
  }
  return channels;
}

MovmfMipmap unpacked_mipmap(const LobeTexture& texture) {
  const LobeTextureHeader& header = texture.header;
  MovmfMipmap mipmap = empty_movmf_mipmap(header.map, static_cast<int>(header.lobes.size()));
  mipmap.header.encoding = StorageEncoding::kFloat;
  for (int l = 0; l < header.level_count(); ++l) {
    MovmfLevel& level = mipmap.levels[size_of(header.map.first_level + l)];
    for (std::size_t j = 0; j < header.lobes.size(); ++j) {
      const LobeUnpacking& unpacking = header.lobes[j];
      const std::vector<float> channels = lobe_channels(texture, l, static_cast<int>(j));
      level.lobes[j].reserve(channels.size() / kLobeChannels);
      for (std::size_t at = 0; at < channels.size(); at += kLobeChannels)
        level.lobes[j].push_back(unpacking.lobe(&channels[at]));
    }
  }
  return mipmap;
}

}  // namespace multum
