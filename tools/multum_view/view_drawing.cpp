// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/view_drawing.h"

#include <fmt/format.h>

#include "host/base/log.h"

namespace multum {
namespace {

gl::Baseline baseline_of(const std::string& name) {
  return name == "mip"       ? gl::Baseline::kMip
         : name == "toksvig" ? gl::Baseline::kToksvig
         : name == "lean"    ? gl::Baseline::kLean
                             : gl::Baseline::kLeanJacobian;
}

bool is_power_of_two(int size) { return (size & (size - 1)) == 0; }

}  // namespace

std::vector<NamedPicture> draw_all(const ViewOptions& options, const gl::GlFunctions& gl, const gl::Mesh& mesh,
                                   const BakedMap& map, const gl::NormalImage& source) {
  using gl::NormalMaterial;
  gl::Renderer renderer(gl, options.width, options.height);
  std::vector<NamedPicture> pictures;
  pictures.push_back({"multum", renderer.draw(mesh, *make_material(gl, map, options, source), options.scene)});
  if (options.compare.empty()) return pictures;
  NormalMaterial mipmapped(gl, source, NormalMaterial::Sampling::kMipmapped, options.anisotropy);
  for (const std::string& name : options.compare) {
    if (name == "truth") {
      const NormalMaterial finest(gl, source, NormalMaterial::Sampling::kNearest, 1.0f);
      pictures.insert(pictures.begin(), {name, renderer.draw_truth(mesh, finest, options.scene, options.samples)});
    } else {
      mipmapped.set_baseline(baseline_of(name));
      pictures.push_back({name, renderer.draw(mesh, mipmapped, options.scene)});
    }
  }
  return pictures;
}

/// Measured with Mesa 22.3.6: a plane seen from above, terrain of 403 x 344, averaged normals 85 % off with
/// --anisotropy 4 and 60 % without; resized to 256 x 256, 65 and 66 %.
void warn_of_wrong_anisotropy(const ViewOptions& options, const BakedHeader& baked, const std::string& renderer) {
  if (options.anisotropy <= 1.0f || renderer.find("llvmpipe") == std::string::npos) return;
  if (is_power_of_two(baked.width) && is_power_of_two(baked.height)) return;
  log_warning(
      fmt::format("{}: is {} x {} texels; this software renderer filters sizes that are no powers of two "
                  "wrongly with --anisotropy: leave it out for a right picture",
                  options.input, baked.width, baked.height));
}

}  // namespace multum
