// SPDX-License-Identifier: Apache-2.0
// The section of docs/evidence/ACCURACY.md on the shading formulas alone: each against quadrature in double, on a
// distribution of just the shape that its representation takes normals to have, so that nothing else is off.
#pragma once

#include <string>

#include "host/formats/opencl/device.h"

namespace multum::bench {

/// Markdown. `brdfs`: folder of measured BRDFs; empty: none.
std::string formula_section(Device& device, const std::string& brdfs);

}  // namespace multum::bench
