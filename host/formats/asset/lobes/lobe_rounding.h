// SPDX-License-Identifier: Apache-2.0
// Rounding that both families of lobes share: amplitudes that sum to 1, colours, and bands of rows. Only
// host/formats/asset uses this file.
#pragma once

#include <cstddef>

#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

constexpr int kSnormSteps = 32767;
/// For every step, multiplication by this constant gives the same float as division by 32767 (QuantizeStepsTest). The
/// binary digits of k/32767 repeat every 15 bits, so no quotient is close to the midpoint of two floats.
constexpr double kSnormStep = 1.0 / kSnormSteps;

/// The number of texels that are rounded at once.
constexpr std::size_t kRoundingBlock = 256;
/// Rounds one lobe of `count` texels. `amplitudes` holds the amplitudes, which are already rounded.
using RoundLobes = void (*)(glm::vec4* lobes, const double* amplitudes, std::size_t count, StorageEncoding encoding);

/// Rounds the amplitudes first (for snorm16, to whole numbers of steps that sum to 32767), then each lobe with `round`,
/// then colours and weights to 16-bit floats. kFloat rounds nothing.
void round_rows(MovmfLevel& rows, StorageEncoding encoding, int threads, RoundLobes round);

/// Counts the lobes for which `is_sharp(lobe)` is true and whose amplitude every encoding can store.
SharpLobes count_lobes(const MovmfLevel& level, int threads, bool (*is_sharp)(const glm::vec4& lobe, double spread_min),
                       double spread_min);

}  // namespace multum
