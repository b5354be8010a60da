// SPDX-License-Identifier: Apache-2.0
#include "host/bake/ndf_bake.h"

#include "host/base/error.h"

namespace multum {

const NdfBake& ndf_bake(Representation representation) {
  for (const NdfBake* one : {&kMovmfBake, &kGmmBake, &kMomentBake, &kShBake})
    if (one->representation == representation) return *one;
  MULTUM_CHECK(false);
  return kMovmfBake;
}

}  // namespace multum
