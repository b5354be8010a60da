// SPDX-License-Identifier: Apache-2.0
// Converts counts to sizes. Sizes are used because a product of counts can exceed the range of int.
#pragma once

#include <cstddef>

namespace multum {

inline std::size_t size_of(int count) { return static_cast<std::size_t>(count); }

}  // namespace multum
