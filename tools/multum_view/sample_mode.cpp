// SPDX-License-Identifier: Apache-2.0
// multum-view sample: draws points of the parameter space with inferred textures.
#include <fmt/format.h>
#include <filesystem>
#include <set>

#include "host/asset/inferred/find_sample.h"
#include "host/asset/inferred/inferred_texture.h"
#include "host/base/error.h"
#include "host/base/files/content_hash.h"
#include "host/base/files/output_paths.h"
#include "host/base/log.h"
#include "host/mesh/object_mesh.h"
#include "runtime_gl/animation/textured_renderer.h"
#include "runtime_gl/context/headless_context.h"
#include "tools/multum_view/modes.h"
#include "tools/multum_view/object_meshes.h"
#include "tools/multum_view/write_image.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

// No picture takes the place of the manifest, the geometry or any texture, also of samples that are not drawn now.
void check_outputs(const InferredManifest& manifest, const fs::path& folder, const std::vector<std::string>& outputs) {
  std::set<std::string> names = {kInferredManifestName, manifest.geometry_file};
  for (const InferredObject& object : manifest.objects)
    for (const InferredLayer& layer : object.layers) names.insert(layer.textures.begin(), layer.textures.end());
  std::set<fs::path> inputs;  // of one spelling each: a folder may hold as many textures as there are samples
  for (const std::string& name : names)
    if (!name.empty()) inputs.insert(fs::weakly_canonical(folder / name));
  for (const std::string& output : outputs)
    if (inputs.count(fs::weakly_canonical(output)) > 0)
      throw Error(ErrorCode::kUsage, output + ": is read, expected the name of another file to write");
  check_paths_differ({}, outputs);
  for (const std::string& output : outputs) check_writable(output);
}

gl::Texture upload(const gl::GlFunctions& gl, const std::string& path, const TextureMapping& mapping,
                   float anisotropy) {
  const InferredTexture texture = read_inferred_texture(path);
  if (texture.width != mapping.width || texture.height != mapping.height)
    throw Error(ErrorCode::kInput, fmt::format("{}: is {} x {} texels, the manifest says {} x {}", path, texture.width,
                                               texture.height, mapping.width, mapping.height));
  const MipLayout layout(texture.width, texture.height);
  gl::Texture uploaded(gl, path, {texture.width, texture.height, layout.level_count(), gl::TexelFormat::kRgba16f},
                       {mapping.wrap_s, mapping.wrap_t, true, anisotropy});
  for (int l = 0; l < layout.level_count(); ++l) {
    const MipLevelPlace& level = layout.levels[static_cast<std::size_t>(l)];
    std::vector<float> rgba;
    for (int t = level.offset; t < level.offset + level.width * level.height; ++t) {
      for (int c = 0; c < 3; ++c) rgba.push_back(texture.texels[static_cast<std::size_t>(3 * t + c)]);
      rgba.push_back(1.0f);
    }
    uploaded.upload_level(l, rgba.data());
  }
  return uploaded;
}

// What stays from picture to picture.
class InferredScene {
 public:
  InferredScene(const gl::GlFunctions& gl, const InferredManifest& manifest, const std::string& folder)
      : gl_(gl),
        manifest_(manifest),
        folder_(folder),
        renderer_(gl, manifest.width, manifest.height, manifest.supersampling) {
    const std::string geometry = (fs::path(folder) / manifest.geometry_file).string();
    if (hash_file(geometry) != manifest.geometry_hash)
      throw Error(ErrorCode::kInput, geometry + ": is not the geometry that textures were inferred for (SHA-256 " +
                                         manifest.geometry_hash + ")");
    meshes_ = read_object_meshes(geometry, manifest.uv_set);
    for (const InferredObject& object : manifest.objects) {
      places_.push_back(find_object(meshes_, object.mesh, geometry));
      drawn_.emplace_back();
      for (const TextureMapping& mapping : object.mappings)
        drawn_.back().push_back(std::make_unique<gl::Mesh>(gl, mapped_mesh_data(meshes_[places_.back()], mapping)));
    }
  }

  gl::FloatImage draw(std::size_t number) {
    const InferredSample& sample = manifest_.samples[number];
    std::vector<gl::Texture> textures;
    std::size_t layer_count = 0;
    for (const InferredObject& object : manifest_.objects) layer_count += object.layers.size();
    textures.reserve(layer_count);
    std::vector<gl::TexturedObject> objects;
    for (std::size_t i = 0; i < manifest_.objects.size(); ++i) {
      const InferredObject& object = manifest_.objects[i];
      const auto mapping = static_cast<std::size_t>(object.mapping_of_sample[number]);
      gl::TexturedObject textured{
          {drawn_[i][mapping].get(),
           object_to_clip(sample.world_to_clip, object_place(meshes_[places_[i]], sample.object_to_world))},
          {}};
      for (const InferredLayer& layer : object.layers) {
        if (layer.textures[number].empty()) continue;
        textures.push_back(upload(gl_, (fs::path(folder_) / layer.textures[number]).string(), object.mappings[mapping],
                                  object.anisotropy));
        textured.layers.push_back(&textures.back());
      }
      objects.push_back(textured);
    }
    return renderer_.draw(objects);
  }

 private:
  const gl::GlFunctions& gl_;
  const InferredManifest& manifest_;
  std::string folder_;
  gl::TexturedRenderer renderer_;
  std::vector<ObjectMesh> meshes_;
  std::vector<std::size_t> places_;
  std::vector<std::vector<std::unique_ptr<gl::Mesh>>> drawn_;  // [object][mapping]
};

}  // namespace

void add_sample_options(CLI::App& app, SampleOptions& options) {
  app.add_option("folder", options.folder, "what multum infer wrote, or its inferred.json")->required();
  app.add_option("--at", options.samples,
                 "sample to draw: its index along each parameter, e.g. 3,5, or its name; repeatable, with as many -o")
      ->required()
      ->allow_extra_args(false);  // or it takes the folder, where that comes last
  app.add_option("-o,--output", options.outputs, "picture of each sample: .png (sRGB) or .exr (linear floats)")
      ->required()
      ->allow_extra_args(false);
  app.add_option("--exposure", options.exposure, "brightness of a PNG")
      ->check(number_in(1e-6f, 1e6f))
      ->capture_default_str();
  add_context_option(app, options.context);
}

int draw_samples(const SampleOptions& options) {
  if (options.samples.size() != options.outputs.size())
    throw Error(ErrorCode::kUsage, fmt::format("{} samples and {} --output: expected one output for each sample",
                                               options.samples.size(), options.outputs.size()));
  for (const std::string& output : options.outputs) check_picture_path(output);
  fs::path folder(options.folder);
  if (folder.filename() == kInferredManifestName) folder = folder.parent_path();
  const InferredManifest manifest = read_inferred_manifest((folder / kInferredManifestName).string());
  check_outputs(manifest, folder, options.outputs);
  std::vector<std::size_t> samples;
  for (const std::string& sample : options.samples)
    samples.push_back(find_sample(manifest.samples, manifest.parameters, sample));
  const auto context = gl::make_headless_context(options.context);
  log_info(context->description());
  InferredScene scene(context->functions(), manifest, folder.string());
  for (std::size_t i = 0; i < samples.size(); ++i)
    write_picture(options.outputs[i], scene.draw(samples[i]), options.exposure);
  return 0;
}

}  // namespace multum
