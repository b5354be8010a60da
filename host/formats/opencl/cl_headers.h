// SPDX-License-Identifier: Apache-2.0
// Includes OpenCL's headers in one place. clhpp owns handles, and cl_error.h checks every status. Private to
// host/formats/opencl.
#pragma once

#define CL_TARGET_OPENCL_VERSION 120
#define CL_HPP_TARGET_OPENCL_VERSION 120
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#define CL_USE_DEPRECATED_OPENCL_1_2_APIS
#include <CL/cl_ext.h>
#include <CL/opencl.hpp>
