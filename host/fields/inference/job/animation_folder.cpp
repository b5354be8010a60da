// SPDX-License-Identifier: Apache-2.0
// Reads folders of renders in the layout that the scripts of the ray-traced fields write
// (docs/reference/animation_jobs.md, "Supported folders"). scene.json lists the renders; file names follow from the
// names of samples.
//   rad_vVV_pPP.exr   radiance by passes       geom_vVV.exr      depth, Cryptomatte
//   scene.json        cameras, objects         id_vVV_pPP.png    object index, where an object moves
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>

#include "host/fields/inference/job/animation_job.h"
#include "host/fields/inference/job/animation_samples.h"
#include "host/formats/image/files/exr_layers.h"
#include "host/formats/mesh/object_mesh.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;  // objects are numbered in the order of the file

constexpr const char* kExpected =
    "expected a folder of renders with scene.json, geometry.glb, .gltf or .obj, rad_vVV_pPP.exr, and geom_vVV.exr or "
    "id_vVV_pPP.png";

// Returns the number of samples along a parameter that share texture coordinates. These are either all samples, or even
// blocks of at most 16 samples. Hakura et al. (sec. 4) use blocks of 8 samples. But with two blocks, diffuse textures
// are packed twice. If one block contains all 16 views, the error of field_demo2 at 192:1 is 0.88 times its error with
// two blocks.
int even_block(int count) {
  constexpr int kBlockMax = 16;
  if (count <= kBlockMax) return 0;
  const int blocks = (count + kBlockMax - 1) / kBlockMax;
  return (count + blocks - 1) / blocks;
}

class FolderReader {
 public:
  explicit FolderReader(const std::string& folder) : folder_(folder), scene_path_(path("scene.json")) {
    std::error_code error;
    if (!fs::is_directory(folder, error)) refuse_file(folder, std::string("is not a folder; ") + kExpected);
    if (!exists("scene.json")) refuse_file(folder, std::string("holds no scene.json; ") + kExpected);
    scene_ = Json::parse(json_of_file(scene_path_).value_or(""), nullptr, false);
    if (!scene_.is_object()) refuse_file(scene_path_, "is not a JSON object");
  }

  AnimationJob read() {
    job_.path = path("animation.toml");
    job_.width = whole(scene_, "width", "the scene");
    job_.height = whole(scene_, "height", "the scene");
    read_geometry();
    const Json& samples = list("samples");
    moves_ = std::any_of(samples.begin(), samples.end(),
                         [](const Json& sample) { return sample.contains("object_to_world"); });
    has_index_ = exists("id_" + sample_name(samples.front()) + ".png");
    if (moves_ && !has_index_)
      refuse_file(
          folder_,
          fmt::format(
              "has objects that move, but no id_{}.png; expected object-index images, which moving objects need",
              sample_name(samples.front())));
    const char* other = moves_ ? "motion" : samples.front().contains("light_swing_deg") ? "light" : "parameter";
    job_.parameters = {{"view", whole(scene_, "views", "the scene"), true},
                       {other, whole(scene_, "params", "the scene"), false}};
    for (AnimationParameter& parameter : job_.parameters) parameter.block = even_block(parameter.count);
    read_objects();
    for (const Json& sample : samples) read_sample(sample);
    std::sort(job_.samples.begin(), job_.samples.end(),
              [](const AnimationSample& a, const AnimationSample& b) { return a.at < b.at; });
    const int expected = job_.parameters[0].count * job_.parameters[1].count;
    if (std::ssize(job_.samples) != expected)
      refuse_file(scene_path_, fmt::format("describes {} samples, expected {} from its views and params",
                                           job_.samples.size(), expected));
    read_layers();
    return std::move(job_);
  }

 private:
  std::string path(const std::string& name) const { return (fs::path(folder_) / name).lexically_normal().string(); }
  bool exists(const std::string& name) const {
    std::error_code error;
    return fs::is_regular_file(path(name), error);
  }
  std::string existing(const std::string& name) const {
    if (!exists(name)) refuse_file(folder_, fmt::format("has no {}, although scene.json describes it", name));
    return path(name);
  }

