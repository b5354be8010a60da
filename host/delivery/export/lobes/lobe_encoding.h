// SPDX-License-Identifier: Apache-2.0
// Encodes the lobes of a level as layers of a lobe texture. Channels are encoded one after the other, each to what
// makes up for those before: first the amplitude a, then x and y of the amplitude that is stored, then s of the spread
// that the lobe shall have with all three as they are stored. So errors of the channels do not add up in the spread,
// which is a small difference of theirs and the highlight's width. Of a channel all lobes are rounded together
// (host/delivery/export/lobes/lobe_rounding.h), so that a texel keeps its sum of amplitudes and its mean normal.
#pragma once

#include <cstdint>
#include <vector>

#include "host/delivery/export/block_encoder.h"
#include "host/delivery/export/lobes/lobe_basis.h"
#include "host/foundation/base/progress.h"

namespace multum {

class LobeEncoder {
 public:
  /// `device` outlives it.
  LobeEncoder(LobeTexels texels, Device& device) : texels_(texels), encoder_(device) {}

  /// What a lobe's layers hold.
  LobeUnpacking unpacking(const LobeBasis& basis) const;
  /// The layers of a level, one behind the other, lobe by lobe. `bases`: a lobe each; `lobes`: of each
  /// width * height of (a r, a). Progress: a unit a texel of a lobe.
  std::vector<std::uint8_t> encode(const std::vector<LobeBasis>& bases, int width, int height,
                                   const std::vector<std::vector<glm::vec4>>& lobes, Progress* progress = nullptr);

 private:
  const LobeTexels texels_;
  BlockEncoder encoder_;
};

}  // namespace multum
