// SPDX-License-Identifier: Apache-2.0
// Computes the coefficients of a chunk's textures on an OpenCL device (kernels/image_transform.cl). Each step is one
// launch for all textures of a batch.
#pragma once

#include <mutex>

#include "host/fields/codec/image_transforms.h"
#include "host/formats/opencl/device.h"

namespace multum {

class DeviceImageTransforms : public ImageTransforms {
 public:
  static constexpr std::size_t kBatchBytes = std::size_t{16} << 20;

  /// The device must outlive this object. `batch_bytes` limits the size of each buffer. Only a single large texture may
  /// exceed this limit. The coefficients do not depend on it.
  explicit DeviceImageTransforms(Device& device, std::size_t batch_bytes = kBatchBytes);

  /// Calls from several threads run one after another. Throws Error(kEnvironment).
  std::vector<PlaneCoefficients> coefficients(const CoefficientLayout& layout,
                                              const std::vector<std::vector<float>>& textures,
                                              const PlaneAxes& axes) override;

 private:
  struct Batch;
  void add_batch(const CoefficientLayout& layout, const Batch& batch, std::vector<PlaneCoefficients>& all);
  void make_planes(const CoefficientLayout& layout, const Batch& batch);
  void transform_blocks(const CoefficientLayout& layout, int image_count);
  void transform_levels(const CoefficientLayout& layout, int image_count);
  void reserve(DeviceBuffer& buffer, std::size_t values);

  Device& device_;
  const std::size_t batch_bytes_;
  std::mutex mutex_;
  Kernel colour_planes_, dct_rows_, dct_columns_, wavelet_lift_;
  DeviceBuffer textures_, axes_, planes_, other_, cosines_;  // a step writes its planes to `other_`
};

}  // namespace multum
