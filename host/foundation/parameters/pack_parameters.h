// SPDX-License-Identifier: Apache-2.0
// Lists the parameters of `multum pack` and of jobs of type pack.
#pragma once

#include "host/foundation/parameters/parameter.h"

namespace multum {

const ParameterTable& pack_parameters();

}  // namespace multum
