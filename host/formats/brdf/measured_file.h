// SPDX-License-Identifier: Apache-2.0
// Reads measured BRDFs from files, as factors. The contents of a file show which of three formats it has:
//   text      .brdf of pbrt-v2: a count of wavelengths, the wavelengths (nm), then samples: theta_i phi_i theta_s phi_s
//             (radians) and one value per wavelength; # begins a comment
//   MERL      binary (Matusik et al. 2003): int32 90, 90, 180, then doubles of red, green, blue over theta_h
//             (sqrt-spaced), theta_d, phi_d; times 1/1500, 1.15/1500, 1.66/1500; negative: not measured
//   network   JSON of a fit: layers of {kernel, bias}, 6 -> n -> n -> 3, ReLU between them, exp(x) - 1 at the end
#pragma once

#include <string>

#include "host/formats/brdf/measured_brdf.h"

namespace multum {

/// Reads a file. Throws Error(kInput), which names the file, what was found and what was expected.
MeasuredBrdf read_measured_brdf(const std::string& path);

}  // namespace multum
