// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/lobes/lobe_rounding.h"

#include <half.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/vector_clones.h"

namespace multum {
namespace {

using Block = std::array<double, kRoundingBlock>;

// The smallest amplitude that snorm16 stores. The spread of a lobe with a smaller amplitude is invisible.
constexpr float kAmplitudeMin = static_cast<float>(kSnormStep);

// Step 1 for snorm16: amplitudes become whole numbers of steps that sum to 32767. The largest remainders are rounded
// up. In a tie, the amplitude of the lobe with the lower index is rounded up. Amplitudes that do not sum to 1 remain
// unchanged, so that verify_movmf() reports them.
MULTUM_VECTOR_CLONES
void round_amplitudes_snorm(const MovmfLevel& level, std::size_t first, std::size_t count,
                            std::array<Block, kLobeCountMax>& amplitudes) {
  const std::size_t lobe_count = level.lobes.size();
  std::array<Block, kLobeCountMax> remainders;
  Block total{}, missing;
  for (std::size_t j = 0; j < lobe_count; ++j)
    for (std::size_t i = 0; i < count; ++i) {
      amplitudes[j][i] = static_cast<double>(level.lobes[j][first + i].w);
      total[i] += amplitudes[j][i] >= 0.0 ? amplitudes[j][i] : HUGE_VAL;
    }
  for (std::size_t i = 0; i < count; ++i) {
    total[i] = total[i] < HUGE_VAL ? total[i] : 0.0;
    missing[i] = total[i] > 0.0 ? double{kSnormSteps} : 0.0;
  }
  for (std::size_t j = 0; j < lobe_count; ++j)
    for (std::size_t i = 0; i < count; ++i) {
      const double divisor = total[i] > 0.0 ? total[i] : HUGE_VAL;
      const double exact = amplitudes[j][i] / divisor * double{kSnormSteps};
      const double steps = static_cast<double>(static_cast<int>(exact));
      remainders[j][i] = exact - steps;
      amplitudes[j][i] = total[i] > 0.0 ? steps : amplitudes[j][i];
      missing[i] -= steps;
    }
  for (std::size_t i = 0; i < count; ++i)
    for (double left = missing[i]; left > 0.0; left -= 1.0) {
      std::size_t largest = 0;
      for (std::size_t j = 1; j < lobe_count; ++j) largest = remainders[j][i] > remainders[largest][i] ? j : largest;
      amplitudes[largest][i] += 1.0;
      remainders[largest][i] = -1.0;
    }
  for (std::size_t j = 0; j < lobe_count; ++j)
    for (std::size_t i = 0; i < count; ++i) {
      const double rounded = static_cast<double>(static_cast<float>(amplitudes[j][i] * kSnormStep));
      amplitudes[j][i] = total[i] > 0.0 ? rounded : amplitudes[j][i];
    }
}

void round_amplitudes_half(const MovmfLevel& level, std::size_t first, std::size_t count,
                           std::array<Block, kLobeCountMax>& amplitudes) {
  for (std::size_t j = 0; j < level.lobes.size(); ++j)
    for (std::size_t i = 0; i < count; ++i)
      amplitudes[j][i] = static_cast<double>(static_cast<float>(half(level.lobes[j][first + i].w)));
}

void round_features(MovmfLevel& level, std::size_t first, std::size_t count) {
  for (std::vector<glm::vec3>& colours : level.colours)
    for (std::size_t i = first; i < first + count; ++i)
      for (int c = 0; c < 3; ++c) colours[i][c] = static_cast<float>(half(colours[i][c]));
  const std::size_t texels = static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height);
  for (std::vector<float>& weights : level.weights)
    for (std::size_t i = first * weights.size() / texels; i < (first + count) * weights.size() / texels; ++i)
      weights[i] = static_cast<float>(half(weights[i]));
}

}  // namespace

void round_rows(MovmfLevel& rows, StorageEncoding encoding, int threads, RoundLobes round) {
  MULTUM_CHECK(rows.lobes.size() <= kLobeCountMax);
  if (encoding == StorageEncoding::kFloat) return;
  const auto width = static_cast<std::size_t>(rows.width);
  for_each_row_band(rows.height, kRowsPerBand, threads, [&](int, int row_begin, int row_end) {
    const std::size_t end = static_cast<std::size_t>(row_end) * width;
    for (std::size_t first = static_cast<std::size_t>(row_begin) * width; first < end; first += kRoundingBlock) {
      const std::size_t count = std::min(kRoundingBlock, end - first);
      std::array<Block, kLobeCountMax> amplitudes;
      if (encoding == StorageEncoding::kSnorm16) round_amplitudes_snorm(rows, first, count, amplitudes);
      else round_amplitudes_half(rows, first, count, amplitudes);
      for (std::size_t j = 0; j < rows.lobes.size(); ++j)
        round(rows.lobes[j].data() + first, amplitudes[j].data(), count, encoding);
      round_features(rows, first, count);
    }
  });
}

SharpLobes count_lobes(const MovmfLevel& level, int threads, bool (*is_sharp)(const glm::vec4& lobe, double spread_min),
                       double spread_min) {
  std::vector<SharpLobes> rows(static_cast<std::size_t>(level.height));
  const auto width = static_cast<std::size_t>(level.width);
  for_each_item(level.height, threads, [&](int y) {
    const std::size_t first = static_cast<std::size_t>(y) * width;
    SharpLobes& row = rows[static_cast<std::size_t>(y)];
    for (const std::vector<glm::vec4>& lobes : level.lobes)
      for (std::size_t i = first; i < first + width; ++i) {
        if (lobes[i].w < kAmplitudeMin || !is_sharp(lobes[i], spread_min)) continue;
        ++row.count;
        row.amplitude += static_cast<double>(lobes[i].w);
      }
  });
  SharpLobes all;
  for (const SharpLobes& row : rows) {
    all.count += row.count;
    all.amplitude += row.amplitude;
  }
  return all;
}

}  // namespace multum
