// SPDX-License-Identifier: Apache-2.0
// Draws the pictures of a scene.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime_gl/render/renderer.h"
#include "tools/multum_view/baked_map.h"

namespace multum {

struct NamedPicture {
  std::string name;  // "multum" or a name of --compare
  gl::Picture picture;
  std::shared_ptr<const gl::FloatImage> background = nullptr;  // shown behind the picture; ignored by errors
};

/// Returns the background of a picture of the scene, which is the environment, or null for a black background.
std::shared_ptr<const gl::FloatImage> background_of(const PictureOptions& options, const gl::RenderScene& scene);

/// Returns the picture drawn in front of its background.
gl::FloatImage shown_image(const NamedPicture& picture);

/// Draws every picture that the options list, for any number of scenes. Textures are uploaded only once.
class PictureDrawer {
 public:
  /// All arguments must outlive this object.
  PictureDrawer(const MapOptions& options, const std::vector<Brdf>& basis, const gl::GlFunctions& gl,
                const gl::Mesh& mesh, const BakedMap& map, const gl::NormalImage& source);
  /// Returns the reference (if --compare lists it), then the baked map, then the baselines.
  std::vector<NamedPicture> draw(const gl::RenderScene& scene);
  std::vector<gl::ShaderVariant> variants() const { return renderer_.variants(); }
  double take_environment_seconds() { return renderer_.take_environment_seconds(); }

 private:
  const MapOptions& options_;
  const std::vector<Brdf>& basis_;
  const gl::Mesh& mesh_;
  int lobe_count_;
  gl::Renderer renderer_;
  std::unique_ptr<gl::Material> baked_;
  std::optional<gl::NormalMaterial> mipmapped_, finest_;
  std::optional<gl::Picture> kept_reference_;
};

/// `renderer` is the name that GL reports.
void warn_of_wrong_anisotropy(const MapOptions& options, const BakedHeader& baked, const std::string& renderer);

}  // namespace multum
