// SPDX-License-Identifier: Apache-2.0
// Includes OpenCL's headers, once for all. Private to host/formats/opencl.
#pragma once

#define CL_TARGET_OPENCL_VERSION 120
#define CL_USE_DEPRECATED_OPENCL_1_2_APIS
#include <CL/cl.h>
#include <CL/cl_ext.h>
