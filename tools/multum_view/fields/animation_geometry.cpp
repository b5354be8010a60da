// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/fields/animation_geometry.h"

#include "host/fields/inferred/field_files.h"

namespace multum {

AnimationGeometry::AnimationGeometry(const gl::GlFunctions& gl, const InferredManifest& manifest,
                                     const std::string& folder)
    : manifest_(manifest) {
  const std::string geometry = checked_geometry(manifest, folder);
  meshes_ = read_object_meshes(geometry, manifest.uv_set);
  for (const InferredObject& object : manifest.objects) {
    places_.push_back(find_object(meshes_, object.mesh, geometry));
    drawn_.emplace_back();
    for (const TextureMapping& mapping : object.mappings)
      drawn_.back().push_back(std::make_unique<gl::Mesh>(gl, mapped_mesh_data(meshes_[places_.back()], mapping)));
  }
}

const glm::dmat4& AnimationGeometry::place(std::size_t object, std::size_t sample) const {
  return object_place(meshes_[places_[object]], manifest_.samples[sample].object_to_world);
}

}  // namespace multum
