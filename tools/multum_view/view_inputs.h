// SPDX-License-Identifier: Apache-2.0
// Reads the inputs of a picture, which are the mesh, the normal map of the bake, and the environment.
#pragma once

#include "host/formats/light/environment_light.h"
#include "host/formats/mesh/mesh.h"
#include "runtime_gl/gl/mesh.h"
#include "tools/multum_view/baked_map.h"

namespace multum {

/// The side of the plane, which is also the default number of repeats of a map along it.
constexpr float kPlaneSize = 60.0f;

/// Returns the plane, or the mesh that the options name. Sets the scenes' repeats and camera from it.
gl::MeshData make_mesh(const PictureOptions& options, ViewScenes& scenes);
gl::MeshData to_mesh_data(const TriangleMesh& mesh);
/// Moves the camera so that it shows the whole mesh, unless the options set a camera. Always sets the near and far
/// planes. Prints the camera and the bounds of the mesh. `file` is the file of the mesh.
void frame_mesh(const TriangleMesh& mesh, const std::string& file, const OutputOptions& output, ViewScenes& scenes);

/// Returns whether levels are missing in the file. Missing levels are taken from the source.
bool needs_source(const MapOptions& options, const BakedHeader& baked);

/// Returns the map of the bake, read with the settings of the bake, or level 0 of the file if --source is not given.
gl::NormalImage read_source(const MapOptions& options, const ViewScenes& scenes, const BakedMap& map);

/// Returns the environment that --environment names, or null if this option is not given.
std::shared_ptr<const EnvironmentLight> read_environment(const LightOptions& options);
/// Reads the environments of the first and the last frame. Throws Error(kInput) if their sizes differ.
void read_environments(const MapOptions& options, ViewScenes& scenes);
/// Does nothing if --brdf-roughness is not given. Throws Error(kUsage) if the file has no lobes, and Error(kInput) for
/// a bad map.
void read_brdf_roughness(const MapOptions& options, const BakedHeader& baked, ViewScenes& scenes);

void warn_of_sources(const MapOptions& options, const BakedHeader& baked);

}  // namespace multum
