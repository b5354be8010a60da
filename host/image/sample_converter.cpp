// SPDX-License-Identifier: Apache-2.0
// Looking up takes a quarter of the time of OpenImageIO's conversion (0.5 instead of 2 ns a sample of 16 bits).
#include "host/image/sample_converter.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <utility>

#include <OpenImageIO/imageio.h>

namespace multum {
namespace {

OIIO::TypeDesc type_desc(int base_type) { return OIIO::TypeDesc(static_cast<OIIO::TypeDesc::BASETYPE>(base_type)); }

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

}  // namespace

SampleConverter::SampleConverter(int base_type, std::function<float(float)> then)
    : base_type_(base_type), then_(std::move(then)) {
  const auto fill_table = [this](const auto& codes) {
    table_.resize(codes.size());
    convert_without_table(reinterpret_cast<const std::byte*>(codes.data()), codes.size(), table_.data());
  };
  if (base_type == OIIO::TypeDesc::UINT8) fill_table(all_codes<std::uint8_t>());
  if (base_type == OIIO::TypeDesc::UINT16) fill_table(all_codes<std::uint16_t>());
}

void SampleConverter::convert(const std::byte* samples, std::size_t count, float* values) const {
  if (base_type_ == OIIO::TypeDesc::UINT8) {
    look_up<std::uint8_t>(table_, samples, count, values);
  } else if (base_type_ == OIIO::TypeDesc::UINT16) {
    look_up<std::uint16_t>(table_, samples, count, values);
  } else {
    convert_without_table(samples, count, values);
  }
}

void SampleConverter::convert_without_table(const std::byte* samples, std::size_t count, float* values) const {
  constexpr std::size_t kCountMax = std::size_t{1} << 30;  // an int there
  const OIIO::TypeDesc type = type_desc(base_type_);
  for (std::size_t i = 0; i < count; i += kCountMax)
    OIIO::convert_pixel_values(type, samples + i * type.size(), OIIO::TypeDesc::FLOAT, values + i,
                               static_cast<int>(std::min(count - i, kCountMax)));
  if (then_) std::transform(values, values + count, values, then_);
}

}  // namespace multum
