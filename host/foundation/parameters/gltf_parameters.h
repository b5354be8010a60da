// SPDX-License-Identifier: Apache-2.0
// Lists the parameters of `multum gltf`.
#pragma once

#include "host/foundation/parameters/parameter.h"

namespace multum {

const ParameterTable& gltf_parameters();

}  // namespace multum
