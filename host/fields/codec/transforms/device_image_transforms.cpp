// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/transforms/device_image_transforms.h"

#include <algorithm>

#include "host/fields/codec/decoder/block_dct.h"
#include "host/fields/codec/decoder/dct_stream_decoder.h"
#include "host/fields/codec/decoder/wavelet_transform.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

// Work-items are small. On PoCL, starting a work-group takes as long as running one work-item.
constexpr std::size_t kTransformLocalSize = 64;

}  // namespace

struct DeviceImageTransforms::Batch {
  const std::vector<std::vector<float>>& textures;
  const PlaneAxes& axes;
  std::size_t begin, count;  // index of the first texture, and number of textures
};

DeviceImageTransforms::DeviceImageTransforms(Device& device, std::size_t batch_bytes)
    : device_(device), batch_bytes_(batch_bytes) {}

std::vector<PlaneCoefficients> DeviceImageTransforms::coefficients(const CoefficientLayout& layout,
                                                                   const std::vector<std::vector<float>>& textures,
                                                                   const PlaneAxes& axes) {
  const std::lock_guard lock(mutex_);
  if (!colour_planes_.is_built()) {  // programs are built at the first call
    const auto kernel = [&](const char* name) { return device_.kernel("image_transform", name, {1, 1, false}); };
    colour_planes_ = kernel("colour_planes");
    dct_rows_ = kernel("dct_rows");
    dct_columns_ = kernel("dct_columns");
    wavelet_lift_ = kernel("wavelet_lift");
  }
  const std::size_t bytes = 3 * layout.coefficient_count() * sizeof(float);
  const std::size_t fitting = std::max<std::size_t>(1, batch_bytes_ / bytes);
  std::vector<PlaneCoefficients> all;
  all.reserve(textures.size());
  for (std::size_t begin = 0; begin < textures.size(); begin += fitting)
    add_batch(layout, {textures, axes, begin, std::min(fitting, textures.size() - begin)}, all);
  return all;
}

void DeviceImageTransforms::add_batch(const CoefficientLayout& layout, const Batch& batch,
                                      std::vector<PlaneCoefficients>& all) {
  make_planes(layout, batch);
  const auto images = static_cast<int>(3 * batch.count);
  if (layout.coder == ImageCoder::kDct) transform_blocks(layout, images);
  else transform_levels(layout, images);
  const std::size_t count = layout.coefficient_count();
  device_.read_ranges({{&planes_, 0, 3 * batch.count * count * sizeof(float)}}, [&](const Device::Bytes& bytes) {
    const auto* values = reinterpret_cast<const float*>(bytes[0]);
    for (std::size_t t = 0; t < batch.count; ++t) {
      PlaneCoefficients& of_texture = all.emplace_back();
      for (std::size_t p = 0; p < 3; ++p, values += count) of_texture[p].assign(values, values + count);
    }
  });
}

void DeviceImageTransforms::reserve(DeviceBuffer& buffer, std::size_t values) {
  if (buffer.byte_count() < values * sizeof(float)) buffer = device_.make_buffer(values * sizeof(float), "textures");
}

void DeviceImageTransforms::make_planes(const CoefficientLayout& layout, const Batch& batch) {
  const std::size_t texels = layout.width * layout.height, values = 3 * batch.count * layout.coefficient_count();
  reserve(textures_, 3 * batch.count * texels);
  reserve(planes_, values);
  reserve(other_, values);
  reserve(axes_, 12);
  device_.write_ranges({{&textures_, 0, 3 * batch.count * texels * sizeof(float)}, {&axes_, 0, 12 * sizeof(float)}},
                       [&](const Device::Bytes& bytes) {
                         auto* texture = reinterpret_cast<float*>(bytes[0]);
                         for (std::size_t t = 0; t < batch.count; ++t, texture += 3 * texels) {
                           MULTUM_CHECK(batch.textures[batch.begin + t].size() == 3 * texels);
                           std::copy_n(batch.textures[batch.begin + t].begin(), 3 * texels, texture);
                         }
                         auto* axis = reinterpret_cast<float*>(bytes[1]);
                         for (std::size_t p = 0; p < 3; ++p, axis += 4) {
                           std::copy_n(batch.axes.rows[p].begin(), 3, axis);
                           axis[3] = batch.axes.offsets[p];
                         }
                       });
  colour_planes_.launch({batch.count * texels, kTransformLocalSize}, textures_, axes_, planes_,
                        static_cast<int>(batch.count), static_cast<int>(texels));
}

void DeviceImageTransforms::transform_blocks(const CoefficientLayout& layout, int image_count) {
  const auto side = static_cast<int>(layout.side);
  const std::span<const float> cosines = dct_cosines(side);
  reserve(cosines_, cosines.size());
  device_.write(cosines_, cosines.data(), cosines.size() * sizeof(float));
  const std::size_t blocks =
      static_cast<std::size_t>(image_count) * BlockGrid{layout.width, layout.height, layout.side}.count();
  dct_rows_.launch({blocks * layout.side, kTransformLocalSize}, planes_, cosines_, other_, image_count,
                   static_cast<int>(layout.width), static_cast<int>(layout.height), side);
  dct_columns_.launch({blocks * layout.side, kTransformLocalSize}, other_, cosines_, planes_, static_cast<int>(blocks),
                      side);
}

void DeviceImageTransforms::transform_levels(const CoefficientLayout& layout, int image_count) {
  const auto width = static_cast<int>(layout.width), texels = static_cast<int>(layout.width * layout.height);
  const auto lift = [&](const DeviceBuffer& from, const DeviceBuffer& to, int lines, int step, int length, int stride) {
    const int items = image_count * lines * ((length + 1) / 2);
    wavelet_lift_.launch({static_cast<std::size_t>(items), kTransformLocalSize}, from, to, image_count, texels, lines,
                         step, length, stride);
  };
  // Both sides of a level have at least 8 samples. The row step writes to the other buffer, and the column step writes
  // back.
  std::size_t columns = layout.width, rows = layout.height;
  for (int depth = wavelet_depth(layout.width, layout.height); depth > 0; --depth) {
    lift(planes_, other_, static_cast<int>(rows), width, static_cast<int>(columns), 1);
    lift(other_, planes_, static_cast<int>(columns), 1, static_cast<int>(rows), width);
    columns = (columns + 1) / 2;
    rows = (rows + 1) / 2;
  }
}

}  // namespace multum
