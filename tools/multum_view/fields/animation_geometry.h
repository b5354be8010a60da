// SPDX-License-Identifier: Apache-2.0
// The objects of an animation in the form in which multum-view draws them. They consist of meshes with the texture
// coordinates of every mapping, and of the position of each object.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/fields/inferred/inferred_texture.h"
#include "tools/multum_view/fields/object_meshes.h"

namespace multum {

class AnimationGeometry {
 public:
  /// `manifest` must outlive this object. The path of the manifest's geometry file is relative to `folder`. Throws
  /// Error(kInput) if the textures were inferred for another file, or if the file does not contain one of the objects.
  AnimationGeometry(const gl::GlFunctions& gl, const InferredManifest& manifest, const std::string& folder);

  const gl::Mesh& mesh(std::size_t object, std::size_t mapping) const { return *drawn_[object][mapping]; }
  /// Returns the matrix from object space to world space at a sample.
  const glm::dmat4& place(std::size_t object, std::size_t sample) const;

 private:
  const InferredManifest& manifest_;
  std::vector<ObjectMesh> meshes_;
  std::vector<std::size_t> places_;                            // for each object, its index in meshes_
  std::vector<std::vector<std::unique_ptr<gl::Mesh>>> drawn_;  // [object][mapping]
};

}  // namespace multum
