// SPDX-License-Identifier: Apache-2.0
// Shares the steps of rounding between both families of lobes: amplitudes that sum to 1, colours, rows by bands. For
// host/formats/asset alone.
#pragma once

#include <cstddef>

#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

constexpr int kSnormSteps = 32767;
/// Times this is the same float as a division gives, for every step (QuantizeStepsTest): k/32767 repeats its 15 bits
/// for ever, so that no quotient lies near the middle of two floats.
constexpr double kSnormStep = 1.0 / kSnormSteps;

/// Texels that are rounded at once.
constexpr std::size_t kRoundingBlock = 256;
/// Rounds one lobe of `count` texels, whose amplitudes have been rounded to `amplitudes`.
using RoundLobes = void (*)(glm::vec4* lobes, const double* amplitudes, std::size_t count, StorageEncoding encoding);

/// Amplitudes first (snorm16: whole steps that sum to 32767), then each lobe by `round`, then colours and weights to
/// halfs. kFloat: nothing is rounded.
void round_rows(MovmfLevel& rows, StorageEncoding encoding, int threads, RoundLobes round);

/// Counts lobes for which `is_sharp(lobe)`, of an amplitude that any encoding stores.
SharpLobes count_lobes(const MovmfLevel& level, int threads, bool (*is_sharp)(const glm::vec4& lobe, double spread_min),
                       double spread_min);

}  // namespace multum
