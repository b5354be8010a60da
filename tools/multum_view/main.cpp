// SPDX-License-Identifier: Apache-2.0
// multum-view: reads a baked map and a mesh, renders them with runtime_gl, compares them with the truth and with what
// users have today, and writes pictures and errors.
#include <fmt/format.h>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/asset/moment_mipmap.h"
#include "host/asset/movmf_mipmap.h"
#include "host/base/atomic_file.h"
#include "host/base/content_hash.h"
#include "host/base/error.h"
#include "host/base/log.h"
#include "host/base/output_paths.h"
#include "host/image/colour_map.h"
#include "host/image/reading_settings.h"
#include "host/mesh/mesh.h"
#include "runtime_gl/render/contact_sheet.h"
#include "runtime_gl/render/picture_error.h"
#include "runtime_gl/render/renderer.h"
#include "tools/multum_view/modes.h"
#include "tools/multum_view/view_options.h"
#include "tools/multum_view/write_image.h"

namespace multum {
namespace {

constexpr float kPlaneSize = 60.0f;

// The one of least error on most maps, by the bakes' own measurements (docs/ALGORITHMS.md, "Moments").
constexpr gl::MomentShading kUsualMomentShading = gl::MomentShading::kLeanJacobian;

struct NamedPicture {
  std::string name;
  gl::Picture picture;
};

const char* moment_shading_name(gl::MomentShading shading) {
  switch (shading) {
    case gl::MomentShading::kToksvig: return "toksvig";
    case gl::MomentShading::kLean: return "lean";
    case gl::MomentShading::kLeanJacobian: return "lean-jacobian";
  }
  return "?";
}

/// A baked file of any representation, read.
struct BakedMap {
  BakedHeader header;
  std::optional<MovmfMipmap> lobes;  // one of the two
  std::optional<MomentMipmap> moments;
};

BakedMap read_baked_map(const std::string& path) {
  BakedMap map{read_baked_header(path), std::nullopt, std::nullopt};
  if (map.header.representation == Representation::kMovmf) map.lobes = read_movmf_mipmap(path);
  else map.moments = read_moment_mipmap(path);
  return map;
}

gl::MeshData to_mesh_data(const TriangleMesh& mesh) {
  gl::MeshData data;
  data.indices = mesh.indices;
  data.vertices.reserve(mesh.positions.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    data.vertices.push_back({mesh.positions[i], mesh.normals[i], mesh.tangents[i], mesh.uvs[i]});
  return data;
}

gl::MeshData make_mesh(ViewOptions& options) {
  gl::Scene& scene = options.scene;
  if (options.mesh.empty()) {
    scene.uv_scale = options.repeat > 0.0f ? options.repeat : kPlaneSize;
    return to_mesh_data(make_plane(kPlaneSize));
  }
  scene.uv_scale = options.repeat > 0.0f ? options.repeat : 1.0f;
  const TriangleMesh mesh = read_mesh(options.mesh);
  glm::vec3 low = mesh.positions[0];
  glm::vec3 high = low;
  for (const glm::vec3& p : mesh.positions) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const gl::Camera frame = gl::frame_box(low, high, options.up);
  if (!options.has_camera) scene.camera = frame;
  scene.camera.near_distance = frame.near_distance;
  scene.camera.far_distance = std::max(frame.far_distance, 4.0f * glm::length(scene.camera.eye - frame.target));
  return to_mesh_data(mesh);
}

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
  apply(options.reading, settings);
  return settings;
}

gl::NormalImage read_source(const ViewOptions& options, const BakedMap& baked_map) {
  const BakedHeader& baked = baked_map.header;
  if (options.source.empty() && baked.first_level > 0)
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: holds {} of a map of {} x {}; found no --source, expected the normal map that it was "
                            "baked from, which has the finer ones ({}, SHA-256 {})",
                            options.input, levels_text(baked.first_level, baked.level_count()), baked.width,
                            baked.height, baked.provenance.source_name, baked.provenance.source_hash));
  if (options.source.empty())
    return baked_map.lobes ? gl::finest_normals(*baked_map.lobes) : gl::finest_normals(*baked_map.moments);
  const NormalMap map = read_normal_map(options.source, source_settings(options, baked), 1, nullptr);
  log_info(options.source + ": " + map.report.encoding);
  if (map.width != baked.width || map.height != baked.height)
    throw Error(ErrorCode::kInput, fmt::format("{}: is {} x {} texels; {} was baked from {} x {}", options.source,
                                               map.width, map.height, options.input, baked.width, baked.height));
  gl::NormalImage image{map.width, map.height, {}, {}, baked.wrap_s, baked.wrap_t};
  for (std::size_t i = 0; i < map.x.size(); ++i) image.normals.emplace_back(map.x[i], map.y[i], map.z[i]);
  if (options.albedo.empty()) return image;
  const ColourMap colours = read_albedo_map(options.albedo, map.width, map.height, 1);
  for (std::size_t i = 0; i < colours.r.size(); ++i)
    image.albedo.emplace_back(colours.r[i], colours.g[i], colours.b[i]);
  return image;
}

