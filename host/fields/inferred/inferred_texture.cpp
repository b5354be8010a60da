// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inferred/inferred_texture.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfStringAttribute.h>
#include <ImfTiledInputFile.h>
#include <ImfTiledOutputFile.h>
#include <half.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "host/formats/asset/exr/exr_input.h"
#include "host/formats/asset/exr/exr_output.h"
#include "host/formats/asset/half_value.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/exr_chunks.h"
#include "host/foundation/base/files/exr_survey.h"

namespace multum {
namespace {

constexpr char kUnreadable[] = "cannot be read as a tiled EXR";

constexpr const char* kProvenance = "multum:provenance";
constexpr int kTile = 64;
constexpr std::array<const char*, 3> kChannels = {"R", "G", "B"};

// Describes one level as three interleaved 16-bit floats per texel.
Imf::FrameBuffer frame_of(half* texels, int width) {
  Imf::FrameBuffer frame;
  for (std::size_t c = 0; c < kChannels.size(); ++c)
    frame.insert(kChannels[c], Imf::Slice(Imf::HALF, reinterpret_cast<char*>(texels + c), 3 * sizeof(half),
                                          3 * sizeof(half) * static_cast<std::size_t>(width)));
  return frame;
}

std::size_t value_count(const MipLevelPlace& level) {
  return 3u * static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height);
}

void check_is_texture(const Imf::TiledInputFile& file, const std::string& path) {
  const Imf::Header& header = file.header();
  if (file.levelMode() != Imf::MIPMAP_LEVELS || file.levelRoundingMode() != Imf::ROUND_DOWN)
    refuse_file(path, "does not have the mip-map mode of inferred textures (MIPMAP_LEVELS, ROUND_DOWN)");
  for (const char* name : kChannels) {
    const Imf::Channel* channel = header.channels().findChannel(name);
    if (channel == nullptr)
      refuse_file(path, std::string("has no channel ") + name + "; inferred textures have R, G and B");
    // The library would round values of other types in its own way, and would convert large values to infinity.
    if (channel->type != Imf::HALF)
      refuse_file(path, std::string("has a channel ") + name + " that does not hold half floats");
  }
  // frame_of() begins at pixel (0, 0). If the file's window began elsewhere, the library would write outside the
  // texels.
  if (header.dataWindow().min != Imath::V2i(0, 0))
    refuse_file(path, "has a data window that does not begin at (0, 0), expected the window of an inferred texture");
  const int width = file.levelWidth(0), height = file.levelHeight(0);
  if (width > kGpuSideMax || height > kGpuSideMax)
    refuse_file(path, "is " + std::to_string(width) + " x " + std::to_string(height) + " texels, expected up to " +
                          std::to_string(kGpuSideMax) + " a side");
}

}  // namespace

void write_inferred_texture(const InferredTexture& texture, const std::string& path) {
  const MipLayout layout(texture.width, texture.height);
  MULTUM_CHECK(texture.texels.size() == 3u * static_cast<std::size_t>(layout.texel_count));
  Imf::Header header(texture.width, texture.height);
  for (const char* channel : kChannels) header.channels().insert(channel, Imf::Channel(Imf::HALF));
  header.setTileDescription(Imf::TileDescription(kTile, kTile, Imf::MIPMAP_LEVELS, Imf::ROUND_DOWN));
  header.compression() = Imf::ZIP_COMPRESSION;
  header.insert(kProvenance, Imf::StringAttribute(texture.provenance));
  write_exr_file(path, [&](Imf::OStream& stream) {
    Imf::TiledOutputFile output(stream, header);
    std::vector<half> values;
    for (int l = 0; l < layout.level_count(); ++l) {
      const MipLevelPlace& level = layout.levels[static_cast<std::size_t>(l)];
      const auto begin = texture.texels.begin() + 3 * level.offset;
      values.resize(value_count(level));
      // Infinity would spread to other texels, because the filter multiplies it by zero weights, which gives NaN.
      std::transform(begin, begin + static_cast<std::ptrdiff_t>(values.size()), values.begin(),
                     [](float value) { return half(std::clamp(value, -kHalfMax, kHalfMax)); });
      output.setFrameBuffer(frame_of(values.data(), level.width));
      output.writeTiles(0, output.numXTiles(l) - 1, 0, output.numYTiles(l) - 1, l);
    }
  });
}

void round_to_half(std::vector<float>& values) {
  for (float& value : values) value = half(value);
}

InferredTexture read_inferred_texture(const std::string& path) {
  try {
    check_exr_headers(path, kUnreadable);
    ExrInputStream stream(path);
    Imf::TiledInputFile file(stream);
    check_is_texture(file, path);
    ExrChunks(path, {}, kUnreadable).check_all(0);
    InferredTexture texture;
    texture.width = file.levelWidth(0);
    texture.height = file.levelHeight(0);
    const MipLayout layout(texture.width, texture.height);
    if (file.numLevels() != layout.level_count()) refuse_file(path, "has too few mip levels");
    texture.texels.reserve(3u * static_cast<std::size_t>(layout.texel_count));
    std::vector<half> values;
    for (int l = 0; l < layout.level_count(); ++l) {
      const MipLevelPlace& level = layout.levels[static_cast<std::size_t>(l)];
      values.resize(value_count(level));
      file.setFrameBuffer(frame_of(values.data(), level.width));
      file.readTiles(0, file.numXTiles(l) - 1, 0, file.numYTiles(l) - 1, l);
      texture.texels.insert(texture.texels.end(), values.begin(), values.end());
    }
    if (const auto* text = file.header().findTypedAttribute<Imf::StringAttribute>(kProvenance))
      texture.provenance = text->value();
    return texture;
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    refuse_file(path, std::string(kUnreadable) + ": " + error.what());
  }
}

std::string read_texture_provenance(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return "";
  try {
    check_exr_headers(path, kUnreadable);
    ExrInputStream stream(path);
    const Imf::TiledInputFile file(stream);
    if (!file.isComplete()) return "";
    const auto* text = file.header().findTypedAttribute<Imf::StringAttribute>(kProvenance);
    return text != nullptr ? text->value() : "";
  } catch (const std::exception&) {  // the file is not an inferred texture, so it is written again
    return "";
  }
}

}  // namespace multum
