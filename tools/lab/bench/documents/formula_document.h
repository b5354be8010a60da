// SPDX-License-Identifier: Apache-2.0
// Writes the section of docs/evidence/ACCURACY.md about the shading formulas. Each formula is compared with quadrature
// in double precision, for a distribution that has exactly the shape that the formula assumes.
#pragma once

#include <string>

#include "host/formats/opencl/device.h"

namespace multum::bench {

/// Returns Markdown. `brdfs` is a folder of measured BRDFs, or empty.
std::string formula_section(Device& device, const std::string& brdfs);

}  // namespace multum::bench
