// SPDX-License-Identifier: Apache-2.0
// Defines contexts with several small indices: ContextTable<2, 3> has contexts [0..1][0..2].
#pragma once

#include <array>
#include <cstddef>

#include "host/fields/codec/decoder/adaptive_bit.h"

namespace multum {

template <std::size_t... kSizes>
struct ContextTable;
template <std::size_t kSize>
struct ContextTable<kSize> : std::array<AdaptiveBit, kSize> {};
template <std::size_t kSize, std::size_t... kSizes>
struct ContextTable<kSize, kSizes...> : std::array<ContextTable<kSizes...>, kSize> {};

}  // namespace multum
