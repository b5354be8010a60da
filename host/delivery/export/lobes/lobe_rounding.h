// SPDX-License-Identifier: Apache-2.0
// Rounds a channel of all lobes of some rows to values that a lobe texture can store. The lobes of a texel are rounded
// together. For each lobe, either the next lower or the next higher value that can be stored is used. The combination
// with the lowest error of the values and of their sum is chosen. If lobes were rounded separately, their errors would
// add up in the sum of amplitudes and in the mean normal.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "host/delivery/export/block_encoder.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

/// A channel of a lobe. Texels store c from 0 to 1, which represents the value low + range * c + offset.
struct RoundedChannel {
  float low = 0.0f, range = 1.0f;
  std::vector<float> offset;  // offsets by texel; 0 if empty
  std::vector<float> weight;  // weights of squared errors, by texel
  std::vector<float> wanted;  // wanted values by texel; replaced by the stored values
};

/// Rounds rows of a level, for all lobes and channels.
class LobeRounding {
 public:
  virtual ~LobeRounding() = default;
  /// Rounds `channel` of all lobes. `sums` are the exact sums of the lobes' values, by texel. `sum_weight` is the
  /// weight of an error of the sum, relative to errors of the lobes.
  virtual void round(int channel, std::vector<RoundedChannel>& lobes, const std::vector<float>& sums,
                     float sum_weight) = 0;
  /// Returns the stored rows of a lobe's layer.
  virtual const std::vector<std::uint8_t>& layer(int lobe, int layer) const = 0;
};

/// Rounds `row_count` rows, a multiple of 4 except for the last rows of a level. `encoder` must outlive the result.
std::unique_ptr<LobeRounding> make_lobe_rounding(LobeTexels texels, BlockEncoder& encoder, int lobe_count, int width,
                                                 int row_count);

}  // namespace multum
