// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/object_index.h"

#include <cmath>

#include "host/formats/image/image_reader.h"
#include "host/foundation/base/error.h"

namespace multum {

std::vector<std::vector<float>> read_object_index_coverage(const std::string& path, int width, int height,
                                                           const std::vector<int>& indices) {
  const auto refuse = [&](const std::string& what) { throw Error(ErrorCode::kInput, path + ": " + what); };
  ImageReadSettings settings;
  settings.all_channels = true;
  ImageReader reader(path, settings);
  const RawImageInfo& info = reader.info();
  if (info.width != width || info.height != height)
    refuse("is " + std::to_string(info.width) + " x " + std::to_string(info.height) + " pixels, the job says " +
           std::to_string(width) + " x " + std::to_string(height));
  const bool is_wide = info.sample_type == SampleType::kUint16;
  if (info.channel_count != 1 || (!is_wide && info.sample_type != SampleType::kUint8))
    refuse("is not an object-index image: expected one channel of 8 or 16 bits, found " + info.format);
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  std::vector<std::vector<float>> coverages(indices.size(), std::vector<float>(count, 0.0f));
  const float largest = is_wide ? 65535.0f : 255.0f;
  const SampleConverter converter(info.base_type);
  std::vector<float> values;
  reader.read(
      [&](const RawBand& band) {
        values.resize(info.row_values() * static_cast<std::size_t>(band.row_count));
        converter.convert(band.samples, values.size(), values.data());
        const std::size_t first = info.row_values() * static_cast<std::size_t>(band.first_row);
        for (std::size_t i = 0; i < values.size(); ++i) {
          const long value = std::lround(values[i] * largest);
          for (std::size_t k = 0; k < indices.size(); ++k) coverages[k][first + i] = value == indices[k] ? 1.0f : 0.0f;
        }
      },
      nullptr);
  return coverages;
}

}  // namespace multum
