// SPDX-License-Identifier: Apache-2.0
// Implements multum-view model, which draws a glTF model with its own materials. It uses the base colour, metallic and
// roughness factors in the BRDF of glTF. For a material that --material names, it draws the map that was baked from the
// material's normal texture.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <list>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "host/formats/image/colour_map.h"
#include "host/formats/mesh/gltf_material.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/shown_text.h"
#include "runtime_gl/materials/normal_material.h"
#include "tools/command_line/decoding_option.h"
#include "tools/multum_view/baked_map.h"
#include "tools/multum_view/modes.h"
#include "tools/multum_view/view_inputs.h"
#include "tools/multum_view/view_outputs.h"
#include "tools/multum_view/write_image.h"

namespace multum {
namespace {

constexpr float kRoughnessMin = 0.05f;           // minimum of Brdf
constexpr float kDielectricReflectance = 0.04f;  // glTF 2.0, appendix B

/// Parses NAME=FILE. The last "=" separates NAME from FILE, because a material's name may contain "=", but the name of
/// a baked file rarely does.
std::map<std::string, std::string> parse_materials(const std::vector<std::string>& words) {
  std::map<std::string, std::string> files;
  for (const std::string& word : words) {
    const std::size_t equals = word.rfind('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == word.size())
      throw Error(ErrorCode::kUsage, "--material is '" + word + "', expected NAME=FILE.ndf.exr");
    if (!files.emplace(word.substr(0, equals), word.substr(equals + 1)).second)
      throw Error(ErrorCode::kUsage, "--material names '" + word.substr(0, equals) + "' twice, expected once");
  }
  return files;
}

/// A temporary folder for images that are embedded in a model. The folder exists while the images are read.
class TemporaryImages {
 public:
  TemporaryImages() {
    std::string pattern = (std::filesystem::temp_directory_path() / "multum_view_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr)
      throw Error(ErrorCode::kEnvironment, pattern + ": cannot make this folder for the model's images");
    folder_ = pattern;
  }
  ~TemporaryImages() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  TemporaryImages(const TemporaryImages&) = delete;
  TemporaryImages& operator=(const TemporaryImages&) = delete;
  const std::string& folder() const { return folder_; }

 private:
  std::string folder_;
};

/// Returns the mean of each channel, in 0..1.
glm::vec3 mean_of(const GltfImage& image) {
  const TemporaryImages temporary;
  const ColourRows rows =
      read_colour_rows(extract_image(image, temporary.folder()), ColourEncoding::kData, {}, 1, nullptr);
  std::vector<float> row(static_cast<std::size_t>(rows.planes.width()));
  glm::dvec3 sum(0.0);
  for (int y = 0; y < rows.planes.height(); ++y)
    for (int c = 0; c < 3; ++c) {
      rows.planes.read_rows(c, y, 1, row.data());
      for (const float value : row) sum[c] += static_cast<double>(value);
    }
  return sum / (static_cast<double>(rows.planes.width()) * rows.planes.height());
}

/// Multiplies the factors by the means of glTF's metallic-roughness texture, which has roughness in green and metallic
/// in blue.
Brdf brdf_of(const GltfMaterials& model, GltfMaterial material) {
  if (material.metallic_roughness) {
    const glm::vec3 mean = mean_of(model.images[static_cast<std::size_t>(material.metallic_roughness->image)]);
    material.roughness *= mean.g;
    material.metallic *= mean.b;
  }
  const glm::vec3 colour(material.base_colour);
  Brdf brdf;
  brdf.kind = BrdfKind::kGgx;
  brdf.roughness = std::max(material.roughness, kRoughnessMin);
  brdf.diffuse = colour * (1.0f - material.metallic);
  brdf.f0 = glm::mix(glm::vec3(kDielectricReflectance), colour, material.metallic);
  brdf.specular = glm::vec3(1.0f);
  return brdf;
}

/// Returns the triangles of one material.
gl::MeshData part_data(const TriangleMesh& mesh, int material) {
  gl::MeshData data = to_mesh_data(mesh);
  data.indices.clear();
  for (const MeshPart& part : mesh.parts)
    if (part.material_index == material)
      data.indices.insert(data.indices.end(), mesh.indices.begin() + part.first_index,
                          mesh.indices.begin() + part.first_index + part.index_count);
  return data;
}

class Model {
 public:
  Model(const ModelOptions& options, const ViewScenes& scenes, const GltfMaterials& materials)
      : picture_(options.picture), scenes_(scenes), materials_(materials) {
    files_ = parse_materials(options.materials);
    std::set<std::string> names;
    for (const GltfMaterial& material : materials.materials) {
      names.insert(material.name);
      if (material.anisotropy > 0.0f && picture_.material.brdfs.empty())
        throw Error(
            ErrorCode::kInput,
            fmt::format("{}: material '{}' is anisotropic (KHR_materials_anisotropy, strength {}), expected materials "
                        "with only roughness, because lobes do not support anisotropy. --brdf sets another BRDF",
                        picture_.surface.mesh, material.name, material.anisotropy));
    }
    for (const auto& [name, file] : files_)
      if (names.count(name) == 0)
        throw Error(ErrorCode::kUsage, fmt::format("--material '{}': {} has no such material, expected one of: {}",
                                                   name, picture_.surface.mesh, fmt::join(names, ", ")));
  }

  const TriangleMesh& mesh(int uv_set) {
    const auto found = meshes_.find(uv_set);
    return found != meshes_.end() ? found->second
                                  : meshes_.emplace(uv_set, read_mesh(picture_.surface.mesh, uv_set)).first->second;
  }

  void upload(const gl::GlFunctions& gl) {
    const int count = static_cast<int>(materials_.materials.size());
    for (int i = 0; i <= count; ++i) {  // the last iteration draws triangles without a material
      const GltfMaterial material = i < count ? materials_.materials[static_cast<std::size_t>(i)] : GltfMaterial{};
      const gl::MeshData data = part_data(mesh(material.normal ? material.normal->uv_set : 0), i);
      if (data.indices.empty()) continue;
      parts_.emplace_back(gl, data);
      objects_.push_back({&parts_.back(), make(gl, material),
                          !picture_.material.brdfs.empty() ? scenes_.first.brdf : brdf_of(materials_, material)});
      write_shown(stdout, fmt::format("{}: {} triangles, {}\n", material.name.empty() ? "no material" : material.name,
                                      data.indices.size() / 3,
                                      files_.count(material.name) > 0 ? files_.at(material.name) : "no map"));
    }
  }
  const std::vector<gl::SceneObject>& objects() const { return objects_; }

 private:
  const gl::Material* make(const gl::GlFunctions& gl, const GltfMaterial& material) {
    const auto file = files_.find(material.name);
    if (file == files_.end()) {
      surfaces_.push_back(std::make_unique<gl::NormalMaterial>(gl, gl::NormalImage{1, 1, {{0.0f, 0.0f, 1.0f}}, {}},
                                                               gl::NormalMaterial::Sampling::kNearest, 1.0f));
      return surfaces_.back().get();
    }
    const BakedMap map = read_baked_map(file->second);
    check_options_of(file->second, picture_, scenes_, false, map.header);
    if (map.header.first_level > 0)
      throw Error(ErrorCode::kInput,
                  file->second + ": does not contain level 0, expected files with all levels for --material");
    surfaces_.push_back(make_material(gl, map, picture_.shading, {}));
    return surfaces_.back().get();
  }

  const PictureOptions& picture_;
  const ViewScenes& scenes_;
  const GltfMaterials& materials_;
  std::map<std::string, std::string> files_;
  std::map<int, TriangleMesh> meshes_;  // by texture coordinate set
  std::list<gl::Mesh> parts_;
  std::vector<std::unique_ptr<gl::Material>> surfaces_;
  std::vector<gl::SceneObject> objects_;
};

}  // namespace

void add_model_options(CLI::App& app, ModelOptions& options) {
  PictureOptions& picture = options.picture;
  app.add_option("model", picture.surface.mesh, "model to draw: glTF or GLB")->required();
  app.add_option("--material", options.materials,
                 "draw the material NAME with a baked map, NAME=FILE.ndf.exr; give one per material (`multum "
                 "materials` lists them)");
  add_picture_option(app, picture.output)->required();
  add_repeat_option(app, picture.surface);
  add_camera_options(app, picture.camera);
  add_distance_option(app, picture.camera);
  add_rendering_options(app, picture);
  add_decoding_option(app);
}

int draw_model(const ModelOptions& options) {
  const PictureOptions& picture = options.picture;
  check_picture_path(picture.output.path);
  ViewScenes scenes = make_scenes(picture);
  std::vector<std::string> outputs = {picture.output.report};
  for (const View& view : views_of(picture, scenes.first)) outputs.push_back(view.output.path);
  const std::string& file = picture.surface.mesh;
  check_paths_differ({file}, outputs);
  const GltfMaterials materials = read_gltf_materials(file);
  Model model(options, scenes, materials);
  frame_mesh(model.mesh(0), file, picture.output, scenes);
  scenes.first.uv_scale = picture.surface.repeat.value_or(1.0f);
  scenes.first.environment = read_environment(picture.light);
  const std::unique_ptr<gl::HeadlessContext> context = gl::make_headless_context(picture.context);
  log_info(context->description());
  model.upload(context->functions());
  gl::Renderer renderer(context->functions(), picture.output.width(), picture.output.height());
  const nlohmann::json rows =
      draw_views(picture, scenes.first, [&](const gl::RenderScene& scene) -> std::vector<NamedPicture> {
        return {{"multum", renderer.draw(model.objects(), scene), background_of(picture, scene)}};
      });
  if (!picture.output.report.empty()) write_report(picture, scenes.first, {*context}, rows);
  return 0;
}

}  // namespace multum
