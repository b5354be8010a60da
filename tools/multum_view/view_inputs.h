// SPDX-License-Identifier: Apache-2.0
// Reads what is to be drawn: the mesh and the normal map that was baked.
#pragma once

#include "host/light/environment_light.h"
#include "host/mesh/mesh.h"
#include "runtime_gl/gl/mesh.h"
#include "tools/multum_view/baked_map.h"

namespace multum {

/// The plane's side, which is also how often a map repeats along it, without options.
constexpr float kPlaneSize = 60.0f;

/// The plane, or the mesh that the options name; sets what the scene takes of it: repeats and the camera.
gl::MeshData make_mesh(ViewOptions& options);
gl::MeshData to_mesh_data(const TriangleMesh& mesh);
/// The camera sees all of it, unless the options have one of their own; near and far planes are set in any case. Says
/// what the mesh's bounds and the camera are.
void frame_mesh(const TriangleMesh& mesh, ViewOptions& options);

/// One for each of --distance, framed by frame_mesh() before: its camera, and the names of what it writes. Without, the
/// options themselves.
std::vector<ViewOptions> views_of(const ViewOptions& options);
/// "teapot.png" -> "teapot_5.png".
std::string distant_path(const ViewOptions& options, float factor);

/// A file that holds every level draws itself; others take the finest from the source.
bool needs_source(const ViewOptions& options, const BakedHeader& baked);

/// The map that was baked, as the bake read it; without --source, level 0 of the file.
gl::NormalImage read_source(const ViewOptions& options, const BakedMap& map);

/// Null without --environment.
std::shared_ptr<const EnvironmentLight> read_environment(const ViewOptions& options);

void warn_of_sources(const ViewOptions& options, const BakedHeader& baked);

}  // namespace multum
