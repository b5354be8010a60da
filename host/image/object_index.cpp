// SPDX-License-Identifier: Apache-2.0
#include "host/image/object_index.h"

#include <OpenImageIO/imageio.h>

#include <cstdint>

#include "host/base/error.h"

namespace multum {

std::vector<std::vector<float>> read_object_index_coverage(const std::string& path, int width, int height,
                                                           const std::vector<int>& indices) {
  const auto refuse = [&](const std::string& what) { throw Error(ErrorCode::kInput, path + ": " + what); };
  const auto input = OIIO::ImageInput::open(path);
  if (input == nullptr) refuse("cannot be read: " + OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.width != width || spec.height != height)
    refuse("is " + std::to_string(spec.width) + " x " + std::to_string(spec.height) + " pixels, the job says " +
           std::to_string(width) + " x " + std::to_string(height));
  const bool is_wide = spec.format == OIIO::TypeDesc::UINT16;
  if (spec.nchannels != 1 || (!is_wide && spec.format != OIIO::TypeDesc::UINT8))
    refuse("is no object-index image: expected one channel of 8 or 16 bits, found " + std::to_string(spec.nchannels) +
           " of " + spec.format.c_str());
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  std::vector<std::uint16_t> values(count);
  if (!input->read_image(0, 0, 0, 1, OIIO::TypeDesc::UINT16, values.data())) refuse("is damaged: " + input->geterror());
  // OpenImageIO widens 8 bits to 16 by 257.
  std::vector<std::vector<float>> coverages(indices.size(), std::vector<float>(count, 0.0f));
  for (std::size_t k = 0; k < indices.size(); ++k) {
    const int value = is_wide ? indices[k] : 257 * indices[k];
    for (std::size_t i = 0; i < count; ++i) coverages[k][i] = values[i] == value ? 1.0f : 0.0f;
  }
  return coverages;
}

}  // namespace multum
