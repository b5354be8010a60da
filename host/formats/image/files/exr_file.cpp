// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/files/exr_file.h"

#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "host/formats/image/files/number_type.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

// The size limit for frames, which are smaller than maps: 8192 x 8192 pixels, 256 MiB per channel.
constexpr std::int64_t kTexelCountMax = std::int64_t{1} << 26;

}  // namespace

ExrFile::ExrFile(std::string path) : path_(std::move(path)) {
  file_ = open_image_file(path_, {kTexelCountMax, 1, true});
  const ImageDescription& description = file_->description();
  if (description.format != "openexr")
    refuse_file(path_, fmt::format("found {}, expected OpenEXR", description.format));
  for (int part = 0; part < static_cast<int>(description.parts.size()); ++part) list_part(part, file_->part(part));
}

void ExrFile::list_part(int index, const ImagePart& part) {
  if (part.x != part.full_x || part.y != part.full_y || part.width != part.full_width ||
      part.height != part.full_height || (index > 0 && (part.width != width_ || part.height != height_)))
    refuse_file(
        path_, fmt::format("found a data window of {} x {} at ({}, {}) in a frame of {} x {} at ({}, {}), expected the "
                           "whole frame: render without a crop",
                           part.width, part.height, part.x, part.y, part.full_width, part.full_height, part.full_x,
                           part.full_y));
  width_ = part.width;
  height_ = part.height;
  for (int i = 0; i < part.channel_count(); ++i) {
    const std::string& name = part.channel_names[static_cast<std::size_t>(i)];
    if (places_.try_emplace(name, Place{index, i, part.type_of(i)}).second) channels_.push_back(name);
    if (const auto named = part.texts.find("oiio:subimagename"); named != part.texts.end())
      places_.try_emplace(named->second + "." + name, Place{index, i, part.type_of(i)});
  }
  attributes_.insert(part.texts.begin(), part.texts.end());
}

std::vector<std::string> ExrFile::all_names() const {
  std::vector<std::string> names;
  for (const auto& [name, place] : places_) names.push_back(name);
  return names;
}

std::vector<float> ExrFile::read(const std::string& channel) {
  const auto found = places_.find(channel);
  if (found == places_.end())
    refuse_file(path_, fmt::format("has no channel \"{}\"; it has {}", channel, fmt::join(channels_, ", ")));
  const Place& place = found->second;
  if (place.type < number_type::kHalf)
    refuse_file(path_, fmt::format("channel \"{}\" holds integers ({}), expected half or float", channel,
                                   number_name(place.type)));
  std::vector<float> plane(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  const ImagePart& part = file_->part(place.part);
  const PixelBlock block = {place.part, part.y, part.y + height_, place.index, place.index + 1, number_type::kFloat};
  const std::byte* const memory = file_->reserve(block_bytes(part, block));
  if (const std::string message = file_->read(block, 0); !message.empty())
    refuse_file(path_, fmt::format("damaged: cannot read channel \"{}\": {}", channel, message));
  std::memcpy(plane.data(), memory, plane.size() * sizeof(float));
  return plane;
}

bool ExrFile::is_float(const std::string& channel) const { return places_.at(channel).type == number_type::kFloat; }

}  // namespace multum
