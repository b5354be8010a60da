// SPDX-License-Identifier: Apache-2.0
// Writes a job as TOML that users can edit. Every key is written, with an explanation where it is first used. Numbers
// have the fewest digits that give the same number.
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/fields/inference/job/animation_job.h"
#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

// Returns a TOML basic string with escaped quotes, backslashes and control characters.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      result += '\\';
      result += c;
    } else if (static_cast<unsigned char>(c) < 32 || c == 127) {
      result += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      result += c;
    }
  }
  return result + '"';
}

std::string list(const std::vector<std::string>& texts) {
  std::vector<std::string> items;
  for (const std::string& text : texts) items.push_back(quoted(text));
  return fmt::format("[{}]", fmt::join(items, ", "));
}

// TOML files must be UTF-8.
std::string relative_path(const std::string& path, const std::string& folder) {
  const fs::path whole = fs::absolute(path).lexically_normal();
  const fs::path base = fs::absolute(folder.empty() ? "." : folder).lexically_normal();
  return text_of_path(whole.lexically_proximate(base).string());
}

std::string matrix_text(const glm::dmat4& m) {
  std::string text = "[";
  for (int row = 0; row < 4; ++row)
    text += fmt::format("{}[{}, {}, {}, {}]", row == 0 ? "" : ", ", m[0][row], m[1][row], m[2][row], m[3][row]);
  return text + "]";
}

std::string settings_text(const AnimationJob& job, const std::string& folder) {
  return fmt::format(
      "# A job for multum infer; docs/reference/animation_jobs.md describes every key. Paths are relative to this "
      "file.\n\ngeometry = {}  # scene file: OBJ, glTF, GLB\nuv_set = {}  # texture coordinate set; 0 is "
      "TEXCOORD_0\nwidth = {}  # width of the pictures, in pixels\nheight = {}\ncryptomatte = {}  # prefix of the "
      "Cryptomatte channels\ndepth = {}  # channel with the distance along -z of camera space at the pixel centre, or "
      "empty if there is none\ndepth_tolerance = {}  # largest allowed relative difference of depths; a larger one is "
      "an error of the camera\nsupersampling = {}  # 1 to 8 sub-pixels along each side of a pixel\nradiance_max = {}  "
      "# "
      "brighter values are clipped to this value and counted\ncoverage_min = {}  # pixels of which an object covers "
      "less are left out\n",
      quoted(relative_path(job.geometry_file, folder)), job.uv_set, job.width, job.height, quoted(job.cryptomatte),
      quoted(job.depth), job.depth_tolerance, job.supersampling, job.radiance_max, job.coverage_min);
}

// Writes only values that differ from `defaults`, or all values if `with_comments` is set.
std::string texture_text(const AnimationTexture& t, const AnimationTexture& defaults, bool with_comments) {
  std::string text;
  const auto line = [&](const char* key, const auto& value, bool is_default, const char* comment) {
    if (is_default && !with_comments) return;
    text += fmt::format("{} = {}{}{}\n", key, value, with_comments ? "  # " : "", with_comments ? comment : "");
  };
  line("wrap", quoted(t.wrap), t.wrap == defaults.wrap, "\"clamp\" or \"periodic\"");
  line("stretch_max", t.stretch_max, t.stretch_max == defaults.stretch_max, "largest size of a texel, in pixels");
  line("resolution_scale", t.resolution_scale, t.resolution_scale == defaults.resolution_scale,
       "scale factor of each side, at most 8, applied after the stretch limit");
  line("power_of_two", t.power_of_two, t.power_of_two == defaults.power_of_two,
       "rounds each side up to a power of two");
  line("side_max", t.side_max, t.side_max == defaults.side_max, "largest side in texels, 1 to 16384");
  line("anisotropy", t.anisotropy, t.anisotropy == defaults.anisotropy, "anisotropy of the sampler, 1 to 16");
  line("pyramid_weight", t.pyramid_weight, t.pyramid_weight == defaults.pyramid_weight,
       "weight of the pyramidal regularisation; 0 switches it off");
  line("range_weight", t.range_weight, t.range_weight == defaults.range_weight,
       "weight of the range regularisation; 0 switches it off");
  return text;
}

