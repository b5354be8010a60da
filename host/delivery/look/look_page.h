// SPDX-License-Identifier: Apache-2.0
// Writes a page that shows the lobes of maps in a browser, next to averaged normals, the engines' rules and the
// one-lobe export. The page is one self-contained HTML file that can be opened from disk.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

constexpr int kLookSideMax = 2048;  // limit per map, because a browser holds the whole map and its averaged normals as
                                    // floats
// The limit for all maps together. A page with this many texels has a size of 150 MB.
constexpr std::int64_t kLookTexelsMax = std::int64_t{4} * kLookSideMax * kLookSideMax;

struct LookMap {
  std::string input;            // *.ndf.exr of vMF lobes
  std::string source;           // the normal map that was baked; if empty, level 0 of `input` is used
  std::string albedo;           // the base colour, of the map's size; if empty, the surface is grey
  std::string title;            // if empty, the name of `input`
  double base_roughness = 0.3;  // perceptual roughness, 0.05..1
  double metalness = 0;         // 0..1; both can be changed on the page
};

struct LookJob {
  std::vector<LookMap> maps;  // at least one map; the page lets the user choose
  std::string output;         // *.html
  bool same_source = false;   // fail if a source is not the file that was baked
  int threads = 1;
};

/// Throws Error and Cancelled. Leaves no partial file.
void write_look_page(const LookJob& job, Device& device, Progress* progress);

}  // namespace multum
