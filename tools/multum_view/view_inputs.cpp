// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/view_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/files/content_hash.h"
#include "host/base/log.h"
#include "host/image/colour_map.h"
#include "host/image/files/environment_file.h"
#include "host/image/material_maps.h"
#include "host/image/normals/normal_map.h"
#include "host/image/normals/reading_parameters.h"
#include "host/image/normals/reading_settings.h"
#include "host/mesh/mesh.h"
#include "runtime_gl/render/camera.h"

namespace multum {
namespace {

/// As the bake read it, unless the command line says otherwise.
NormalMapSettings source_settings(const ViewOptions& options, const BakedHeader& baked) {
  NormalMapSettings settings = parse_reading_settings(baked.provenance.settings);
  settings.wrap_s = baked.wrap_s;
  settings.wrap_t = baked.wrap_t;
  if (hash_file(options.source) == baked.provenance.source_hash) {
    settings.repair_share_max = 1.0f;  // the bake took these very texels
  } else if (!baked.provenance.source_hash.empty()) {
    log_warning(fmt::format(
        "{}: is not the file that {} was baked from ({}, SHA-256 {}): {} may show another map", options.source,
        options.input, baked.provenance.source_name, baked.provenance.source_hash,
        baked.first_level > 0 ? "the finest levels, the truth and the baselines" : "the truth and the baselines"));
  }
  apply_reading(options.reading, settings);
  return settings;
}

/// Warns of an albedo, roughness, gloss or weights map that is not the one of the bake, by what the file's settings
/// state.
void warn_of_another(const ViewOptions& options, const BakedHeader& baked, const char* key, const char* option,
                     const std::string& path, const std::string& ending) {
  const nlohmann::json settings = nlohmann::json::parse(baked.provenance.settings, nullptr, false);
  if (!settings.is_object() || !settings.contains(key) || !settings[key].is_string()) return;
  const std::string stated = settings[key].get<std::string>();
  if (stated.empty() || stated == hash_file(path) + ending) return;
  log_warning(
      fmt::format("{}{}: {} is not what {} was baked with ({} {}): the truth and the baselines may show another "
                  "material",
                  path, ending, option, options.input, key, stated));
}

/// Lengths of normals, colours and weights, as the bake had them.
void add_materials(const ViewOptions& options, const BakedHeader& baked, gl::NormalImage& image) {
  ChannelFile roughness = parse_channel_file(options.gloss.empty() ? options.roughness : options.gloss);
  roughness.is_gloss = !options.gloss.empty();
  if (baked.has_roughness == roughness.path.empty())
    throw Error(ErrorCode::kUsage, fmt::format("{}: has {}roughness in, found {}, expected {} beside --source",
                                               options.input, baked.has_roughness ? "" : "no ",
                                               roughness.path.empty() ? "no --roughness and no --gloss"
                                               : roughness.is_gloss   ? "--gloss"
                                                                      : "--roughness",
                                               baked.has_roughness ? "the map that it was baked with" : "none"));
  if (options.basis.size() > 1 && options.weights.empty())
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: found {} of --brdf and no --weights, expected the map that it was baked with beside "
                            "--source",
                            options.input, options.basis.size()));
  if (!roughness.path.empty()) {
    warn_of_another(options, baked, "roughness", roughness.is_gloss ? "--gloss" : "--roughness", roughness.path,
                    (roughness.channel.empty() ? "" : ":" + roughness.channel) + (roughness.is_gloss ? ", gloss" : ""));
    PlaneStore normals(image.width, image.height);
    std::array<std::vector<float>, 3> planes;
    for (std::size_t p = 0; p < 3; ++p)
      for (const glm::vec3& n : image.normals) planes[p].push_back(n[static_cast<glm::length_t>(p)]);
    normals.write_rows(0, image.height, {planes[0].data(), planes[1].data(), planes[2].data()});
    shorten_by_roughness(normals, roughness, {}, 1);
    planes = normals.take_planes();
    for (std::size_t i = 0; i < image.normals.size(); ++i)
      image.normals[i] = {planes[0][i], planes[1][i], planes[2][i]};
    image.has_roughness = true;
  }
  if (!options.weights.empty()) {
    warn_of_another(options, baked, "weights", "--weights", options.weights, "");
    WeightMap map = read_weight_map(options.weights, image.width, image.height, {}, 1);
    const auto count = static_cast<std::size_t>(map.count);
    image.weight_count = map.count;
    image.weights.resize(image.normals.size() * count);
    for (std::size_t t = 0; t < map.rgb_planes.size(); ++t) {
      const std::array<std::vector<float>, 3> planes = map.rgb_planes[t].take_planes();
      for (std::size_t k = 3 * t; k < std::min(count, 3 * t + 3); ++k)
        for (std::size_t i = 0; i < image.normals.size(); ++i) image.weights[i * count + k] = planes[k - 3 * t][i];
    }
  }
  if (options.albedo.empty()) return;
  warn_of_another(options, baked, "albedo", "--albedo", options.albedo, "");
  const ColourMap colours = read_albedo_map(options.albedo, image.width, image.height, 1);
  for (std::size_t i = 0; i < colours.r.size(); ++i)
    image.albedo.emplace_back(colours.r[i], colours.g[i], colours.b[i]);
}

}  // namespace