std::string parameters_text(const AnimationJob& job) {
  std::string text = "\n# The dimensions of the parameter space.\n";
  for (const AnimationParameter& parameter : job.parameters)
    text += fmt::format(
        "[[parameter]]\nname = {}\ncount = {}  # number of samples\nview = {}  # moves the camera\nblock = {}  # "
        "number of neighbouring samples that share texture coordinates, if anything moves; 0 means all\n\n",
        quoted(parameter.name), parameter.count, parameter.is_view, parameter.block);
  return text;
}

std::string layers_text(const AnimationJob& job) {
  std::string text = "# Parts of the radiance that have their own textures; the passes of a layer are added.\n";
  for (const AnimationLayer& layer : job.layers)
    text += fmt::format(
        "[[layer]]\nname = {}\npasses = {}  # PASS reads the channels PASS.R, PASS.G and PASS.B; \"\" reads R, G and "
        "B\n"
        "depends_on = {}  # one texture serves all samples along other parameters\n\n",
        quoted(layer.name), list(layer.passes), list(layer.depends_on));
  return text;
}

std::string objects_text(const AnimationJob& job) {
  std::string text =
      "# Objects that get textures. Without layers, an object has all layers. [object.texture] overrides [texture].\n";
  for (const AnimationObject& object : job.objects) {
    text += fmt::format("[[object]]\nname = {}\nmesh = {}\ncryptomatte = {}\nindex = {}\nlayers = {}\n",
                        quoted(object.name), quoted(object.mesh), quoted(object.cryptomatte), object.index,
                        list(object.layers));
    const std::string texture = texture_text(object.texture, {}, false);
    if (!texture.empty()) text += "[object.texture]\n" + texture;
    text += "\n";
  }
  return text;
}

std::string cameras_text(const AnimationJob& job) {
  std::string text =
      "# Matrices are lists of rows and multiply column vectors. Cameras look along -z, and clip space is as in "
      "OpenGL.\n";
  for (const AnimationCamera& camera : job.cameras)
    text += fmt::format("[[camera]]\nname = {}\nworld_to_camera = {}\nprojection = {}\n\n", quoted(camera.name),
                        matrix_text(camera.world_to_camera), matrix_text(camera.projection));
  return text;
}

std::string sample_text(const AnimationJob& job, const AnimationSample& sample, const std::string& folder) {
  std::string text = fmt::format("[[sample]]\nat = [{}]\nname = {}\nradiance = {}\n", fmt::join(sample.at, ", "),
                                 quoted(sample.name), quoted(relative_path(sample.radiance, folder)));
  if (!sample.geometry.empty()) text += fmt::format("geometry = {}\n", quoted(relative_path(sample.geometry, folder)));
  if (!sample.object_index.empty())
    text += fmt::format("object_index = {}\n", quoted(relative_path(sample.object_index, folder)));
  text += fmt::format("camera = {}\n", quoted(job.cameras[static_cast<std::size_t>(sample.camera)].name));
  if (!sample.object_to_world.empty()) text += "[sample.object_to_world]\n";
  for (const auto& [mesh, matrix] : sample.object_to_world)
    text += fmt::format("{} = {}\n", quoted(mesh), matrix_text(matrix));
  return text + "\n";
}

}  // namespace

std::string animation_job_text(const AnimationJob& job, const std::string& folder) {
  std::string text = settings_text(job, folder);
  text +=
      "\n# Texture settings of all objects that have no [object.texture].\n[texture]\n" + texture_text({}, {}, true);
  text += parameters_text(job) + layers_text(job) + objects_text(job) + cameras_text(job);
  text += "# One sample for each point of the parameter grid. `at` lists its index along each parameter.\n";
  for (const AnimationSample& sample : job.samples) text += sample_text(job, sample, folder);
  return text;
}

}  // namespace multum