std::vector<NamedPicture> draw_all(const ViewOptions& options, const gl::GlFunctions& gl, const gl::Mesh& mesh,
                                   const BakedMap& map, const gl::NormalImage& source) {
  using gl::NormalMaterial;
  gl::Renderer renderer(gl, options.width, options.height);
  std::vector<NamedPicture> pictures;
  if (map.lobes) {
    const gl::MovmfMaterial baked(gl, *map.lobes, options.anisotropy, &source);
    pictures.push_back({"multum", renderer.draw_movmf(mesh, baked, options.scene, options.formula)});
  } else {
    const gl::MomentMaterial baked(gl, *map.moments, options.anisotropy, &source);
    const gl::MomentShading shading = options.moments.value_or(kUsualMomentShading);
    pictures.push_back({"multum", renderer.draw_moments(mesh, baked, options.scene, shading)});
  }
  if (options.compare.empty()) return pictures;
  const NormalMaterial mipmapped(gl, source, NormalMaterial::Sampling::kMipmapped, options.anisotropy);
  for (const std::string& name : options.compare) {
    if (name == "truth") {
      const NormalMaterial finest(gl, source, NormalMaterial::Sampling::kNearest, 1.0f);
      pictures.insert(pictures.begin(), {name, renderer.draw_truth(mesh, finest, options.scene, options.samples)});
    } else {
      const gl::Baseline baseline = name == "mip"       ? gl::Baseline::kMip
                                    : name == "toksvig" ? gl::Baseline::kToksvig
                                    : name == "lean"    ? gl::Baseline::kLean
                                                        : gl::Baseline::kLeanJacobian;
      pictures.push_back({name, renderer.draw_baseline(mesh, mipmapped, options.scene, baseline)});
    }
  }
  return pictures;
}

/// First row: the pictures; second, where there is a truth: what each is off by.
gl::FloatImage compose(const std::vector<NamedPicture>& pictures, bool has_truth, float exposure) {
  std::vector<std::vector<gl::SheetCell>> rows(has_truth ? 2 : 1);
  for (const NamedPicture& one : pictures) {
    rows[0].push_back({one.name, one.picture.image});
    if (!has_truth) continue;
    gl::FloatImage difference = gl::difference_image(one.picture.image, pictures[0].picture.image, gl::kDifferenceGain);
    const double error = gl::picture_error(one.picture.image, pictures[0].picture.image).relative_l1;
    const bool is_truth = &one == &pictures[0];
    rows[1].push_back({is_truth ? "difference, 4 times" : fmt::format("{}: {:.1f} % off", one.name, 100.0 * error),
                       std::move(difference)});
  }
  return gl::make_contact_sheet(rows, 1.0f / exposure);
}

/// The file that a picture gets by itself: `what` is its name, or its name and "_difference".
std::string picture_path(const ViewOptions& options, const std::string& what) {
  return options.pictures + "_" + what + options.output.substr(options.output.rfind('.'));
}

