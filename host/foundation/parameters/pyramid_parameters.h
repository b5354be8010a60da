// SPDX-License-Identifier: Apache-2.0
// Lists the parameters of `multum mip`, `reflectance` and `lod`.
#pragma once

#include "host/foundation/parameters/parameter.h"

namespace multum {

const ParameterTable& mip_parameters();
const ParameterTable& reflectance_parameters();
const ParameterTable& lod_parameters();

}  // namespace multum
