// SPDX-License-Identifier: Apache-2.0
// Identifies an image of a packed field.
#pragma once

#include <compare>
#include <cstddef>

namespace multum {

struct ImageKey {
  std::size_t chunk = 0;  // index in the order of layers, then blocks
  // The index in the chunk's plan. Numbers after the last image stand for samples, and mean the sum of a sample's
  // images.
  std::size_t image = 0;

  auto operator<=>(const ImageKey&) const = default;
};

}  // namespace multum
