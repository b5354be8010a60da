// SPDX-License-Identifier: Apache-2.0
// Implements multum-view sample, which draws samples of an animation with inferred textures.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <filesystem>
#include <list>
#include <map>
#include <set>

#include "host/fields/codec/field_unpacking.h"
#include "host/fields/inferred/find_sample.h"
#include "host/fields/inferred/inferred_texture.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/log.h"
#include "runtime_gl/animation/textured_renderer.h"
#include "runtime_gl/context/headless_context.h"
#include "tools/multum_view/fields/animation_geometry.h"
#include "tools/multum_view/modes.h"
#include "tools/multum_view/write_image.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

/// The source of the drawn samples' textures, which is a folder or a packed field.
class TextureSource {
 public:
  virtual ~TextureSource() = default;
  virtual const InferredManifest& manifest() const = 0;
  /// The folder to which the names in the manifest are relative.
  virtual fs::path folder() const = 0;
  /// Returns all input files, including the files of samples that this run does not draw.
  virtual std::set<fs::path> files() const = 0;
  /// Returns the texture and its name for each layer that the object has at the sample.
  virtual std::vector<std::pair<std::string, InferredTexture>> textures(std::size_t object, std::size_t sample) = 0;
};

class FolderTextures : public TextureSource {
 public:
  explicit FolderTextures(fs::path folder)
      : folder_(std::move(folder)), manifest_(read_inferred_manifest((folder_ / kInferredManifestName).string())) {}
  const InferredManifest& manifest() const override { return manifest_; }
  fs::path folder() const override { return folder_; }
  std::set<fs::path> files() const override {
    std::set<std::string> names = {kInferredManifestName};
    for (const InferredObject& object : manifest_.objects)
      for (const InferredLayer& layer : object.layers) names.insert(layer.textures.begin(), layer.textures.end());
    std::set<fs::path> paths;  // a set, to remove duplicates; a folder can contain one texture per sample
    for (const std::string& name : names)
      if (!name.empty()) paths.insert(folder_ / name);
    return paths;
  }
  std::vector<std::pair<std::string, InferredTexture>> textures(std::size_t object, std::size_t sample) override {
    std::vector<std::pair<std::string, InferredTexture>> found;
    for (const InferredLayer& layer : manifest_.objects[object].layers) {
      if (layer.textures[sample].empty()) continue;
      const std::string path = (folder_ / layer.textures[sample]).string();
      found.emplace_back(path, read_inferred_texture(path));
    }
    return found;
  }

 private:
  fs::path folder_;
  InferredManifest manifest_;
};

/// The textures of a packed field. Reads chunks on demand, skips damaged chunks, and reports them.
class PackedTextures : public TextureSource {
 public:
  explicit PackedTextures(const std::string& path) : path_(path), file_(path) {}
  const InferredManifest& manifest() const override { return file_.description().field; }
  fs::path folder() const override { return fs::path(path_).parent_path(); }
  std::set<fs::path> files() const override { return {path_}; }
  std::vector<std::pair<std::string, InferredTexture>> textures(std::size_t object, std::size_t sample) override {
    std::vector<std::pair<std::string, InferredTexture>> found;
    const std::vector<PackedLayer>& layers = file_.description().layers;
    for (std::size_t l = 0; l < layers.size(); ++l) {
      if (layers[l].object != object || !layers[l].is_seen(sample)) continue;
      const std::vector<int>& at = manifest().samples[sample].at;
      const std::size_t block = layers[l].block_at(at);
      if (const TextureChunk* decoded = chunk(l, block))
        found.emplace_back(path_ + ": " + layers[l].name,
                           unpacked_texture(*decoded, layers[l].blocks[block].chunk_sample(at), ""));
    }
    return found;
  }
  /// Throws Error(kVerification) that names the chunks that were skipped.
  void refuse_damage() const {
    if (damaged_.empty()) return;
    throw Error(ErrorCode::kVerification, fmt::format("damaged parts are left out, and everything else is drawn:\n{}",
                                                      fmt::join(damaged_, "\n")));
  }

 private:
  const TextureChunk* chunk(std::size_t layer, std::size_t block) {
    const auto [entry, is_new] = chunks_.try_emplace({layer, block});
    if (is_new) {
      try {
        entry->second = file_.chunk(layer, block);
      } catch (const Error& damaged) {
        damaged_.emplace_back(damaged.what());
      }
    }
    return entry->second.get();
  }

  std::string path_;
  PackedFieldFile file_;
  std::map<std::pair<std::size_t, std::size_t>, std::unique_ptr<TextureChunk>> chunks_;  // by layer and block
  std::vector<std::string> damaged_;
};

