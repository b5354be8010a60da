// SPDX-License-Identifier: Apache-2.0
// Makes the OpenCL compiler's options, all of them. Nothing here relaxes mathematics: -cl-fast-relaxed-math and
// -cl-finite-math-only delete the kernels' guards on PoCL and gain nothing.
#pragma once

#include <string>

namespace multum {

/// Structural choices that are compiled into a kernel.
struct KernelVariant {
  int lobes = 4;          // 1..8
  int vector_width = 1;   // 1: scalar, one work-item a texel (GPUs); 16: float16 (CPUs)
  bool weighted = false;  // texels cover fractions of finest texels: the map's sides are no powers of two
  bool planar = false;    // lobes are planar Gaussians (kernels/device/planar_family.clh)
  int sh_order = 0;       // of spherical harmonics, 1..20; 0: a kernel without any
};

/// `rounds_when_asked`: the device divides and takes roots as IEEE says only in programs that are built so.
std::string build_options(const KernelVariant& variant, bool rounds_when_asked);

}  // namespace multum
