// SPDX-License-Identifier: Apache-2.0
// Reads what is drawn: the mesh, the normal map that was baked, the environment.
#pragma once

#include "host/formats/light/environment_light.h"
#include "host/formats/mesh/mesh.h"
#include "runtime_gl/gl/mesh.h"
#include "tools/multum_view/baked_map.h"

namespace multum {

/// The plane's side, which is also how often a map repeats along it, without options.
constexpr float kPlaneSize = 60.0f;

/// The plane, or the mesh that the options name; sets what the scenes take of it: repeats and the camera.
gl::MeshData make_mesh(const PictureOptions& options, ViewScenes& scenes);
gl::MeshData to_mesh_data(const TriangleMesh& mesh);
/// The camera sees all of it, unless the options have one of their own; near and far planes are set in any case. Says
/// what the bounds of the mesh, which is of `file`, and the camera are.
void frame_mesh(const TriangleMesh& mesh, const std::string& file, const OutputOptions& output, ViewScenes& scenes);

/// A file that holds every level draws itself; others take the finest from the source.
bool needs_source(const MapOptions& options, const BakedHeader& baked);

/// The map that was baked, as the bake read it; without --source, level 0 of the file.
gl::NormalImage read_source(const MapOptions& options, const ViewScenes& scenes, const BakedMap& map);

/// Null without --environment.
std::shared_ptr<const EnvironmentLight> read_environment(const LightOptions& options);
/// That of the first frame and of the last. Throws Error(kInput) where they are not of one size.
void read_environments(const MapOptions& options, ViewScenes& scenes);
/// Nothing without --brdf-roughness. Throws Error(kUsage) for what is no file of lobes, Error(kInput) for the map.
void read_brdf_roughness(const MapOptions& options, const BakedHeader& baked, ViewScenes& scenes);

void warn_of_sources(const MapOptions& options, const BakedHeader& baked);

}  // namespace multum
