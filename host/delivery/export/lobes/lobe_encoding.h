// SPDX-License-Identifier: Apache-2.0
// Encodes the lobes of a level as layers of a lobe texture. Channels are encoded one after the other, and each
// compensates the errors of the earlier channels. The amplitude a is encoded first. Then x and y are encoded for the
// stored amplitude, and finally s, for the wanted spread with the stored a, x and y. The spread determines the
// highlight's width, but it is a small difference of channels. In this order, the errors of the channels do not add up
// in the spread. All lobes of a channel are rounded together (host/delivery/export/lobes/lobe_rounding.h), so that a
// texel keeps its sum of amplitudes and its mean normal.
#pragma once

#include <cstdint>
#include <vector>

#include "host/delivery/export/block_encoder.h"
#include "host/delivery/export/lobes/lobe_basis.h"
#include "host/foundation/base/progress.h"

namespace multum {

class LobeEncoder {
 public:
  /// `device` must outlive this object.
  LobeEncoder(LobeTexels texels, Device& device) : texels_(texels), encoder_(device) {}

  /// Returns the unpacking of a lobe's layers.
  LobeUnpacking unpacking(const LobeBasis& basis) const;
  /// Returns the layers of a level one after the other, lobe by lobe. `bases` has one entry per lobe. `lobes` has width
  /// * height values (a r, a) per lobe. Progress: one unit per texel and lobe.
  std::vector<std::uint8_t> encode(const std::vector<LobeBasis>& bases, int width, int height,
                                   const std::vector<std::vector<glm::vec4>>& lobes, Progress* progress = nullptr);

 private:
  const LobeTexels texels_;
  BlockEncoder encoder_;
};

}  // namespace multum