/// Every picture, and what it is off by, in a file of its own.
void write_pictures(const ViewOptions& options, const std::vector<NamedPicture>& pictures, bool has_truth) {
  for (const NamedPicture& one : pictures) {
    write_picture(picture_path(options, one.name), one.picture.image, options.exposure);
    if (has_truth && one.name != "truth")
      write_picture(picture_path(options, one.name + "_difference"),
                    gl::difference_image(one.picture.image, pictures[0].picture.image, gl::kDifferenceGain),
                    options.exposure);
  }
}

/// Refuses, before anything is drawn, file names that would overwrite each other or what is read, or that cannot be
/// written: nothing is rendered for nothing, and no picture is left beside a report that failed.
void check_outputs(const ViewOptions& options) {
  std::vector<std::string> outputs = {options.output};
  if (!options.report.empty()) outputs.push_back(options.report);
  if (!options.pictures.empty()) {
    const bool has_truth = std::find(options.compare.begin(), options.compare.end(), "truth") != options.compare.end();
    std::vector<std::string> names = options.compare;
    names.insert(names.begin(), "multum");
    for (const std::string& name : names) {
      outputs.push_back(picture_path(options, name));
      if (has_truth && name != "truth") outputs.push_back(picture_path(options, name + "_difference"));
    }
  }
  check_paths_differ({options.input, options.source, options.albedo, options.mesh}, outputs);
  for (const std::string& path : outputs) check_writable(path);
}

bool is_power_of_two(int size) { return (size & (size - 1)) == 0; }

/// Measured with Mesa 22.3.6: a plane seen from above, terrain of 403 x 344, averaged normals 85 % off with
/// --anisotropy 4 and 60 % without; resized to 256 x 256, 65 and 66 %.
void warn_of_wrong_anisotropy(const ViewOptions& options, const BakedHeader& baked, const std::string& renderer) {
  if (options.anisotropy <= 1.0f || renderer.find("llvmpipe") == std::string::npos) return;
  if (is_power_of_two(baked.width) && is_power_of_two(baked.height)) return;
  log_warning(
      fmt::format("{}: is {} x {} texels; this software renderer filters sizes that are no powers of two "
                  "wrongly with --anisotropy: leave it out for a right picture",
                  options.input, baked.width, baked.height));
}

/// A file that holds every level draws itself; others take the finest from the source.
bool needs_source(const ViewOptions& options, const BakedHeader& baked) {
  return !options.compare.empty() || baked.first_level > 0;
}

void warn_of_sources(const ViewOptions& options, const BakedHeader& baked) {
  if (!needs_source(options, baked) && !options.source.empty())
    log_warning(options.source + ": is not read without --compare: the baked map's picture does not need it");
  if (baked.first_level > 0 && baked.has_colours && options.albedo.empty())
    log_warning(
        fmt::format("{}: has colours from level {} on; without --albedo the finer levels have those of level "
                    "{}, blurred",
                    options.input, baked.first_level, baked.first_level));
}

/// Refuses what is for files of another representation.
void check_options_of(const ViewOptions& options, const BakedHeader& baked) {
  const bool has_lobes = baked.representation == Representation::kMovmf;
  if (has_lobes && options.moments)
    throw Error(ErrorCode::kUsage, options.input + ": holds lobes, found --moments, expected it for files of moments");
  if (!has_lobes && options.formula == gl::LobeFormula::kPaper)
    throw Error(ErrorCode::kUsage, options.input + ": holds moments, found --formula paper, expected it for lobes");
}

