// SPDX-License-Identifier: Apache-2.0
// Tests properties of the kernels of texture inference; numerical_property_test.cpp tests the kernels of bakes.
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <vector>

#include "host/fields/inference/solver/texture_system.h"
#include "tests/fixtures/test_device.h"
#include "tests/hard_cases/random_values.h"

namespace multum {
namespace {

using testing::decades;
using testing::test_device;

// Rows have any length and may be empty. Weights have either sign, and their magnitudes cover twelve decades.
RC_GTEST_PROP(InferenceProperty, ProductsAreSums, ()) {
  SparseRows rows;
  const auto lengths = *rc::gen::nonEmpty(rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 20)));
  for (const int length : lengths) {
    for (int i = 0; i < length; ++i) {
      rows.columns.push_back(*rc::gen::inRange(0u, 30u));
      rows.weights.push_back(static_cast<float>(*decades(-6, 6)) * *rc::gen::element(1.0f, -1.0f));
    }
    rows.begin.push_back(static_cast<std::uint32_t>(rows.columns.size()));
  }
  std::vector<Colour4> x(30), y(lengths.size(), Colour4{NAN, NAN, NAN, NAN});
  for (Colour4& value : x) value = {static_cast<float>(*decades(-6, 0)), 1.0f, -0.0f, 0.0f};
  Device& device = test_device();
  const DeviceRows on_device(device, rows, "rows");
  const DeviceBuffer in = device.wrap_buffer(x.data(), x.size() * sizeof(Colour4), "x");
  DeviceBuffer out = device.make_buffer(y.size() * sizeof(Colour4), "y");
  device.write(out, y.data(), out.byte_count());
  Kernel kernel = device.kernel("filter_matrix_spmv", "filter_matrix_spmv", {1, 1, false});
  on_device.multiply(kernel, in, out);
  device.read(out, y.data(), out.byte_count());
  for (std::size_t r = 0; r < y.size(); ++r)
    for (std::size_t c = 0; c < 3; ++c) {
      double sum = 0.0, magnitude = 0.0;
      for (std::uint32_t i = rows.begin[r]; i < rows.begin[r + 1]; ++i) {
        const double product = static_cast<double>(rows.weights[i]) * static_cast<double>(x[rows.columns[i]][c]);
        sum += product;
        magnitude += std::abs(product);
      }
      RC_ASSERT(std::abs(static_cast<double>(y[r][c]) - sum) <= 1e-6 * magnitude);
    }
}

}  // namespace
}  // namespace multum
