// SPDX-License-Identifier: Apache-2.0
// Writes a page that shows a map's lobes in a browser beside averaged normals, engines' rules and the one-lobe export:
// one HTML file, which opens from disk and needs nothing else.
#pragma once

#include <string>

#include "host/base/progress.h"
#include "host/opencl/device.h"

namespace multum {

constexpr int kLookSideMax = 2048;  // of the map: a page of 4096 x 4096 would be 150 MB

struct LookJob {
  std::string input;            // *.ndf.exr of vMF lobes
  std::string source;           // the normal map that it was baked from
  std::string output;           // *.html
  double base_roughness = 0.3;  // perceptual, 0.05..1
  bool same_source = false;     // refuse a source that is not the file that was baked
  int threads = 1;
};

/// Throws Error, Cancelled; leaves no partial file.
void write_look_page(const LookJob& job, Device& device, Progress* progress);

}  // namespace multum
