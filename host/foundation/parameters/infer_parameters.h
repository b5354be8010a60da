// SPDX-License-Identifier: Apache-2.0
// Lists the parameters of `multum infer` and of jobs of type infer.
#pragma once

#include "host/foundation/parameters/parameter.h"

namespace multum {

const ParameterTable& infer_parameters();

}  // namespace multum
