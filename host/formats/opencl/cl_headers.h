// SPDX-License-Identifier: Apache-2.0
// Includes OpenCL's headers, once for all: handles are clhpp's, and every status is checked (cl_error.h). Private to
// host/formats/opencl.
#pragma once

#define CL_TARGET_OPENCL_VERSION 120
#define CL_HPP_TARGET_OPENCL_VERSION 120
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#define CL_USE_DEPRECATED_OPENCL_1_2_APIS
#include <CL/cl_ext.h>
#include <CL/opencl.hpp>
