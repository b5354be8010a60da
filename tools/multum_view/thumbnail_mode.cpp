// SPDX-License-Identifier: Apache-2.0
// Implements multum-view thumbnails, which draws pictures of a job for the service. It runs in its own process, so that
// a crash due to a map or a driver affects only the pictures. The most trusted input is drawn first, because pictures
// that were drawn before a failure are kept.
#include <fmt/format.h>
#include <filesystem>

#include "host/formats/asset/lobes/movmf_reader.h"
#include "host/formats/image/colour_map.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/normals/reading_settings.h"
#include "host/formats/image/small_picture.h"
#include "host/formats/mesh/mesh.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/output_paths.h"
#include "runtime_gl/context/headless_context.h"
#include "runtime_gl/materials/gmm_material.h"
#include "runtime_gl/materials/normal_material.h"
#include "runtime_gl/render/picture_error.h"
#include "runtime_gl/render/renderer.h"
#include "tools/multum_view/modes.h"
#include "tools/multum_view/view_inputs.h"
#include "tools/multum_view/write_image.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 384, kHeight = 288;  // size of renders
constexpr int kSamples = 64;                // reference samples per pixel
// The nearest tile of the plane fills the picture, so levels that are wider than this are not needed.
constexpr int kLevelSide = 1024;
// The maximum number of texels for a reference, which is drawn from the whole map. At this limit, the reference needs a
// third of a GB.
constexpr std::int64_t kReferenceTexelsMax = std::int64_t{1} << 24;

std::string file_in(const ThumbnailOptions& options, const char* name) {
  return (fs::path(options.folder) / name).string();
}

/// Reads only the levels that a picture of this size shows, as a separate map, and skips finer levels.
MovmfMipmap read_coarse_levels(const std::string& path) {
  MovmfReader reader(path, 1);
  const MovmfMipmap& header = reader.header();
  int first = header.header.first_level;
  const auto is_larger = [&](int level) {
    const MovmfLevel& one = header.levels[static_cast<std::size_t>(level)];
    return std::max(one.width, one.height) > kLevelSide;
  };
  while (first + 1 < static_cast<int>(header.levels.size()) && is_larger(first)) ++first;
  MovmfMipmap coarse = header;
  coarse.header.first_level = 0;
  coarse.levels.clear();
  for (int level = first; level < static_cast<int>(header.levels.size()); ++level)
    coarse.levels.push_back(reader.read_level(level, 0, header.levels[static_cast<std::size_t>(level)].height));
  return coarse;
}

gl::MeshData plane_data() {
  const TriangleMesh mesh = make_plane(kPlaneSize);
  gl::MeshData data;
  data.indices = mesh.indices;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    data.vertices.push_back({mesh.positions[i], mesh.normals[i], mesh.tangents[i], mesh.uvs[i]});
  return data;
}

/// Throws Error(kInput) if the source is not the map that was baked.
NormalMapSettings source_settings(const ThumbnailOptions& options, const MovmfMipmap& mipmap) {
  const std::string& baked = mipmap.header.provenance.file_hash();
  if (const std::string found = hash_file(options.source); !baked.empty() && found != baked)
    throw Error(ErrorCode::kInput, fmt::format("{}: has changed since it was baked: SHA-256 {}, expected {}",
                                               options.source, found, baked));
  NormalMapSettings settings = parse_reading_settings(mipmap.header.provenance.settings);
  settings.wrap_s = mipmap.header.wrap_s;
  settings.wrap_t = mipmap.header.wrap_t;
  settings.repair_share_max = 1.0f;  // the bake has already accepted these texels
  settings.texel_count_max = kReferenceTexelsMax;
  return settings;
}

gl::NormalImage read_source(const ThumbnailOptions& options, const NormalMapSettings& settings) {
  const NormalMap map = read_normal_map(options.source, settings, 1, nullptr);
  gl::NormalImage image{map.width, map.height, {}, {}, settings.wrap_s, settings.wrap_t};
  for (std::size_t i = 0; i < map.x.size(); ++i) image.normals.emplace_back(map.x[i], map.y[i], map.z[i]);
  if (options.albedo.empty()) return image;
  const ColourMap colours = read_albedo_map(options.albedo, map.width, map.height, 1);
  for (std::size_t i = 0; i < colours.r.size(); ++i)
    image.albedo.emplace_back(colours.r[i], colours.g[i], colours.b[i]);
  return image;
}

void make_bake_thumbnails(const ThumbnailOptions& options) {
  const MovmfMipmap mipmap = read_coarse_levels(options.result);
  const auto context = gl::make_headless_context(options.context);
  const gl::Mesh mesh(context->functions(), plane_data());
  gl::RenderScene scene;
  scene.uv_scale = kPlaneSize;
  if (mipmap.header.has_roughness) scene.brdf.exponent = kRoughnessExponent;
  gl::Renderer renderer(context->functions(), kWidth, kHeight);
  const auto baked = gl::make_lobe_material(context->functions(), mipmap, 1.0f);
  const gl::FloatImage render = renderer.draw(mesh, *baked, scene).image;
  write_picture(file_in(options, "render.png"), render, 1.0f);
  if (options.source.empty()) return;

  const NormalMapSettings settings = source_settings(options, mipmap);
  write_png8(file_in(options, "input.png"), read_small_picture(options.source, kThumbnailSide));
  // There is no reference to compare with.
  if (mipmap.header.has_roughness || (mipmap.has_colours() && options.albedo.empty())) return;
  const gl::NormalMaterial finest(context->functions(), read_source(options, settings),
                                  gl::NormalMaterial::Sampling::kNearest, 1.0f);
  const gl::FloatImage reference = renderer.draw_reference(mesh, finest, scene, {kSamples}).image;
  write_picture(file_in(options, "error.png"), gl::difference_image(render, reference, gl::kDifferenceGain), 1.0f);
}

}  // namespace

void add_thumbnail_options(CLI::App& app, ThumbnailOptions& options) {
  app.add_option("result", options.result, "baked file, *.ndf.exr, or folder written by `multum infer`")->required();
  app.add_option("-o,--output", options.folder, "folder for the pictures")->required();
  app.add_option("--source", options.source, "normal map of the bake");
  app.add_option("--albedo", options.albedo, "read the colours of the source from this map");
  add_context_option(app, options.context);
}

int draw_thumbnails(const ThumbnailOptions& options) {
  make_folder(options.folder);
  if (fs::is_directory(options.result)) draw_field_thumbnail(options);
  else make_bake_thumbnails(options);
  return 0;
}

}  // namespace multum
