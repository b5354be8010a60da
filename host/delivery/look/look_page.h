// SPDX-License-Identifier: Apache-2.0
// Writes a page that shows lobes of maps in a browser beside averaged normals, engines' rules and the one-lobe export:
// one HTML file, which opens from disk and needs nothing else.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

constexpr int kLookSideMax = 2048;  // of a map: the browser holds one whole, with averages of its normals as floats
constexpr std::int64_t kLookTexelsMax = std::int64_t{4} * kLookSideMax * kLookSideMax;  // of all maps: 150 MB of page

struct LookMap {
  std::string input;   // *.ndf.exr of vMF lobes
  std::string source;  // the normal map that it was baked from; empty: level 0 of `input`
};

struct LookJob {
  std::vector<LookMap> maps;    // at least one; the page has a list to choose from
  std::string output;           // *.html
  double base_roughness = 0.3;  // perceptual, 0.05..1
  bool same_source = false;     // refuse a source that is not the file that was baked
  int threads = 1;
};

/// Throws Error, Cancelled; leaves no partial file.
void write_look_page(const LookJob& job, Device& device, Progress* progress);

}  // namespace multum
