// SPDX-License-Identifier: Apache-2.0
#include "host/movmf/movmf_inputs.h"

#include "host/movmf/mip_schedule.h"

namespace multum {

std::uint64_t movmf_bake_units(int width, int height, int first_level) {
  return static_cast<std::uint64_t>(mip_level_count(width, height) - first_level) * static_cast<std::uint64_t>(width) *
         static_cast<std::uint64_t>(height);
}

}  // namespace multum
