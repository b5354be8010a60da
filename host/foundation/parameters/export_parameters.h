// SPDX-License-Identifier: Apache-2.0
// Lists the parameters of `multum export`.
#pragma once

#include "host/foundation/parameters/parameter.h"

namespace multum {

const ParameterTable& export_parameters();

}  // namespace multum
