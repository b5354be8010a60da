// SPDX-License-Identifier: Apache-2.0
// Tests that planes in memory and in a scratch file read back row by row unchanged.
#include "host/formats/image/plane_store.h"

#include <gtest/gtest.h>

#include <numeric>

#include "host/foundation/base/error.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

constexpr int kWidth = 7, kHeight = 5;

std::array<std::vector<float>, 3> counted_planes() {
  std::array<std::vector<float>, 3> planes;
  float first = 0.0f;
  for (std::vector<float>& plane : planes) {
    plane.resize(kWidth * kHeight);
    std::iota(plane.begin(), plane.end(), first += 1000.0f);
  }
  return planes;
}

void expect_rows_come_back(PlaneStore& store) {
  const auto planes = counted_planes();
  for (int row = kHeight - 1; row >= 0; row -= 2) {  // upwards, two rows at a time, then a single row
    const int first = row > 0 ? row - 1 : 0;
    const std::size_t offset = static_cast<std::size_t>(first * kWidth);
    store.write_rows(first, row - first + 1, {&planes[0][offset], &planes[1][offset], &planes[2][offset]});
  }
  std::vector<float> x(3 * kWidth), y(3 * kWidth), z(3 * kWidth);
  store.read_rows(1, 3, {x.data(), y.data(), z.data()});
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_EQ(x[i], planes[0][kWidth + i]);
    EXPECT_EQ(y[i], planes[1][kWidth + i]);
    EXPECT_EQ(z[i], planes[2][kWidth + i]);
  }
}

TEST(PlaneStoreTest, RowsComeBackFromMemory) {
  PlaneStore store(kWidth, kHeight);
  expect_rows_come_back(store);
}

TEST(PlaneStoreTest, RowsComeBackFromAScratchFileThatNobodySees) {
  const testing::TemporaryFolder folder;
  PlaneStore store(kWidth, kHeight, folder.path());
  expect_rows_come_back(store);
  EXPECT_TRUE(folder.names().empty());
}

TEST(PlaneStoreTest, AFolderThatIsNotThereIsNamed) {
  testing::expect_error(ErrorCode::kEnvironment, {"/no/such/folder"},
                        [] { PlaneStore(kWidth, kHeight, "/no/such/folder"); });
}

}  // namespace
}  // namespace multum
