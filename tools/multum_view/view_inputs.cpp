// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/view_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "host/formats/image/colour_map.h"
#include "host/formats/image/files/environment_file.h"
#include "host/formats/image/material_maps.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/normals/reading_parameters.h"
#include "host/formats/image/normals/reading_settings.h"
#include "host/formats/mesh/mesh.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/log.h"
#include "runtime_gl/render/camera.h"
#include "tools/multum_view/kept_reference.h"

namespace multum {
namespace {

/// Returns the settings of the bake. Settings on the command line override them.
NormalMapSettings source_settings(const MapOptions& options, const BakedHeader& baked) {
  NormalMapSettings settings = parse_reading_settings(baked.provenance.settings);
  settings.wrap_s = baked.wrap_s;
  settings.wrap_t = baked.wrap_t;
  if (hash_file(options.source.normals) == baked.provenance.file_hash()) {
    settings.repair_share_max = 1.0f;  // the bake has already accepted these texels
  } else if (!baked.provenance.source_hash.empty()) {
    log_warning(options.source.normals,
                fmt::format("is not the file that {} was baked from ({}, SHA-256 {}): {} may show another map",
                            options.file, baked.provenance.source_name, baked.provenance.file_hash(),
                            baked.first_level > 0 ? "the finest levels, the reference and the baselines"
                                                  : "the reference and the baselines"));
  }
  apply_reading(options.source.reading, settings);
  return settings;
}

/// Warns if an albedo, roughness, gloss or weights map differs from the map named in the baked file's settings.
void warn_of_another(const std::string& file, const BakedHeader& baked, const char* key, const char* option,
                     const std::string& path, const std::string& ending) {
  const nlohmann::json settings = nlohmann::json::parse(baked.provenance.settings, nullptr, false);
  if (!settings.is_object() || !settings.contains(key) || !settings[key].is_string()) return;
  const std::string stated = settings[key].get<std::string>();
  if (stated.empty() || stated == hash_file(path) + ending) return;
  log_warning(path + ending, fmt::format("{} differs from the map that {} was baked with ({} {}): the reference and "
                                         "the baselines may show another material",
                                         option, file, key, stated));
}

ChannelFile roughness_file(const SourceOptions& source) {
  ChannelFile file = parse_channel_file(source.gloss.empty() ? source.roughness : source.gloss);
  file.is_gloss = !source.gloss.empty();
  return file;
}

/// Throws Error(kUsage) unless the maps given with --source are the maps of the bake.
void check_materials(const MapOptions& options, const BakedHeader& baked, const ChannelFile& roughness,
                     std::size_t brdf_count) {
  if (baked.has_roughness == roughness.path.empty())
    throw Error(ErrorCode::kUsage, fmt::format("{}: was baked {} roughness, found --source with {}, expected {}",
                                               options.file, baked.has_roughness ? "with" : "without",
                                               roughness.path.empty() ? "no --roughness and no --gloss"
                                               : roughness.is_gloss   ? "--gloss"
                                                                      : "--roughness",
                                               baked.has_roughness ? "the map that it was baked with" : "none"));
  if (brdf_count > 1 && options.source.weights.empty())
    throw Error(
        ErrorCode::kUsage,
        fmt::format(
            "{}: --brdf was given {} times without --weights, expected the weight map of the bake with --source",
            options.file, brdf_count));
}

/// Returns the normals of the bake, shortened by roughness. Works on planes and makes texels only at the end.
std::vector<glm::vec3> source_normals(const MapOptions& options, const BakedHeader& baked, NormalMap map,
                                      const ChannelFile& roughness) {
  std::array<std::vector<float>, 3> planes = {std::move(map.x), std::move(map.y), std::move(map.z)};
  if (!roughness.path.empty()) {
    warn_of_another(options.file, baked, "roughness", roughness.is_gloss ? "--gloss" : "--roughness", roughness.path,
                    (roughness.channel.empty() ? "" : ":" + roughness.channel) + (roughness.is_gloss ? ", gloss" : ""));
    PlaneStore normals(map.width, map.height);
    normals.write_rows(0, map.height, {planes[0].data(), planes[1].data(), planes[2].data()});
    for (const std::string& warning : shorten_by_roughness(normals, roughness, {}, 1).warnings)
      log_named_warning(warning);
    planes = normals.take_planes();
  }
  std::vector<glm::vec3> texels;
  texels.reserve(planes[0].size());
  for (std::size_t i = 0; i < planes[0].size(); ++i) texels.emplace_back(planes[0][i], planes[1][i], planes[2][i]);
  return texels;
}

/// Adds the colours and weights of the bake.
void add_materials(const MapOptions& options, const BakedHeader& baked, gl::NormalImage& image) {
  const SourceOptions& source = options.source;
  if (!source.weights.empty()) {
    warn_of_another(options.file, baked, "weights", "--weights", source.weights, "");
    WeightMap map = read_weight_map(source.weights, image.width, image.height, {}, 1);
    for (const std::string& warning : map.warnings) log_named_warning(warning);
    const auto count = static_cast<std::size_t>(map.count);
    image.weight_count = map.count;
    image.weights.resize(image.normals.size() * count);
    for (std::size_t t = 0; t < map.rgb_planes.size(); ++t) {
      const std::array<std::vector<float>, 3> planes = map.rgb_planes[t].take_planes();
      for (std::size_t k = 3 * t; k < std::min(count, 3 * t + 3); ++k)
        for (std::size_t i = 0; i < image.normals.size(); ++i) image.weights[i * count + k] = planes[k - 3 * t][i];
    }
  }
  if (source.albedo.empty()) return;
  warn_of_another(options.file, baked, "albedo", "--albedo", source.albedo, "");
  const ColourMap colours = read_albedo_map(source.albedo, image.width, image.height, 1);
  for (const std::string& note : colours.notes) log_warning(source.albedo, note);
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

void frame_mesh(const TriangleMesh& mesh, const std::string& file, const OutputOptions& output, ViewScenes& scenes) {
  gl::RenderScene& scene = scenes.first;
  glm::vec3 low = mesh.positions[0];
  glm::vec3 high = low;
  for (const glm::vec3& p : mesh.positions) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const glm::vec3 middle = 0.5f * (low + high);
  const float radius = std::max(0.5f * glm::length(high - low), 1e-6f);
  if (!scenes.has_camera)
    scene.camera = gl::frame_points(mesh.positions, scenes.up,
                                    static_cast<float>(output.width()) / static_cast<float>(output.height()));
  if (!scenes.has_last_camera) scenes.last.camera = scene.camera;
  if (scenes.has_camera || scenes.has_last_camera) {
    scene.camera.near_distance = 0.05f * radius;
    scene.camera.far_distance = std::max({5.0f * radius, 4.0f * glm::length(scene.camera.eye - middle),
                                          4.0f * glm::length(scenes.last.camera.eye - middle)});
  }
  const gl::Camera& camera = scene.camera;
  log_info(fmt::format("{}: x {:.6g} to {:.6g}, y {:.6g} to {:.6g}, z {:.6g} to {:.6g}", file, low.x, high.x, low.y,
                       high.y, low.z, high.z));
  log_info(fmt::format("--camera {:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}: {:.6g} away from its target",
                       camera.eye.x, camera.eye.y, camera.eye.z, camera.target.x, camera.target.y, camera.target.z,
                       camera.fov_y_degrees, glm::length(camera.eye - camera.target)));
}

gl::MeshData make_mesh(const PictureOptions& options, ViewScenes& scenes) {
  const std::string& file = options.surface.mesh;
  scenes.first.uv_scale = options.surface.repeat.value_or(file.empty() ? kPlaneSize : 1.0f);
  if (file.empty()) return to_mesh_data(make_plane(kPlaneSize));
  const TriangleMesh mesh = read_mesh(file);
  frame_mesh(mesh, file, options.output, scenes);
  return to_mesh_data(mesh);
}

bool needs_source(const MapOptions& options, const BakedHeader& baked) {
  const ComparisonOptions& comparison = options.comparison;
  const bool has_reference = has_kept_reference(comparison.kept_reference);
  const bool is_compared = std::any_of(comparison.pictures.begin(), comparison.pictures.end(),
                                       [&](const std::string& one) { return one != "reference" || !has_reference; });
  return is_compared || (baked.first_level > 0 && !options.stored_only);
}

gl::NormalImage read_source(const MapOptions& options, const ViewScenes& scenes, const BakedMap& map) {
  const BakedHeader& baked = map.header;
  const std::string& source = options.source.normals;
  if (source.empty() && baked.first_level > 0)
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: contains only {} of a map of {} x {}; found no --source, expected the normal map of "
                            "the bake, which contains the finer levels ({}, SHA-256 {})",
                            options.file, levels_text(baked.first_level, baked.level_count()), baked.width,
                            baked.height, baked.provenance.source_name, baked.provenance.file_hash()));
  if (source.empty()) return finest_normals(map);
  NormalMap normals = read_normal_map(source, source_settings(options, baked), 1, nullptr);
  log_info(source + ": " + normals.report.encoding);
  for (const std::string& warning : normals.report.warnings) log_warning(source, warning);
  if (normals.width != baked.width || normals.height != baked.height)
    throw Error(ErrorCode::kInput, fmt::format("{}: has {} x {} texels, but {} was baked from {} x {}", source,
                                               normals.width, normals.height, options.file, baked.width, baked.height));
  const ChannelFile roughness = roughness_file(options.source);
  check_materials(options, baked, roughness, scenes.basis.size());
  gl::NormalImage image{normals.width, normals.height, {}, {}, baked.wrap_s, baked.wrap_t};
  image.has_roughness = !roughness.path.empty();
  image.normals = source_normals(options, baked, std::move(normals), roughness);
  add_materials(options, baked, image);
  return image;
}

void read_brdf_roughness(const MapOptions& options, const BakedHeader& baked, ViewScenes& scenes) {
  if (options.brdf_roughness.empty()) return;
  if (!representation_info(baked.representation).has_kappa || baked.has_roughness)
    throw Error(
        ErrorCode::kUsage,
        fmt::format(
            "{}: {}, so --brdf-roughness cannot be used; expected a file of lobes that was baked without roughness",
            options.file, baked.has_roughness ? "was baked with roughness" : "holds no vMF lobes"));
  LobeMaterial material =
      read_lobe_material({parse_channel_file(options.brdf_roughness), {}, {}}, baked.width, baked.height, {}, 1);
  for (const std::string& warning : material.roughness->warnings) log_named_warning(warning);
  auto map = std::make_shared<gl::RoughnessMap>();
  *map = {baked.width, baked.height, {}, baked.wrap_s, baked.wrap_t};
  const std::array<std::vector<float>, 3> planes = material.planes.take_planes();
  for (const float squared_alpha : planes[0]) map->texels.push_back(std::sqrt(std::sqrt(squared_alpha)));
  scenes.first.roughness = scenes.last.roughness = std::move(map);
}

std::shared_ptr<const EnvironmentLight> read_environment(const LightOptions& options) {
  if (options.environment.empty()) return nullptr;
  const ColourMap colours = read_environment_map(options.environment);
  if (colours.clamped_count > 0)
    log_warning(options.environment,
                fmt::format("{} texels are negative or not finite, and are read as black", colours.clamped_count));
  EnvironmentMap map{colours.width, colours.height, {}};
  for (std::size_t i = 0; i < colours.r.size(); ++i) map.texels.emplace_back(colours.r[i], colours.g[i], colours.b[i]);
  return make_environment_light(std::move(map));
}

void read_environments(const MapOptions& options, ViewScenes& scenes) {
  const std::string& last = options.animation.environment;
  scenes.first.environment = scenes.last.environment = read_environment(options.picture.light);
  if (last.empty()) return;
  LightOptions light = options.picture.light;
  light.environment = last;
  scenes.last.environment = read_environment(light);
  const EnvironmentMap &from = scenes.first.environment->map, &to = scenes.last.environment->map;
  if (from.width != to.width || from.height != to.height)
    throw Error(ErrorCode::kInput, fmt::format("{}: found {} x {} texels, expected {} x {} as in {}", last, to.width,
                                               to.height, from.width, from.height, options.picture.light.environment));
}

void warn_of_sources(const MapOptions& options, const BakedHeader& baked) {
  if (!needs_source(options, baked) && !options.source.normals.empty() && options.comparison.pictures.empty())
    log_warning(options.source.normals, "is not read, because no picture needs it without --compare");
  if (baked.first_level > 0 && !options.stored_only && baked.has_colours && options.source.albedo.empty())
    log_warning(
        options.file,
        fmt::format("has colours from level {} on; without --albedo, finer levels use blurred colours of level {}",
                    baked.first_level, baked.first_level));
}

}  // namespace multum
