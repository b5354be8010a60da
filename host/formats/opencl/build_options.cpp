// SPDX-License-Identifier: Apache-2.0
#include "host/formats/opencl/build_options.h"

#include <fmt/format.h>

#include "host/foundation/base/error.h"

namespace multum {

std::string build_options(const KernelVariant& variant, bool rounds_when_asked) {
  MULTUM_CHECK(variant.lobes >= 1 && variant.lobes <= 9);  // up to 8 in a file, and one more for the normal map
  MULTUM_CHECK(variant.vector_width == 1 || variant.vector_width == 16);
  MULTUM_CHECK(variant.sh_order >= 0 && variant.sh_order <= 20);
  const std::string sh = variant.sh_order > 0 ? fmt::format(" -DMULTUM_SH_ORDER={}", variant.sh_order) : "";
  return fmt::format("-cl-std=CL1.2 -DMULTUM_LOBES={} -DMULTUM_VECTOR_WIDTH={} -DMULTUM_WEIGHTED={}{}{}{}",
                     variant.lobes, variant.vector_width, variant.weighted ? 1 : 0,
                     variant.planar ? " -DMULTUM_PLANAR=1" : "", sh,
                     rounds_when_asked ? " -cl-fp32-correctly-rounded-divide-sqrt" : "");
}

}  // namespace multum
