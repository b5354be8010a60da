// SPDX-License-Identifier: Apache-2.0
// OpenCL status codes as text, and their check. Private to host/formats/opencl.
#pragma once

#include <string>

namespace multum {

/// "CL_OUT_OF_RESOURCES (-5)".
std::string cl_error_name(int status);

/// Throws Error(kEnvironment) "WHAT: CL_..." unless status is CL_SUCCESS.
void check_cl(int status, const std::string& what);

}  // namespace multum
