// SPDX-License-Identifier: Apache-2.0
// Tests that numbers of every type are converted to the same floats as in OpenImageIO, bit for bit.
#include "host/formats/image/sample_converter.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>

#include "host/formats/image/files/number_type.h"

namespace multum::testing {
namespace {

OIIO::TypeDesc type_desc(int code) { return OIIO::TypeDesc(static_cast<OIIO::TypeDesc::BASETYPE>(code)); }

class SampleConverterTest : public ::testing::TestWithParam<int> {
 protected:
  /// Returns random bytes. For 8 and 16 bits, returns every code.
  std::vector<std::byte> samples() const {
    const std::size_t bytes = number_bytes(GetParam());
    const std::size_t count = bytes > 2 ? 20000 : std::size_t{1} << (8 * bytes);
    std::vector<std::byte> samples(count * bytes);
    std::mt19937_64 random(20261123);
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint64_t number = bytes > 2 ? random() : i;
      std::memcpy(samples.data() + i * bytes, &number, bytes);
    }
    return samples;
  }
};

TEST_P(SampleConverterTest, IsOpenImageIosConversion) {
  EXPECT_EQ(number_bytes(GetParam()), type_desc(GetParam()).size());
  EXPECT_EQ(std::string(number_name(GetParam())), type_desc(GetParam()).c_str());
  const std::vector<std::byte> codes = samples();
  const std::size_t count = codes.size() / number_bytes(GetParam());
  std::vector<float> ours(count, -7.0f), theirs(count, -8.0f);
  SampleConverter(GetParam()).convert(codes.data(), count, ours.data());
  ASSERT_TRUE(OIIO::convert_pixel_values(type_desc(GetParam()), codes.data(), OIIO::TypeDesc::FLOAT, theirs.data(),
                                         static_cast<int>(count)));
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (std::isnan(ours[i]) && std::isnan(theirs[i])) continue;  // any NaN is right
    if (std::bit_cast<std::uint32_t>(ours[i]) == std::bit_cast<std::uint32_t>(theirs[i])) continue;
    if (++wrong < 5) ADD_FAILURE() << "sample " << i << ": " << ours[i] << ", expected " << theirs[i];
  }
  EXPECT_EQ(wrong, 0u);
}

INSTANTIATE_TEST_SUITE_P(Types, SampleConverterTest, ::testing::Range(number_type::kUint8, number_type::kDouble + 1),
                         [](const ::testing::TestParamInfo<int>& type) { return number_name(type.param); });

TEST(NumberTypeTest, OtherCodesAreNone) {
  for (const int code : {-1, 0, 1, 13, 1000}) {
    EXPECT_FALSE(is_number_type(code));
    EXPECT_EQ(number_bytes(code), 0u);
    EXPECT_STREQ(number_name(code), "unknown");
  }
}

}  // namespace
}  // namespace multum::testing