gl::MeshData to_mesh_data(const TriangleMesh& mesh) {
  gl::MeshData data;
  data.indices = mesh.indices;
  data.vertices.reserve(mesh.positions.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    data.vertices.push_back({mesh.positions[i], mesh.normals[i], mesh.tangents[i], mesh.uvs[i]});
  return data;
}

void frame_mesh(const TriangleMesh& mesh, ViewOptions& options) {
  gl::RenderScene& scene = options.scene;
  glm::vec3 low = mesh.positions[0];
  glm::vec3 high = low;
  for (const glm::vec3& p : mesh.positions) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const glm::vec3 middle = 0.5f * (low + high);
  const float radius = std::max(0.5f * glm::length(high - low), 1e-6f);
  if (!options.has_camera)
    scene.camera = gl::frame_points(mesh.positions, options.up,
                                    static_cast<float>(options.width) / static_cast<float>(options.height));
  if (!options.has_last_camera) options.last_scene.camera = scene.camera;
  if (options.has_camera || options.has_last_camera) {
    scene.camera.near_distance = 0.05f * radius;
    scene.camera.far_distance = std::max({5.0f * radius, 4.0f * glm::length(scene.camera.eye - middle),
                                          4.0f * glm::length(options.last_scene.camera.eye - middle)});
  }
  const gl::Camera& camera = scene.camera;
  log_info(fmt::format("{}: x {:.6g} to {:.6g}, y {:.6g} to {:.6g}, z {:.6g} to {:.6g}",
                       options.mesh.empty() ? options.lod : options.mesh, low.x, high.x, low.y, high.y, low.z, high.z));
  log_info(fmt::format("--camera {:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}: {:.6g} away from its target",
                       camera.eye.x, camera.eye.y, camera.eye.z, camera.target.x, camera.target.y, camera.target.z,
                       camera.fov_y_degrees, glm::length(camera.eye - camera.target)));
}

std::vector<ViewOptions> views_of(const ViewOptions& options) {
  if (options.distances.empty()) return {options};
  std::vector<ViewOptions> views;
  for (const float factor : options.distances) {
    ViewOptions& one = views.emplace_back(options);
    one.output = distant_path(options, factor);
    if (!one.pictures.empty()) one.pictures += fmt::format("_{:g}", factor);
    one.scene.camera = gl::moved_away(options.scene.camera, factor);
    one.distances = {factor};
  }
  return views;
}

std::string distant_path(const ViewOptions& options, float factor) {
  const std::size_t ending = options.output.rfind('.');
  return fmt::format("{}_{:g}{}", options.output.substr(0, ending), factor, options.output.substr(ending));
}

gl::MeshData make_mesh(ViewOptions& options) {
  gl::RenderScene& scene = options.scene;
  if (options.mesh.empty()) {
    scene.uv_scale = options.repeat > 0.0f ? options.repeat : kPlaneSize;
    return to_mesh_data(make_plane(kPlaneSize));
  }
  scene.uv_scale = options.repeat > 0.0f ? options.repeat : 1.0f;
  const TriangleMesh mesh = read_mesh(options.mesh);
  frame_mesh(mesh, options);
  return to_mesh_data(mesh);
}

bool needs_source(const ViewOptions& options, const BakedHeader& baked) {
  return !options.compare.empty() || (baked.first_level > 0 && !options.stored_only);
}

gl::NormalImage read_source(const ViewOptions& options, const BakedMap& map) {
  const BakedHeader& baked = map.header;
  if (options.source.empty() && baked.first_level > 0)
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: holds {} of a map of {} x {}; found no --source, expected the normal map that it was "
                            "baked from, which has the finer ones ({}, SHA-256 {})",
                            options.input, levels_text(baked.first_level, baked.level_count()), baked.width,
                            baked.height, baked.provenance.source_name, baked.provenance.source_hash));
  if (options.source.empty()) return finest_normals(map);
  const NormalMap normals = read_normal_map(options.source, source_settings(options, baked), 1, nullptr);
  log_info(options.source + ": " + normals.report.encoding);
  for (const std::string& warning : normals.report.warnings) log_warning(options.source + ": " + warning);
  if (normals.width != baked.width || normals.height != baked.height)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: is {} x {} texels; {} was baked from {} x {}", options.source, normals.width,
                            normals.height, options.input, baked.width, baked.height));
  gl::NormalImage image{normals.width, normals.height, {}, {}, baked.wrap_s, baked.wrap_t};
  for (std::size_t i = 0; i < normals.x.size(); ++i)
    image.normals.emplace_back(normals.x[i], normals.y[i], normals.z[i]);
  add_materials(options, baked, image);
  return image;
}

std::shared_ptr<const EnvironmentLight> read_environment(const ViewOptions& options) {
  if (options.environment.empty()) return nullptr;
  const ColourMap colours = read_environment_map(options.environment);
  if (colours.clamped_count > 0)
    log_warning(fmt::format("{}: {} texels are negative or not finite: they count as black", options.environment,
                            colours.clamped_count));
  EnvironmentMap map{colours.width, colours.height, {}};
  for (std::size_t i = 0; i < colours.r.size(); ++i) map.texels.emplace_back(colours.r[i], colours.g[i], colours.b[i]);
  return make_environment_light(std::move(map));
}

void warn_of_sources(const ViewOptions& options, const BakedHeader& baked) {
  if (!needs_source(options, baked) && !options.source.empty())
    log_warning(options.source + ": is not read without --compare: the baked map's picture does not need it");
  if (baked.first_level > 0 && !options.stored_only && baked.has_colours && options.albedo.empty())
    log_warning(
        fmt::format("{}: has colours from level {} on; without --albedo the finer levels have those of level "
                    "{}, blurred",
                    options.input, baked.first_level, baked.first_level));
}

}  // namespace multum
