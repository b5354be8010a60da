// SPDX-License-Identifier: Apache-2.0
// Converts samples of a file to floats, with integers scaled to 0..1. The result equals OpenImageIO's conversion to
// FLOAT bit by bit. A function can then be applied to the values.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace multum {

class SampleConverter {
 public:
  /// `base_type` is a code of host/formats/image/files/number_type.h. `then` is called once for each code of 8 and 16
  /// bits.
  explicit SampleConverter(int base_type, std::function<float(float)> then = {});

  /// `values` holds `count` floats. Several threads may convert at the same time.
  void convert(const std::byte* samples, std::size_t count, float* values) const;

 private:
  void convert_without_table(const std::byte* samples, std::size_t count, float* values) const;

  int base_type_;
  std::function<float(float)> then_;
  std::vector<float> table_;  // values of 8- and 16-bit codes; empty for other types
};

}  // namespace multum