  const Json& member(const Json& json, const char* key, const std::string& what) const {
    const auto found = json.find(key);
    if (found == json.end()) refuse_file(scene_path_, fmt::format("{} has no \"{}\"", what, key));
    return *found;
  }
  int whole(const Json& json, const char* key, const std::string& what) const {
    const Json& value = member(json, key, what);
    if (!value.is_number_integer() || value.get<std::int64_t>() < 0 || value.get<std::int64_t>() > 65536)
      refuse_file(scene_path_, fmt::format("\"{}\" of {} is {}, expected an integer", key, what, value.dump()));
    return value.get<int>();
  }
  const Json& list(const char* key) const {
    const Json& value = member(scene_, key, "the scene");
    const bool is_list = value.is_array() && !value.empty() && value.front().is_object();
    if (!is_list) refuse_file(scene_path_, fmt::format("\"{}\" is not a list of objects", key));
    return value;
  }
  std::string sample_name(const Json& sample) const {
    const Json& name = member(sample, "name", "a sample");
    if (!name.is_string()) refuse_file(scene_path_, fmt::format("the name of a sample is {}", name.dump()));
    return name.get<std::string>();
  }
  glm::dmat4 matrix(const Json& rows, const std::string& what) const {
    const auto is_row = [](const Json& row) {
      return row.is_array() && row.size() == 4 &&
             std::all_of(row.begin(), row.end(), [](const Json& value) { return value.is_number(); });
    };
    if (!rows.is_array() || rows.size() != 4 || !std::all_of(rows.begin(), rows.end(), is_row))
      refuse_file(scene_path_, what + " is not a matrix of 4 rows of 4 numbers");
    glm::dmat4 m;
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 4; ++column)
        m[column][row] = rows[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)].get<double>();
    return m;
  }

  void read_geometry() {
    for (const char* name : {"geometry.glb", "geometry.gltf", "geometry.obj"}) {
      if (!exists(name)) continue;
      job_.geometry_file = path(name);
      meshes_ = names_of(read_object_meshes(job_.geometry_file, job_.uv_set));
      return;
    }
    refuse_file(folder_, std::string("holds no geometry.glb, geometry.gltf or geometry.obj; ") + kExpected);
  }

  // Blender's OBJ export names an object after the object and its mesh.
  std::string mesh_of(const std::string& object) const {
    for (const std::string& mesh : {object, object + "_Mesh"})
      if (std::find(meshes_.begin(), meshes_.end(), mesh) != meshes_.end()) return mesh;
    refuse_file(job_.geometry_file,
                fmt::format("has no object \"{}\", although scene.json names it; its objects are {}", object,
                            fmt::join(meshes_, ", ")));
  }

  void read_objects() {
    const Json& objects = member(scene_, "objects", "the scene");
    if (!objects.is_object() || objects.empty()) refuse_file(scene_path_, "\"objects\" names no objects");
    for (const auto& [name, value] : objects.items()) {
      AnimationObject object;
      object.name = name;
      object.mesh = mesh_of(name);
      if (has_index_) {
        object.index = static_cast<int>(job_.objects.size()) + 1;
      } else {
        object.cryptomatte = name;
      }
      job_.objects.push_back(object);
    }
  }

  // Samples of one view have the same camera, unless the camera shakes.
  int camera_of(const Json& sample, const std::string& name, int view) {
    AnimationCamera camera;
    camera.world_to_camera = matrix(member(sample, "world_to_camera", name), name + ": world_to_camera");
    camera.projection = matrix(member(sample, "projection", name), name + ": projection");
    for (std::size_t i = 0; i < job_.cameras.size(); ++i)
      if (job_.cameras[i].world_to_camera == camera.world_to_camera && job_.cameras[i].projection == camera.projection)
        return static_cast<int>(i);
    const std::vector<std::string> taken = names_of(job_.cameras);
    camera.name = fmt::format("v{:02}", view);
    if (std::find(taken.begin(), taken.end(), camera.name) != taken.end()) camera.name = name;
    job_.cameras.push_back(camera);
    return static_cast<int>(job_.cameras.size()) - 1;
  }

  void read_sample(const Json& json) {
    AnimationSample sample;
    sample.name = sample_name(json);
    const int view = whole(json, "view", sample.name), param = whole(json, "param", sample.name);
    sample.at = {view, param};
    sample.radiance = existing("rad_" + sample.name + ".exr");
    // If objects move, only the first sample of each view has geometry.
    const std::string geometry = fmt::format("geom_v{:02}.exr", view);
    if (!has_index_ || (exists(geometry) && (!moves_ || param == 0))) sample.geometry = existing(geometry);
    if (has_index_) sample.object_index = existing("id_" + sample.name + ".png");
    sample.camera = camera_of(json, sample.name, view);
    const auto motion = json.find("object_to_world");
    if (motion != json.end()) read_motion(*motion, sample);
    job_.samples.push_back(sample);
  }

  // An OBJ file is in world space, with objects placed as in "objects" of scene.json. The placement of each sample
  // replaces this placement.
  void read_motion(const Json& motion, AnimationSample& sample) {
    const bool is_in_world = job_.geometry_file.ends_with(".obj");
    for (const auto& [name, rows] : motion.items()) {
      glm::dmat4 placement = matrix(rows, sample.name + ": object_to_world of " + name);
      if (is_in_world) {
        const Json& object = member(member(scene_, "objects", "the scene"), name.c_str(), "\"objects\"");
        const Json& rest = member(object, "object_to_world", name);
        placement = placement * glm::inverse(matrix(rest, name + ": object_to_world"));
      }
      sample.object_to_world[mesh_of(name)] = placement;
    }
  }

  // Diffuse light depends on moving objects and lights, but not on the view.
  void read_layers() {
    const std::string& file = job_.samples.front().radiance;
    const std::vector<std::string> channels = exr_channel_names(file);
    const auto has = [&](const std::string& channel) {
      return std::find(channels.begin(), channels.end(), channel) != channels.end();
    };
    const std::vector<std::string> all = names_of(job_.parameters);
    if (has("diffuse.R")) job_.layers.push_back({"diffuse", {"diffuse"}, {all[1]}});
    AnimationLayer view_dependent{"view_dependent", {}, all};
    for (const char* pass : {"glossy", "transmission"})
      if (has(std::string(pass) + ".R")) view_dependent.passes.emplace_back(pass);
    if (!view_dependent.passes.empty()) job_.layers.push_back(view_dependent);
    if (job_.layers.empty() && has("R")) job_.layers.push_back({"radiance", {""}, all});
    if (job_.layers.empty())
      refuse_file(file, fmt::format("has no channel diffuse.R, glossy.R, transmission.R or R; its channels are {}",
                                    fmt::join(channels, ", ")));
  }

  std::string folder_, scene_path_;
  Json scene_;
  AnimationJob job_;
  std::vector<std::string> meshes_;
  bool moves_ = false, has_index_ = false;
};

}  // namespace

AnimationJob job_for_folder(const std::string& folder) { return FolderReader(folder).read(); }

}  // namespace multum
