// SPDX-License-Identifier: Apache-2.0
// Names an image of a packed field.
#pragma once

#include <compare>
#include <cstddef>

namespace multum {

struct ImageKey {
  std::size_t chunk = 0;  // in the order of layers, then blocks
  std::size_t image = 0;  // of the chunk's plan; behind its images stands, for each sample, the sum of the sample's

  auto operator<=>(const ImageKey&) const = default;
};

}  // namespace multum