nlohmann::json print_table(const std::vector<NamedPicture>& pictures, bool has_truth) {
  nlohmann::json rows = nlohmann::json::array();
  fmt::print("{:14} {:>12} {:>10} {:>10}\n", "picture", "relative L1", "RMSE", "frame ms");
  for (const NamedPicture& one : pictures) {
    nlohmann::json row = {{"name", one.name}, {"frame_time_ms", one.picture.frame_time_ms}};
    std::string l1 = "-";
    std::string rmse = "-";
    if (has_truth && one.name != "truth") {
      const gl::PictureError error = gl::picture_error(one.picture.image, pictures[0].picture.image);
      row["relative_l1"] = error.relative_l1;
      row["rmse"] = error.rmse;
      l1 = fmt::format("{:.2f} %", 100.0 * error.relative_l1);
      rmse = fmt::format("{:.5f}", error.rmse);
    }
    fmt::print("{:10} {:>12} {:>10} {:>10.1f}\n", one.name, l1, rmse, one.picture.frame_time_ms);
    rows.push_back(row);
  }
  return rows;
}

void write_report(const ViewOptions& options, const std::string& context, const nlohmann::json& pictures) {
  const gl::Brdf& brdf = options.scene.brdf;
  const bool is_phong = brdf.kind == gl::BrdfKind::kBlinnPhong;
  const nlohmann::json report = {{"software", std::string("multum-view ") + MULTUM_VERSION},
                                 {"context", context},
                                 {"width", options.width},
                                 {"height", options.height},
                                 {"truth_samples", options.samples},
                                 {"truth", "BRDF and max(n.l, 0) at every sample's own normal"},
                                 {"brdf", is_phong ? "blinn-phong" : "torrance-sparrow"},
                                 {is_phong ? "exponent" : "sigma", is_phong ? brdf.exponent : brdf.sigma},
                                 {"formula", options.formula == gl::LobeFormula::kProduct ? "product" : "paper"},
                                 {"moments", moment_shading_name(options.moments.value_or(kUsualMomentShading))},
                                 {"anisotropy", options.anisotropy},
                                 {"pictures", pictures}};
  write_text_file(options.report, report.dump(2) + "\n");
}

bool has_option(int argc, char** argv, std::string_view name) {
  return std::any_of(argv + 1, argv + argc, [&](std::string_view argument) {
    return argument == name || argument.substr(0, name.size() + 1) == std::string(name) + "=";
  });
}

int run(int argc, char** argv) {
  if (has_option(argc, argv, "--probe")) return run_probe(argc, argv);
  if (has_option(argc, argv, "--thumbnails")) return run_thumbnails(argc, argv);
  if (has_option(argc, argv, "--sample")) return run_inferred(argc, argv);
  int exit_code = 0;
  std::optional<ViewOptions> options = parse_view_options(argc, argv, &exit_code);
  if (!options.has_value()) return exit_code;
  check_outputs(*options);
  const BakedMap map = read_baked_map(options->input);
  check_options_of(*options, map.header);
  warn_of_sources(*options, map.header);
  const gl::MeshData mesh_data = make_mesh(*options);
  const gl::NormalImage source = needs_source(*options, map.header) ? read_source(*options, map) : gl::NormalImage{};
  const std::unique_ptr<gl::HeadlessContext> context = gl::make_headless_context(options->context);
  log_info(context->description());
  warn_of_wrong_anisotropy(*options, map.header, context->description());
  const gl::Mesh mesh(context->functions(), mesh_data);
  const std::vector<NamedPicture> pictures = draw_all(*options, context->functions(), mesh, map, source);
  const bool has_truth = pictures[0].name == "truth";
  const nlohmann::json rows = print_table(pictures, has_truth);
  write_picture(options->output,
                pictures.size() == 1 ? pictures[0].picture.image : compose(pictures, has_truth, options->exposure),
                options->exposure);
  if (!options->pictures.empty()) write_pictures(*options, pictures, has_truth);
  if (!options->report.empty()) write_report(*options, context->description(), rows);
  if (std::fflush(stdout) != 0) throw Error(ErrorCode::kEnvironment, "standard output cannot be written");
  return 0;
}

}  // namespace
}  // namespace multum

int main(int argc, char** argv) { return multum::run_guarded("multum-view", multum::run, argc, argv); }