// Refuses pictures that would overwrite an input file.
void check_outputs(const TextureSource& source, const std::vector<std::string>& outputs) {
  std::set<fs::path> inputs = {fs::weakly_canonical(source.folder() / source.manifest().geometry_file)};
  for (const fs::path& file : source.files()) inputs.insert(fs::weakly_canonical(file));
  for (const std::string& output : outputs)
    if (inputs.count(fs::weakly_canonical(output)) > 0)
      throw Error(ErrorCode::kUsage, output + ": is an input, expected another file name for the output");
  check_paths_differ({}, outputs);
  for (const std::string& output : outputs) check_writable(output);
}

gl::Texture upload(const gl::GlFunctions& gl, const std::string& path, const InferredTexture& texture,
                   const TextureMapping& mapping, float anisotropy) {
  if (texture.width != mapping.width || texture.height != mapping.height)
    throw Error(ErrorCode::kInput, fmt::format("{}: is {} x {} texels, expected {} x {} as in the manifest", path,
                                               texture.width, texture.height, mapping.width, mapping.height));
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

// The state that all pictures share.
class InferredScene {
 public:
  InferredScene(const gl::GlFunctions& gl, TextureSource& source)
      : gl_(gl),
        source_(source),
        manifest_(source.manifest()),
        renderer_(gl, manifest_.width, manifest_.height, manifest_.supersampling),
        geometry_(gl, manifest_, source.folder().string()) {}

  gl::FloatImage draw(std::size_t number) {
    std::list<gl::Texture> textures;
    std::vector<gl::TexturedObject> objects;
    for (std::size_t i = 0; i < manifest_.objects.size(); ++i) {
      const InferredObject& object = manifest_.objects[i];
      const auto mapping = static_cast<std::size_t>(object.mapping_of_sample[number]);
      gl::TexturedObject textured{{&geometry_.mesh(i, mapping),
                                   object_to_clip(manifest_.samples[number].world_to_clip, geometry_.place(i, number))},
                                  {}};
      for (const auto& [path, texture] : source_.textures(i, number)) {
        textures.push_back(upload(gl_, path, texture, object.mappings[mapping], object.anisotropy));
        textured.layers.push_back(&textures.back());
      }
      objects.push_back(textured);
    }
    return renderer_.draw(objects);
  }

 private:
  const gl::GlFunctions& gl_;
  TextureSource& source_;
  const InferredManifest& manifest_;
  gl::TexturedRenderer renderer_;
  AnimationGeometry geometry_;
};

void draw_all(const SampleOptions& options, TextureSource& source) {
  check_outputs(source, options.outputs);
  std::vector<std::size_t> samples;
  for (const std::string& sample : options.samples)
    samples.push_back(find_sample(source.manifest().samples, source.manifest().parameters, sample));
  const auto context = gl::make_headless_context(options.context);
  log_info(context->description());
  InferredScene scene(context->functions(), source);
  for (std::size_t i = 0; i < samples.size(); ++i)
    write_picture(options.outputs[i], scene.draw(samples[i]), options.exposure);
}

}  // namespace

void add_sample_options(CLI::App& app, SampleOptions& options) {
  app.add_option("folder", options.folder,
                 "folder written by `multum infer`, its inferred.json, or a packed field, *.mpt")
      ->required();
  app.add_option("--at", options.samples,
                 "draw the sample with this name or with these indices along the parameters, such as 3,5; can be "
                 "repeated, with one -o per sample")
      ->required()
      ->allow_extra_args(false);  // otherwise the option would also take the folder at the end
  app.add_option("-o,--output", options.outputs,
                 "picture to write for each sample: .png (sRGB) or .exr (linear floats)")
      ->required()
      ->allow_extra_args(false);
  app.add_option("--exposure", options.exposure, "multiply the brightness of PNG pictures by this")
      ->check(number_in(1e-6f, 1e6f))
      ->capture_default_str();
  add_context_option(app, options.context);
}

int draw_samples(const SampleOptions& options) {
  if (options.samples.size() != options.outputs.size())
    throw Error(ErrorCode::kUsage, fmt::format("found {} samples and {} --output, expected one output for each sample",
                                               options.samples.size(), options.outputs.size()));
  for (const std::string& output : options.outputs) check_picture_path(output);
  if (is_packed_field(options.folder)) {
    PackedTextures packed(options.folder);
    draw_all(options, packed);
    packed.refuse_damage();
    return 0;
  }
  fs::path folder(options.folder);
  if (folder.filename() == kInferredManifestName) folder = folder.parent_path();
  FolderTextures textures(folder);
  draw_all(options, textures);
  return 0;
}

}  // namespace multum
