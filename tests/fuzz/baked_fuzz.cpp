// SPDX-License-Identifier: Apache-2.0
// Files that bakes write, read by what the runtime and `multum verify` read them with. OpenEXR decompresses in this
// process: it is the only library that does (docs/HOSTILE.md).
#include <functional>

#include "host/asset/baked_verify.h"
#include "host/asset/inferred_texture.h"
#include "host/asset/moment_mipmap.h"
#include "host/asset/movmf_mipmap.h"
#include "host/asset/movmf_reader.h"
#include "host/asset/pyramid_file.h"
#include "host/asset/sh_mipmap.h"
#include "tests/fuzz/fuzz.h"

namespace multum {
namespace {

constexpr int kWidth = 6, kHeight = 3;

BakedHeader header_for(Representation representation, StorageEncoding encoding) {
  BakedHeader header;
  header.representation = representation;
  header.encoding = encoding;
  header.provenance = {"multum", "map.png", std::string(64, 'a'), "{\"lobes\":2}", std::string(64, 'b'), "[]", ""};
  header.width = kWidth;
  header.height = kHeight;
  return header;
}

BakedWriteOptions options_with(const std::string& compression) {
  BakedWriteOptions options;
  options.compression = compression;
  options.tile_size = 16;
  options.threads = 1;
  options.measured_error_bytes = 16;
  return options;
}

std::size_t texels(int level) {
  return static_cast<std::size_t>(mip_level_size(kWidth, level) * mip_level_size(kHeight, level));
}

void write_lobes(const std::string& path, Representation representation, const std::string& compression) {
  MovmfMipmap mipmap;
  mipmap.representation = representation;
  mipmap.encoding = representation == Representation::kGmm ? StorageEncoding::kHalf : StorageEncoding::kSnorm16;
  mipmap.provenance = header_for(representation, mipmap.encoding).provenance;
  for (int l = 0; l < mip_level_count(kWidth, kHeight); ++l) {
    const bool is_finest = l == 0;
    MovmfLevel level{mip_level_size(kWidth, l), mip_level_size(kHeight, l), {}, {}};
    // A normal, or a planar Gaussian, along +Z.
    const float third = representation == Representation::kGmm ? 0.0f : 1.0f;
    const glm::vec4 single(0.0f, 0.0f, third, 1.0f);
    level.lobes.push_back(std::vector<glm::vec4>(texels(l), is_finest ? single : 0.5f * single));
    level.lobes.push_back(std::vector<glm::vec4>(texels(l), is_finest ? glm::vec4(0) : glm::vec4(.25, 0, .4, .5)));
    level.colours.assign(2, std::vector<glm::vec3>(texels(l), glm::vec3(is_finest ? 0.0f : 0.25f)));
    if (is_finest) level.colours[0].assign(texels(l), glm::vec3(0.5f));
    mipmap.levels.push_back(level);
  }
  write_movmf_mipmap(path, mipmap, options_with(compression));
}

void write_moments(const std::string& path) {
  MomentMipmap mipmap{header_for(Representation::kMoments, StorageEncoding::kHalf),
                      empty_moment_levels(kWidth, kHeight)};
  for (int l = 0; l < mipmap.header.level_count(); ++l) {
    mipmap.levels[static_cast<std::size_t>(l)].slopes.assign(texels(l), {0.5f, 0.25f, 0.5f, 1.0f, 1.0f, 0.0f});
    mipmap.levels[static_cast<std::size_t>(l)].normals.assign(texels(l), glm::vec3(0, 0, 1));
  }
  write_moment_mipmap(path, mipmap, options_with("none"));
}

void write_harmonics(const std::string& path) {
  ShMipmap mipmap{header_for(Representation::kSh, StorageEncoding::kHalf), 2, empty_sh_levels(kWidth, kHeight)};
  for (int l = 0; l < mipmap.header.level_count(); ++l)
    mipmap.levels[static_cast<std::size_t>(l)].parts.assign(static_cast<std::size_t>(sh_part_count(mipmap.order)),
                                                            std::vector<glm::vec4>(texels(l), glm::vec4(0.25f)));
  write_sh_mipmap(path, mipmap, options_with("zips"));
}

void write_pyramid(const std::string& path) {
  PyramidHeader header{PyramidKind::kColour, header_for(Representation::kMovmf, StorageEncoding::kHalf)};
  PyramidWriter writer(path, header, options_with("rle"));
  for (int l = 0; l < header.level_count(); ++l)
    writer.write_level(
        l, 0, {mip_level_size(kWidth, l), mip_level_size(kHeight, l), std::vector<float>(3 * texels(l), 0.5f)});
  writer.commit(nullptr);
}

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
  const std::vector<std::function<void()>> writers = {[&] { write_lobes(path, Representation::kMovmf, "none"); },
                                                      [&] { write_lobes(path, Representation::kMovmf, "zip:1"); },
                                                      [&] { write_lobes(path, Representation::kGmm, "piz"); },
                                                      [&] { write_moments(path); },
                                                      [&] { write_harmonics(path); },
                                                      [&] { write_pyramid(path); },
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
