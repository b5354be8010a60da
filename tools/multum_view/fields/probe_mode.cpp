// SPDX-License-Identifier: Apache-2.0
// Implements multum-view probe, which measures the filter matrices that a request file lists, and writes them to files.
// It runs in its own process, so that a crash of the driver affects only the measurement.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <thread>

#include "host/fields/inferred/filter_matrix.h"
#include "host/fields/inferred/probe_request.h"
#include "host/formats/mesh/object_mesh.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/base/stopwatch.h"
#include "runtime_gl/context/headless_context.h"
#include "runtime_gl/probe/filter_probe.h"
#include "tools/multum_view/fields/object_meshes.h"
#include "tools/multum_view/modes.h"

namespace multum {
namespace {

std::string matrices_hash(const std::vector<gl::PlacedMesh>& placed) {
  ContentHash hash;
  for (const gl::PlacedMesh& one : placed) hash.update(&one.object_to_clip, sizeof(one.object_to_clip));
  return hash.finish();
}

// Returns the object of each task. Before the measurement, refuses tasks that could not finish, and output files that
// would overwrite each other or an input.
std::vector<std::size_t> check_tasks(const ProbeRequest& request, const ProbeOptions& options,
                                     const std::vector<ObjectMesh>& meshes) {
  std::vector<std::size_t> objects;
  std::vector<std::string> outputs;
  for (const ProbeTask& task : request.tasks) {
    objects.push_back(find_object(meshes, task.object, request.geometry_file));
    outputs.push_back(task.output);
    if (options.matrix_market) outputs.push_back(task.output + ".mtx");
  }
  check_paths_differ({options.request, request.geometry_file}, outputs);
  for (const std::string& output : outputs) check_writable(output);
  return objects;
}

void probe_all(const ProbeRequest& request, const ProbeOptions& options) {
  const std::vector<ObjectMesh> meshes = read_object_meshes(request.geometry_file, request.uv_set);
  const std::vector<std::size_t> task_objects = check_tasks(request, options, meshes);
  const auto context = gl::make_headless_context(options.context);
  log_info(context->description());
  const gl::GlFunctions& gl = context->functions();
  const gl::FilterProbe probe(gl, request.width, request.height, request.supersampling);
  // The other objects only hide surfaces behind them, so mapped texture coordinates are not needed for them.
  std::vector<std::unique_ptr<gl::Mesh>> plain;
  std::vector<gl::PlacedMesh> placed;
  for (const ObjectMesh& mesh : meshes) {
    plain.push_back(std::make_unique<gl::Mesh>(gl, mapped_mesh_data(mesh, {})));
    placed.push_back(
        {plain.back().get(), object_to_clip(request.world_to_clip, object_place(mesh, request.object_to_world))});
  }
  for (std::size_t i = 0; i < request.tasks.size(); ++i) {
    const Stopwatch stopwatch;
    const ProbeTask& task = request.tasks[i];
    const std::size_t object = task_objects[i];
    const gl::MeshData data = mapped_mesh_data(meshes[object], task.mapping);
    const gl::Mesh mapped(gl, data);
    std::vector<gl::PlacedMesh> objects = placed;
    objects[object].mesh = &mapped;
    FilterMatrix matrix = probe.probe(objects, object, task.mapping, {task.anisotropy, task.has_mips}, options.threads);
    matrix.provenance = {std::string("multum-view ") + MULTUM_VERSION,
                         context->description(),
                         request.view,
                         task.object,
                         mesh_data_hash(data),
                         matrices_hash(placed),
                         task.key};
    write_filter_matrix(matrix, task.output);
    if (options.matrix_market) write_matrix_market(matrix, task.output + ".mtx");
    const double seconds = stopwatch.seconds();
    write_shown(stdout, fmt::format("{}: {} pixels, {} entries, {} rejected, {:.2f} s\n", task.object,
                                    matrix.row_count(), matrix.columns.size(), matrix.rows_rejected, seconds));
  }
}

}  // namespace

void add_probe_options(CLI::App& app, ProbeOptions& options) {
  app.add_option("request", options.request, "request to read, JSON (docs/reference/inferred_textures.md)")->required();
  app.add_option("--threads", options.threads, "use this many threads (default: all cores)")
      ->check(CLI::Range(1, 1024));
  app.add_flag("--matrix-market", options.matrix_market, "also write each matrix as Matrix Market text, OUTPUT.mtx");
  add_context_option(app, options.context);
}

int measure_filter_matrices(const ProbeOptions& options) {
  probe_all(read_probe_request(options.request), options);
  return 0;
}

}  // namespace multum
