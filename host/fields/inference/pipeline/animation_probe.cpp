// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/pipeline/animation_probe.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/fields/inferred/matrix_json.h"
#include "host/fields/inferred/probe_request.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/files/work_folder.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/processes/viewer_process.h"

namespace multum {
namespace {

constexpr std::uint64_t kUnitsAMatrix = 4;  // units of progress per matrix: measuring one takes about as long as four
                                            // solutions

}  // namespace

AnimationProbe::AnimationProbe(const ParameterizedScene& field, ObjectMappings mappings, ProbeSettings settings)
    : field_(field),
      mappings_(std::move(mappings)),
      settings_(std::move(settings)),
      geometry_hash_(hash_file(field.job().geometry_file)) {}

std::string AnimationProbe::path(int pose, std::size_t object) const {
  return fmt::format("{}/{}_{}.fmx", settings_.folder, field_.poses()[static_cast<std::size_t>(pose)].name,
                     field_.job().objects[object].name);
}

int AnimationProbe::supersampling() const {
  return settings_.supersampling > 0 ? settings_.supersampling : field_.job().supersampling;
}

double AnimationProbe::anisotropy(std::size_t object) const {
  return settings_.anisotropy > 0.0 ? settings_.anisotropy : field_.job().objects[object].texture.anisotropy;
}

std::uint64_t AnimationProbe::unit_count() const {
  std::uint64_t units = 0;
  for (std::size_t p = 0; p < field_.poses().size(); ++p) units += unit_count(static_cast<int>(p));
  return units;
}

std::uint64_t AnimationProbe::unit_count(int pose) const {
  std::uint64_t seen = 0;
  for (std::size_t k = 0; k < mappings_.size(); ++k) seen += mapping_at(pose, k).width > 0 ? 1 : 0;
  return kUnitsAMatrix * seen;
}

const TextureMapping& AnimationProbe::mapping_at(int pose, std::size_t object) const {
  return mapping(object, field_.poses()[static_cast<std::size_t>(pose)].block);
}

std::string AnimationProbe::key(int pose, std::size_t object) const {
  const AnimationPose& at = field_.poses()[static_cast<std::size_t>(pose)];
  nlohmann::json moved = nlohmann::json::object();
  for (const auto& [name, matrix] : at.object_to_world) moved[name] = matrix_json(matrix);
  const nlohmann::json json = {{"probe", 1},
                               {"geometry", geometry_hash_},
                               {"uvSet", field_.job().uv_set},
                               {"width", field_.job().width},
                               {"height", field_.job().height},
                               {"supersampling", supersampling()},
                               {"worldToClip", matrix_json(field_.world_to_clip(pose))},
                               {"objectToWorld", moved},
                               {"object", field_.job().objects[object].mesh},
                               {"mapping", mapping_at(pose, object)},
                               {"anisotropy", anisotropy(object)},
                               {"context", settings_.context},
                               {"hasMips", settings_.has_mips}};
  return hash_text(json.dump());
}

void AnimationProbe::run(Progress* progress) {
  make_folder(settings_.folder);
  WorkFolder::sweep(settings_.folder);  // runs even if all matrices exist already
  for (std::size_t p = 0; p < field_.poses().size(); ++p) {
    const int pose = static_cast<int>(p);
    progress_stage(progress, fmt::format("probe {} of {}", p + 1, field_.poses().size()));
    std::vector<std::size_t> wanted;
    for (std::size_t k = 0; k < mappings_.size(); ++k)
      if (mapping_at(pose, k).width > 0 && !is_there(pose, k)) wanted.push_back(k);
    if (!wanted.empty()) measure(pose, wanted, progress);
    measured += static_cast<int>(wanted.size());
    progress_advance(progress, unit_count(pose));
  }
}

bool AnimationProbe::is_there(int pose, std::size_t object) const {
  if (filter_matrix_key(path(pose, object)) != key(pose, object)) return false;
  try {
    matrix(pose, object);  // throws unless the matrix is complete
    return true;
  } catch (const Error& damage) {
    log_named_warning(fmt::format("{}; it is measured again", damage.what()));
    return false;
  }
}

void AnimationProbe::measure(int pose, const std::vector<std::size_t>& objects, Progress* progress) const {
  const AnimationPose& at = field_.poses()[static_cast<std::size_t>(pose)];
  ProbeRequest request;
  request.geometry_file = std::filesystem::absolute(field_.job().geometry_file).string();
  request.uv_set = field_.job().uv_set;
  request.width = field_.job().width;
  request.height = field_.job().height;
  request.supersampling = supersampling();
  request.view = at.name;
  request.world_to_clip = field_.world_to_clip(pose);
  request.object_to_world = at.object_to_world;
  for (const std::size_t k : objects) {
    request.tasks.push_back({field_.job().objects[k].mesh, mapping_at(pose, k), static_cast<float>(anisotropy(k)),
                             settings_.has_mips, path(pose, k), key(pose, k)});
  }
  // The folder is private, because another process may measure the same pose. The folder is always removed at the end.
  const std::unique_ptr<WorkFolder> work = WorkFolder::make(settings_.folder);
  const std::string file = work->path() + "/request.probe.json";
  write_probe_request(request, file);
  std::vector<std::string> command = {settings_.viewer, "probe", file, "--context", settings_.context};
  if (settings_.threads > 0) {
    command.push_back("--threads");
    command.push_back(std::to_string(settings_.threads));
  }
  run_viewer(command, fmt::format("measuring the filter matrices of pose '{}'", at.name), progress);
}

FilterMatrix AnimationProbe::matrix(int pose, std::size_t object) const {
  return read_filter_matrix(path(pose, object));
}

}  // namespace multum
