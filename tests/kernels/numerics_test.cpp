// SPDX-License-Identifier: Apache-2.0
// Compares the kernels' own exp2, log2 and inverse of A(kappa) with double precision. Tests the structs that host and
// device share, and the guards that relaxed mathematics would delete.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "host/lab/selftest/struct_layout.h"
#include "tests/kernels/em_harness.h"

namespace multum::testing {
namespace {

enum Function { kExp2 = 0, kLog2 = 1, kKappa = 2, kIsNan = 3 };

std::vector<float> evaluate(const std::vector<float>& inputs, Function function) {
  Device& device = test_device();
  const DeviceBuffer in = device.wrap_buffer(inputs.data(), inputs.size() * sizeof(float), "inputs");
  const DeviceBuffer out = device.make_buffer(inputs.size() * sizeof(float), "values");
  device.kernel("probe_numerics", "probe_functions", {4, 1, false})
      .launch({inputs.size()}, in, out, static_cast<int>(inputs.size()), static_cast<int>(function));
  std::vector<float> values(inputs.size());
  device.read(out, values.data(), values.size() * sizeof(float));
  return values;
}

TEST(NumericsTest, Exp2) {
  std::vector<float> inputs;
  for (float x = -126.0f; x <= 20.0f; x += 0.00713f) inputs.push_back(x);
  const auto values = evaluate(inputs, kExp2);
  for (std::size_t i = 0; i < inputs.size(); ++i)
    ASSERT_NEAR(static_cast<double>(values[i]) / std::exp2(static_cast<double>(inputs[i])), 1.0, 3.5e-7) << inputs[i];
}

TEST(NumericsTest, Exp2OfHugeNegativesIsTinyNotDenormal) {
  for (float value : evaluate({-126.5f, -200.0f, -1e6f, -1e30f}, kExp2)) {
    EXPECT_GE(value, std::numeric_limits<float>::min() * 0.99f);
    EXPECT_LT(value, 2e-38f);
  }
}

TEST(NumericsTest, Log2) {
  std::vector<float> inputs;
  for (float x = 1.2e-38f; x < 3e38f; x *= 1.00731f) inputs.push_back(x);
  const auto values = evaluate(inputs, kLog2);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const double exact = std::log2(static_cast<double>(inputs[i]));
    ASSERT_NEAR(static_cast<double>(values[i]), exact, 5e-7 + 6e-8 * std::abs(exact)) << inputs[i];
  }
}

// For kappa from 0.003 (spread 0.999) to 1e6, the error is at most 4e-5 of kappa. Banerjee's formula has errors of up
// to several per cent.
TEST(NumericsTest, KappaOfMeanLength) {
  std::vector<float> spreads;
  for (double spread = 1e-6; spread < 0.999; spread *= 1.0117) spreads.push_back(static_cast<float>(spread));
  for (double r = 0.5; r > 1e-3; r *= 0.97) spreads.push_back(static_cast<float>(1.0 - r));
  const auto values = evaluate(spreads, kKappa);
  for (std::size_t i = 0; i < spreads.size(); ++i) {
    // The kernel sees r = 1 - spread rounded to float, so the expected value uses the same r.
    const auto spread = static_cast<double>(spreads[i]);
    const double exact = spread < 0.05 ? 1.0 / spread : reference::kappa_of_mean_length(1.0 - spread);
    ASSERT_NEAR(static_cast<double>(values[i]) / exact, 1.0, 4e-5) << "spread " << spread;
  }
}

TEST(NumericsTest, DriverKeepsNanGuards) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto values = evaluate({nan, 1.0f, -nan, std::numeric_limits<float>::infinity()}, kIsNan);
  EXPECT_EQ(values, (std::vector<float>{1.0f, 0.0f, 1.0f, 0.0f}));
}

TEST(SharedStructTest, DeviceAgreesOnSizesAndOffsets) {
  const StructLayout layout = struct_layout(test_device());
  EXPECT_EQ(layout.device, layout.host);
}

}  // namespace
}  // namespace multum::testing
