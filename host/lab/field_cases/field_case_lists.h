// SPDX-License-Identifier: Apache-2.0
// Declares one function per family of kernels. Each function lists the cases of its family in this folder.
#pragma once

#include <vector>

#include "host/lab/selftest/selftest.h"

namespace multum {

std::vector<NumericalCase> inference_cases();  // filter_matrix_spmv, pyramidal_regularization, conjugate_gradient
std::vector<NumericalCase> transform_cases();  // image_transform

}  // namespace multum
