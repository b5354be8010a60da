// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/files/exr_layers.h"

#include "host/formats/image/files/exr_file.h"

namespace multum {

ExrLayers read_exr_channels(const std::string& path, const std::vector<std::string>& channels) {
  ExrFile file(path);
  ExrLayers layers;
  layers.width = file.width();
  layers.height = file.height();
  for (const std::string& channel : channels) layers.channels[channel] = file.read(channel);
  return layers;
}

std::vector<std::string> exr_channel_names(const std::string& path) { return ExrFile(path).channels(); }

}  // namespace multum
