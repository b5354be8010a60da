// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/lobes/lobe_colours.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include <glm/geometric.hpp>

#include "host/delivery/export/block_encoder.h"
#include "host/delivery/export/texture_file.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/size_of.h"
#include "host/foundation/base/wrap_mode.h"

namespace multum {
namespace {

// The number of lobes per pair of layers. Readers without BC5 store a pair in one RGBA layer.
constexpr std::size_t kLobesPerPair = 4;
constexpr float kTintsMax = 4.0f;  // limit for a lobe's luminance relative to the texel's luminance; lobes reflect
                                   // light, but do not emit it
constexpr float kLeastLuminance = 1e-4f;
const glm::vec3 kLuminance(0.2126f, 0.7152f, 0.0722f);

using Tints = std::vector<std::vector<float>>;

// Encodes the tints of a level as blocks, layer by layer. A stored share is 1/2 + tint / (2 range).
std::vector<std::uint8_t> encode_tints(BlockEncoder& encoder, int width, int height, float range, const Tints& tints) {
  std::vector<std::uint8_t> all;
  const std::size_t count = kLobesPerPair * ((tints.size() + kLobesPerPair - 1) / kLobesPerPair);
  for (std::size_t j = 0; j < count; j += 2) {
    std::vector<glm::vec4> texels(tints.front().size(), glm::vec4(0.5f, 0.5f, 0.0f, 0.0f));
    for (std::size_t c = 0; c < 2 && j + c < tints.size(); ++c)
      for (std::size_t i = 0; i < texels.size(); ++i)
        texels[i][static_cast<glm::length_t>(c)] = 0.5f + 0.5f * tints[j + c][i] / range;
    const std::vector<std::uint8_t> blocks = encoder.encode(TexelFormat::kBc5, width, height, texels);
    all.insert(all.end(), blocks.begin(), blocks.end());
  }
  return all;
}

std::string tints_text(const BakedHeader& map, std::size_t lobe_count, float range) {
  return json_text(nlohmann::ordered_json{{"version", kLobeColourVersion},
                                          {"mapWidth", map.width},
                                          {"mapHeight", map.height},
                                          {"firstLevel", kLobeColourFirstLevel},
                                          {"wrapS", wrap_mode_name(map.wrap_s)},
                                          {"wrapT", wrap_mode_name(map.wrap_t)},
                                          {"lobes", lobe_count},
                                          {"range", range}});
}

}  // namespace

std::vector<std::vector<float>> lobe_tints(const MovmfLevel& level) {
  Tints tints(level.lobes.size(), std::vector<float>(level.lobes.front().size(), 0.0f));
  for (std::size_t i = 0; i < level.lobes.front().size(); ++i) {
    glm::vec3 colour(0.0f);
    float amplitude = 0.0f;
    for (std::size_t j = 0; j < tints.size(); ++j) colour += level.colours[j][i], amplitude += level.lobes[j][i].w;
    const float luminance = glm::dot(kLuminance, colour) / std::max(amplitude, 1e-6f);
    if (luminance < kLeastLuminance) continue;
    for (std::size_t j = 0; j < tints.size(); ++j) {
      const float a = level.lobes[j][i].w;
      tints[j][i] = std::clamp(glm::dot(kLuminance, level.colours[j][i]) / luminance, 0.0f, kTintsMax * a) - a;
    }
  }
  return tints;
}

std::uint64_t export_lobe_colours(const LobeColourJob& job, Device& device, Progress* progress) {
  const MovmfMipmap mipmap = read_movmf_mipmap(job.input, job.threads);
  const int level_count = static_cast<int>(mipmap.levels.size()) - kLobeColourFirstLevel;
  if (level_count < 1 || mipmap.levels.back().colours.empty()) return 0;
  std::vector<Tints> tints;
  float range = 1e-6f;
  for (int l = 0; l < level_count; ++l) {
    tints.push_back(lobe_tints(mipmap.levels[size_of(l + kLobeColourFirstLevel)]));
    for (const auto& of_lobe : tints.back())
      for (const float tint : of_lobe) range = std::max(range, std::abs(tint));
  }
  const std::size_t lobe_count = tints.front().size();
  const MovmfLevel& first = mipmap.levels[size_of(kLobeColourFirstLevel)];
  const LeveledTexture texture{TexelFormat::kBc5, first.width, first.height, level_count,
                               static_cast<int>(2 * ((lobe_count + kLobesPerPair - 1) / kLobesPerPair))};
  const std::unique_ptr<TextureFile> file =
      make_ktx2_file(job.output, texture,
                     {"", job.zstd_level, {{kLobeColourKey, tints_text(full_header(mipmap), lobe_count, range)}}});
  BlockEncoder encoder(device);
  for (int l = 0; l < level_count; ++l) {
    progress_advance(progress, 0);  // lets the caller cancel
    const MovmfLevel& level = mipmap.levels[size_of(l + kLobeColourFirstLevel)];
    const auto blocks = encode_tints(encoder, level.width, level.height, range, tints[size_of(l)]);
    file->write_rows(l, block_rows(texture, l), blocks.data());
  }
  file->finish();
  return std::filesystem::file_size(job.output);
}

}  // namespace multum
