// SPDX-License-Identifier: Apache-2.0
// Baked files of every kind, 6 x 3 texels, written by the project's own writers; `multum verify` accepts them. For
// tests that change their bytes.
#pragma once

#include <string>
#include <vector>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/asset/pyramid/pyramid_file.h"

namespace multum::testing {

constexpr int kSmallWidth = 6, kSmallHeight = 3;

inline BakedHeader small_header(Representation representation, StorageEncoding encoding) {
  BakedHeader header;
  header.representation = representation;
  header.encoding = encoding;
  header.provenance = {"multum", "map.png", std::string(64, 'a'), "{\"lobes\":2}", std::string(64, 'b'), "[]", ""};
  header.width = kSmallWidth;
  header.height = kSmallHeight;
  return header;
}

inline BakedWriteOptions small_options(const std::string& compression) {
  BakedWriteOptions options;
  options.compression = compression;
  options.tile_size = 16;
  options.threads = 1;
  options.measured_error_bytes = 64;
  return options;
}

inline std::size_t small_texels(int level) {
  return static_cast<std::size_t>(mip_level_size(kSmallWidth, level) * mip_level_size(kSmallHeight, level));
}

inline void write_small_lobes(const std::string& path, Representation representation, const std::string& compression,
                              const std::string& measured_error = "[]") {
  MovmfMipmap mipmap;
  mipmap.header.representation = representation;
  mipmap.header.encoding = representation == Representation::kGmm ? StorageEncoding::kHalf : StorageEncoding::kSnorm16;
  mipmap.header.provenance = small_header(representation, mipmap.header.encoding).provenance;
  mipmap.header.provenance.measured_error = measured_error;
  for (int l = 0; l < mip_level_count(kSmallWidth, kSmallHeight); ++l) {
    const bool is_finest = l == 0;
    MovmfLevel level{mip_level_size(kSmallWidth, l), mip_level_size(kSmallHeight, l), {}, {}};
    // A normal, or a planar Gaussian, along +Z.
    const float third = representation == Representation::kGmm ? 0.0f : 1.0f;
    const glm::vec4 single(0.0f, 0.0f, third, 1.0f);
    const std::size_t texels = small_texels(l);
    level.lobes.push_back(std::vector<glm::vec4>(texels, is_finest ? single : 0.5f * single));
    level.lobes.push_back(std::vector<glm::vec4>(texels, is_finest ? glm::vec4(0) : glm::vec4(.25, 0, .375, .5)));
    level.colours.assign(2, std::vector<glm::vec3>(texels, glm::vec3(is_finest ? 0.0f : 0.25f)));
    if (is_finest) level.colours[0].assign(texels, glm::vec3(0.5f));
    mipmap.levels.push_back(level);
  }
  write_movmf_mipmap(path, mipmap, small_options(compression));
}

inline void write_small_moments(const std::string& path) {
  MomentMipmap mipmap{small_header(Representation::kMoments, StorageEncoding::kHalf),
                      empty_moment_levels(kSmallWidth, kSmallHeight)};
  for (int l = 0; l < mipmap.header.level_count(); ++l) {
    mipmap.levels[static_cast<std::size_t>(l)].slopes.assign(small_texels(l), {0.5f, 0.25f, 0.5f, 1.0f, 1.0f, 0.0f});
    mipmap.levels[static_cast<std::size_t>(l)].normals.assign(small_texels(l), glm::vec3(0, 0, 1));
  }
  write_moment_mipmap(path, mipmap, small_options("none"));
}

// Of the direction +Z: coefficients 1 and 5, those of m = 0, are sqrt((2l + 1) / 4 pi), here the nearest halfs.
inline void write_small_harmonics(const std::string& path) {
  ShMipmap mipmap{small_header(Representation::kSh, StorageEncoding::kHalf), 2,
                  empty_sh_levels(kSmallWidth, kSmallHeight)};
  for (int l = 0; l < mipmap.header.level_count(); ++l)
    mipmap.levels[static_cast<std::size_t>(l)].parts = {
        std::vector<glm::vec4>(small_texels(l), glm::vec4(0, 2001.0f / 4096.0f, 0, 0)),
        std::vector<glm::vec4>(small_texels(l), glm::vec4(0, 1292.0f / 2048.0f, 0, 0))};
  write_sh_mipmap(path, mipmap, small_options("zips"));
}

inline void write_small_pyramid(const std::string& path) {
  PyramidHeader header{PyramidKind::kColour, small_header(Representation::kMovmf, StorageEncoding::kHalf)};
  PyramidWriter writer(path, header, small_options("rle"));
  for (int l = 0; l < header.level_count(); ++l)
    writer.write_level(l, 0,
                       {mip_level_size(kSmallWidth, l), mip_level_size(kSmallHeight, l),
                        std::vector<float>(3 * small_texels(l), 0.5f)});
  writer.commit(nullptr);
}

}  // namespace multum::testing
