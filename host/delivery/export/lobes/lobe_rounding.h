// SPDX-License-Identifier: Apache-2.0
// Rounds a channel of all lobes of some rows to what a lobe texture can store, all lobes together: of a texel each lobe
// takes the storable value below or above the one that is wanted, in the combination of the least error of the values
// and of their sum. Rounded one by one, errors of the lobes would add up in what they have in common: the sum of
// amplitudes and the mean normal.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "host/delivery/export/block_encoder.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

/// A channel of a lobe: texels store low + range * c + offset, c from 0 to 1.
struct RoundedChannel {
  float low = 0.0f, range = 1.0f;
  std::vector<float> offset;  // by texel; empty: 0
  std::vector<float> weight;  // by texel, of an error's square
  std::vector<float> wanted;  // by texel; replaced by what is stored
};

/// Rows of a level, all lobes and channels.
class LobeRounding {
 public:
  virtual ~LobeRounding() = default;
  /// Rounds `channel` of all lobes. `sums`: of the lobes' values, by texel, as they should be; `sum_weight`: what an
  /// error of the sum weighs, of those of a lobe.
  virtual void round(int channel, std::vector<RoundedChannel>& lobes, const std::vector<float>& sums,
                     float sum_weight) = 0;
  /// Rows of a lobe's layer as they are stored.
  virtual const std::vector<std::uint8_t>& layer(int lobe, int layer) const = 0;
};

/// Of `row_count` rows, a multiple of 4 but for a level's last. `encoder` outlives it.
std::unique_ptr<LobeRounding> make_lobe_rounding(LobeTexels texels, BlockEncoder& encoder, int lobe_count, int width,
                                                 int row_count);

}  // namespace multum
