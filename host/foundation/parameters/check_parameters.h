// SPDX-License-Identifier: Apache-2.0
// Lists the parameters of `multum check`.
#pragma once

#include "host/foundation/parameters/parameter.h"

namespace multum {

const ParameterTable& check_parameters();

}  // namespace multum
