// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/files/image_file.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "host/formats/image/files/memory_image_file.h"
#include "host/formats/image/files/number_type.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

// Our own limit is needed because OpenImageIO's limit applies only in the other process.
constexpr int kChannelCountMax = 1024;
constexpr std::size_t kPartCountMax = 256;

void check_part(const std::string& path, const ImagePart& part, std::int64_t texel_count_max) {
  check_image_size(path, part.width, part.height, texel_count_max);
  constexpr int kFarthest = 1 << 30;  // so that the sum of a position and a size fits into an int
  for (const int place : {part.x, part.y, part.full_x, part.full_y})
    if (place < -kFarthest || place > kFarthest)
      refuse_file(path,
                  fmt::format("found a data window at ({}, {}) of a frame at ({}, {}), expected positions within 2^30",
                              part.x, part.y, part.full_x, part.full_y));
  if (part.width > kFarthest || part.height > kFarthest || part.tile_width < 0 || part.tile_height < 0 ||
      (part.tile_width > 0) != (part.tile_height > 0))
    refuse_file(path, fmt::format("damaged: {} x {} texels in tiles of {} x {}", part.width, part.height,
                                  part.tile_width, part.tile_height));
  if (part.channel_names.empty() || part.channel_count() > kChannelCountMax)
    refuse_file(path, fmt::format("found {} channels, expected 1 to {}", part.channel_count(), kChannelCountMax));
  if (!part.channel_types.empty() && part.channel_types.size() != part.channel_names.size())
    refuse_file(path, "damaged: the number of channel types differs from the number of channels");
  if (part.alpha_channel < -1 || part.alpha_channel >= part.channel_count())
    refuse_file(path, "damaged: its alpha channel does not exist");
  for (int channel = 0; channel < part.channel_count(); ++channel)
    if (!is_number_type(part.type_of(channel)) || !is_number_type(part.base_type))
      refuse_file(path, fmt::format("found samples of type {}, expected integers or floats",
                                    number_name(part.type_of(channel))));
}

ImageOpener& opener() {
  static ImageOpener current = open_in_child({});
  return current;
}

}  // namespace

std::size_t ImagePart::texel_bytes() const {
  std::size_t sum = 0;
  for (int channel = 0; channel < channel_count(); ++channel) sum += number_bytes(type_of(channel));
  return sum;
}

std::size_t block_bytes(const ImagePart& part, const PixelBlock& block) {
  return static_cast<std::size_t>(part.width) * static_cast<std::size_t>(block.y_end - block.y_begin) *
         static_cast<std::size_t>(block.channel_end - block.channel_begin) * number_bytes(block.base_type);
}

void set_image_opener(ImageOpener next) { opener() = std::move(next); }

void check_described(const std::string& path, const ImageDescription& description, std::int64_t texel_count_max) {
  if (description.parts.empty() || description.parts.size() > kPartCountMax)
    refuse_file(path, fmt::format("found {} parts, expected 1 to {}", description.parts.size(), kPartCountMax));
  constexpr std::size_t kNoteCountMax = 16;
  if (description.notes.size() > kNoteCountMax || !std::isfinite(description.texel_metres) ||
      !std::isfinite(description.no_data.value_or(0.0)))
    refuse_file(path, "damaged: its description is inconsistent");
  for (const ImagePart& part : description.parts) check_part(path, part, texel_count_max);
}

std::unique_ptr<ImageFile> open_image_file(const std::string& path, const ImageFileSettings& settings) {
  std::unique_ptr<ImageFile> file = open_memory_image(path);
  if (file == nullptr) file = opener()(path, settings);
  check_described(path, file->description(), settings.texel_count_max);
  return file;
}

}  // namespace multum
