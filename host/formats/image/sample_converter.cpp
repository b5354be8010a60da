// SPDX-License-Identifier: Apache-2.0
// A table lookup takes a quarter of the time of OpenImageIO's conversion (0.5 instead of 2 ns per 16-bit sample). Other
// types are computed like convert_pixel_values() of OpenImageIO (SampleConverterTest compares all types).
#include "host/formats/image/sample_converter.h"

#include <half.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <type_traits>
#include <utility>

#include "host/formats/image/files/number_type.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

template <typename Code>
std::vector<Code> all_codes() {
  std::vector<Code> codes(std::size_t{1} << (8 * sizeof(Code)));
  std::iota(codes.begin(), codes.end(), Code{0});
  return codes;
}

template <typename Code>
void look_up(const std::vector<float>& table, const std::byte* samples, std::size_t count, float* values) {
  for (std::size_t i = 0; i < count; ++i) {
    Code code;
    std::memcpy(&code, samples + i * sizeof(Code), sizeof(Code));
    values[i] = table[code];
  }
}

// Integers are multiplied by the reciprocal of their largest value, so unsigned ones become 0..1. Signed ones become
// values from slightly below -1 to 1.
template <typename Sample>
void scale(const std::byte* samples, std::size_t count, float* values) {
  constexpr float kScale =
      std::is_integral_v<Sample> ? 1.0f / static_cast<float>(std::numeric_limits<Sample>::max()) : 1.0f;
  for (std::size_t i = 0; i < count; ++i) {
    Sample sample;
    std::memcpy(&sample, samples + i * sizeof(Sample), sizeof(Sample));
    values[i] = static_cast<float>(sample) * kScale;
  }
}

void scale(int base_type, const std::byte* samples, std::size_t count, float* values) {
  switch (base_type) {
    case number_type::kUint8: return scale<std::uint8_t>(samples, count, values);
    case number_type::kInt8: return scale<std::int8_t>(samples, count, values);
    case number_type::kUint16: return scale<std::uint16_t>(samples, count, values);
    case number_type::kInt16: return scale<std::int16_t>(samples, count, values);
    case number_type::kUint32: return scale<std::uint32_t>(samples, count, values);
    case number_type::kInt32: return scale<std::int32_t>(samples, count, values);
    case number_type::kUint64: return scale<std::uint64_t>(samples, count, values);
    case number_type::kInt64: return scale<std::int64_t>(samples, count, values);
    case number_type::kHalf: return scale<half>(samples, count, values);
    case number_type::kFloat: return scale<float>(samples, count, values);
    case number_type::kDouble: return scale<double>(samples, count, values);
    default: MULTUM_CHECK(is_number_type(base_type));
  }
}

}  // namespace

SampleConverter::SampleConverter(int base_type, std::function<float(float)> then)
    : base_type_(base_type), then_(std::move(then)) {
  const auto fill_table = [this](const auto& codes) {
    table_.resize(codes.size());
    convert_without_table(reinterpret_cast<const std::byte*>(codes.data()), codes.size(), table_.data());
  };
  if (base_type == number_type::kUint8) fill_table(all_codes<std::uint8_t>());
  if (base_type == number_type::kUint16) fill_table(all_codes<std::uint16_t>());
}

void SampleConverter::convert(const std::byte* samples, std::size_t count, float* values) const {
  if (base_type_ == number_type::kUint8) {
    look_up<std::uint8_t>(table_, samples, count, values);
  } else if (base_type_ == number_type::kUint16) {
    look_up<std::uint16_t>(table_, samples, count, values);
  } else {
    convert_without_table(samples, count, values);
  }
}

void SampleConverter::convert_without_table(const std::byte* samples, std::size_t count, float* values) const {
  scale(base_type_, samples, count, values);
  if (then_) std::transform(values, values + count, values, then_);
}

}  // namespace multum
