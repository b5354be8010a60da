// SPDX-License-Identifier: Apache-2.0
// Makes all options for the OpenCL compiler. No option relaxes mathematics. On PoCL, -cl-fast-relaxed-math and
// -cl-finite-math-only delete the guards in the kernels without making the kernels faster.
#pragma once

#include <string>

namespace multum {

/// Structural choices that are compiled into a kernel.
struct KernelVariant {
  int lobes = 4;          // 1 to 8
  int vector_width = 1;   // 1 for scalars, one work-item per texel (GPUs); 16 for float16 (CPUs)
  bool weighted = false;  // true if sides are not powers of two, so that texels cover fractions of texels of level 0
  bool planar = false;    // true if lobes are planar Gaussians (kernels/device/planar_family.clh)
  int sh_order = 0;       // order of spherical harmonics, 1..20; 0 for a kernel without harmonics
};

/// `rounds_when_asked` is true if the device rounds divisions and square roots correctly (IEEE 754) only in programs
/// built with the option that requests it.
std::string build_options(const KernelVariant& variant, bool rounds_when_asked);

}  // namespace multum
