// SPDX-License-Identifier: Apache-2.0
// Lists the parts of the registry. Each part covers one family of kernels. Private to host/lab/selftest.
#pragma once

#include <vector>

#include "host/lab/selftest/selftest.h"

namespace multum {

std::vector<NumericalCase> numerics_cases();  // kernels/device: exponentials, logarithms, inverses of A(kappa)
std::vector<NumericalCase> em_cases();        // movmf_em_texels
std::vector<NumericalCase> choose_cases();    // movmf_choose
std::vector<NumericalCase> refine_cases();    // movmf_refine
std::vector<NumericalCase> planar_cases();    // the EM kernels and rounding for planar Gaussians
std::vector<NumericalCase> level_cases();     // movmf_start, movmf_pack, movmf_level_zero
std::vector<NumericalCase> sum_cases();       // movmf_em_chunks, movmf_em_mstep, movmf_features, movmf_binning
std::vector<NumericalCase> shading_cases();   // movmf_shade
std::vector<NumericalCase> sh_cases();        // sh_project, sh_shade
std::vector<NumericalCase> pyramid_cases();   // mip_box, reflectance_pyramid
std::vector<NumericalCase> moment_cases();    // moments, moment_shade
std::vector<NumericalCase> one_lobe_cases();  // one_lobe
std::vector<NumericalCase> plane_cases();     // plane_picture
std::vector<NumericalCase> block_cases();     // block_encoding
std::vector<NumericalCase>
storage_cases();  // host/formats/asset/lobes/movmf_quantize, which rounds the results of kernels

}  // namespace multum
