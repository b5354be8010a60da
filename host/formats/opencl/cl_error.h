// SPDX-License-Identifier: Apache-2.0
// Converts OpenCL status codes to text and checks them. Private to host/formats/opencl.
#pragma once

#include <string>

namespace multum {

/// Returns, for example, "CL_OUT_OF_RESOURCES (-5)".
std::string cl_error_name(int status);

/// Throws Error(kEnvironment) with the message "WHAT: CL_..." unless status is CL_SUCCESS.
void check_cl(int status, const std::string& what);

}  // namespace multum
