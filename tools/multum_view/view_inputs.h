// SPDX-License-Identifier: Apache-2.0
// Reads the inputs of a picture: the mesh, the normal map that was baked, the environment.
#pragma once

#include "host/formats/light/environment_light.h"
#include "host/formats/mesh/mesh.h"
#include "runtime_gl/gl/mesh.h"
#include "tools/multum_view/baked_map.h"

namespace multum {

/// The plane's side, and the default number of times that a map repeats along it.
constexpr float kPlaneSize = 60.0f;

/// Returns the plane, or the mesh that the options name. Sets the scenes' repeats and camera from it.
gl::MeshData make_mesh(const PictureOptions& options, ViewScenes& scenes);
gl::MeshData to_mesh_data(const TriangleMesh& mesh);
/// Frames the whole mesh, unless the options set a camera; always sets near and far planes. Prints the bounds of the
/// mesh, which `file` holds, and the camera.
void frame_mesh(const TriangleMesh& mesh, const std::string& file, const OutputOptions& output, ViewScenes& scenes);

/// Returns whether the file lacks levels, which then come from the source.
bool needs_source(const MapOptions& options, const BakedHeader& baked);

/// Returns the map that was baked, read as the bake read it; without --source, level 0 of the file.
gl::NormalImage read_source(const MapOptions& options, const ViewScenes& scenes, const BakedMap& map);

/// Returns null without --environment.
std::shared_ptr<const EnvironmentLight> read_environment(const LightOptions& options);
/// Reads the environments of the first frame and of the last. Throws Error(kInput) if their sizes differ.
void read_environments(const MapOptions& options, ViewScenes& scenes);
/// Does nothing without --brdf-roughness. Throws Error(kUsage) if the file has no lobes, Error(kInput) for a bad map.
void read_brdf_roughness(const MapOptions& options, const BakedHeader& baked, ViewScenes& scenes);

void warn_of_sources(const MapOptions& options, const BakedHeader& baked);

}  // namespace multum
