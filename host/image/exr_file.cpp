// SPDX-License-Identifier: Apache-2.0
#include "host/image/exr_file.h"

#include <utility>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/image/damaged_file.h"
#include "host/image/image_container.h"

namespace multum {
namespace {

// Frames, not maps: 8192 x 8192, 256 MiB a channel.
constexpr std::int64_t kTexelCountMax = std::int64_t{1} << 26;

[[noreturn]] void refuse(const std::string& path, const std::string& message) {
  throw Error(ErrorCode::kInput, path + ": " + message);
}

}  // namespace

ExrFile::ExrFile(std::string path) : path_(std::move(path)) {
  const ImageContainer container = inspect_image_container(path_, kTexelCountMax);
  if (container.format != "openexr") refuse(path_, fmt::format("found {}, expected OpenEXR", container.format));
  with_damage_named(path_, [&] {
    input_ = OIIO::ImageInput::create(container.format);
    if (!input_) throw Error(ErrorCode::kEnvironment, path_ + ": this OpenImageIO cannot read OpenEXR");
    OIIO::ImageSpec spec;
    if (!input_->open(path_, spec)) refuse(path_, "damaged openexr: " + input_->geterror());
    for (int part = 0; input_->seek_subimage(part, 0); ++part) list_part(part, input_->spec());
    input_->geterror();  // the end of the parts is no error
  });
}

void ExrFile::list_part(int part, const OIIO::ImageSpec& spec) {
  if (spec.x != spec.full_x || spec.y != spec.full_y || spec.width != spec.full_width ||
      spec.height != spec.full_height || (part > 0 && (spec.width != width_ || spec.height != height_)))
    refuse(path_,
           fmt::format("found a data window of {} x {} at ({}, {}) in a frame of {} x {} at ({}, {}), expected the "
                       "whole frame: render without a crop",
                       spec.width, spec.height, spec.x, spec.y, spec.full_width, spec.full_height, spec.full_x,
                       spec.full_y));
  width_ = spec.width;
  height_ = spec.height;
  for (int i = 0; i < spec.nchannels; ++i) {
    const std::string& name = spec.channelnames[static_cast<std::size_t>(i)];
    if (places_.try_emplace(name, Place{part, i, spec.channelformat(i)}).second) channels_.push_back(name);
  }
  for (const OIIO::ParamValue& attribute : spec.extra_attribs)
    if (attribute.type() == OIIO::TypeDesc::STRING)
      attributes_.try_emplace(attribute.name().string(), attribute.get_string());
}

std::vector<float> ExrFile::read(const std::string& channel) {
  const auto found = places_.find(channel);
  if (found == places_.end())
    refuse(path_, fmt::format("has no channel \"{}\"; it has {}", channel, fmt::join(channels_, ", ")));
  const Place& place = found->second;
  if (!place.type.is_floating_point())
    refuse(path_,
           fmt::format("channel \"{}\" holds integers ({}), expected half or float", channel, place.type.c_str()));
  std::vector<float> plane(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  with_damage_named(path_, [&] {
    if (!input_->read_image(place.part, 0, place.index, place.index + 1, OIIO::TypeDesc::FLOAT, plane.data()))
      refuse(path_, fmt::format("damaged: channel \"{}\" cannot be read: {}", channel, input_->geterror()));
  });
  return plane;
}

}  // namespace multum
