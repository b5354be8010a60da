// SPDX-License-Identifier: Apache-2.0
// Every picture that the options ask for.
#pragma once

#include <string>
#include <vector>

#include "runtime_gl/render/renderer.h"
#include "tools/multum_view/baked_map.h"

namespace multum {

struct NamedPicture {
  std::string name;  // "multum", or what --compare has
  gl::Picture picture;
};

/// The truth first, where it is asked for, then the baked map, then the baselines.
std::vector<NamedPicture> draw_all(const ViewOptions& options, const gl::GlFunctions& gl, const gl::Mesh& mesh,
                                   const BakedMap& map, const gl::NormalImage& source);

/// `renderer`: how GL describes itself.
void warn_of_wrong_anisotropy(const ViewOptions& options, const BakedHeader& baked, const std::string& renderer);

}  // namespace multum
