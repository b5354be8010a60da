// SPDX-License-Identifier: Apache-2.0
// Tests which versions of PoCL must compile kernels differently from their default.
#include "host/formats/opencl/pocl_settings.h"

#include <gtest/gtest.h>

namespace multum {
namespace {

constexpr const char* kTrixie = "OpenCL 3.0 PoCL 6.0+debian  Linux, None+Asserts, RELOC, SPIR-V, LLVM 18.1.8, SLEEF";
constexpr const char* kBookworm = "OpenCL 3.0 PoCL 3.1+debian  Linux, None+Asserts, RELOC, SPIR, LLVM 15.0.6, SLEEF";

TEST(PoclSettingsTest, OnlyLoopsBehindLlvm18MayAbort) {
  EXPECT_TRUE(pocl_loops_may_abort(kTrixie));
  EXPECT_FALSE(pocl_loops_may_abort(kBookworm));
  EXPECT_FALSE(pocl_loops_may_abort("OpenCL 3.0 CUDA 12.4.0"));
  EXPECT_FALSE(pocl_loops_may_abort("OpenCL 3.0 LINUX, LLVM 18.1.8"));  // another vendor's device
}

}  // namespace
}  // namespace multum
