// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/job/animation_samples.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/matrix.hpp>

namespace multum {
namespace {

// Returns the number of a grid point; the last parameter changes fastest.
std::size_t grid_number(const StrictTable& table, const AnimationJob& job, const std::vector<int>& at) {
  if (at.size() != job.parameters.size())
    table.refuse("at", fmt::format("has {} numbers, expected {}, one per parameter ({})", at.size(),
                                   job.parameters.size(), fmt::join(names_of(job.parameters), ", ")));
  std::size_t number = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const AnimationParameter& parameter = job.parameters[i];
    if (at[i] >= parameter.count)
      table.refuse("at", fmt::format("is [{}], expected 0 to {} along {}", fmt::join(at, ", "), parameter.count - 1,
                                     parameter.name));
    number = number * static_cast<std::size_t>(parameter.count) + static_cast<std::size_t>(at[i]);
  }
  return number;
}

std::string grid_point_text(const AnimationJob& job, std::size_t number) {
  std::string text;
  for (std::size_t i = job.parameters.size(); i > 0; --i) {
    const auto count = static_cast<std::size_t>(job.parameters[i - 1].count);
    text = fmt::format("{} {}", job.parameters[i - 1].name, number % count) + (text.empty() ? "" : ", " + text);
    number /= count;
  }
  return text;
}

std::string default_name(const std::vector<int>& at) { return fmt::format("{}", fmt::join(at, "_")); }

int camera_of(const StrictTable& table, const AnimationJob& job) {
  const std::vector<std::string> cameras = names_of(job.cameras);
  const std::string name = table.text("camera");
  check_known(table, "camera", name, cameras, "camera");
  return static_cast<int>(std::find(cameras.begin(), cameras.end(), name) - cameras.begin());
}

std::map<std::string, glm::dmat4> read_motion(const StrictTable& table, const std::vector<std::string>& meshes,
                                              const std::string& file) {
  std::map<std::string, glm::dmat4> motion;
  const StrictTable matrices(file, table.table("object_to_world"), "sample.object_to_world", {});
  for (const std::string& mesh : matrices.keys()) {
    check_known(matrices, mesh, mesh, meshes, "object of the geometry file");
    const glm::dmat4 m = matrices.matrix(mesh);
    if (m[0][3] != 0.0 || m[1][3] != 0.0 || m[2][3] != 0.0 || m[3][3] != 1.0)
      matrices.refuse(
          mesh,
          "has a last row that is not 0 0 0 1; expected the four rows of a matrix that multiplies column vectors");
    if (!(std::abs(glm::determinant(glm::dmat3(m))) > 0.0))
      matrices.refuse(mesh, "is flat, because its determinant is 0");
    motion[mesh] = m;
  }
  return motion;
}

// Checks that the object-index image or the Cryptomatte identifies each object's pixels.
void check_objects_told(const StrictTable& table, const AnimationJob& job, const AnimationSample& sample) {
  const bool by_index = !sample.object_index.empty();
  if (!by_index && sample.geometry.empty())
    table.refuse(
        "", "has neither geometry nor object_index, so the pixels of objects cannot be identified; add one of them");
  for (const AnimationObject& object : job.objects) {
    if (by_index && object.index == 0)
      table.refuse("object_index", fmt::format("is given, but object \"{}\" has no index", object.name));
    if (!by_index && object.cryptomatte.empty())
      table.refuse("", fmt::format("has no object_index, and object \"{}\" has no cryptomatte", object.name));
  }
}

AnimationSample read_sample(const StrictTable& table, const std::vector<std::string>& meshes, const AnimationJob& job) {
  AnimationSample sample;
  sample.at = table.integers("at");
  sample.name = table.text("name", default_name(sample.at));
  sample.radiance = existing_file(table, "radiance", job);
  if (table.has("geometry")) sample.geometry = existing_file(table, "geometry", job);
  if (table.has("object_index")) sample.object_index = existing_file(table, "object_index", job);
  sample.camera = camera_of(table, job);
  sample.object_to_world = read_motion(table, meshes, job.path);
  check_objects_told(table, job, sample);
  return sample;
}

}  // namespace

void check_known(const StrictTable& table, const std::string& key, const std::string& name,
                 const std::vector<std::string>& known, const std::string& what) {
  if (std::find(known.begin(), known.end(), name) != known.end()) return;
  table.refuse(table.has(key) ? key : "",
               fmt::format("names \"{}\", an unknown {}, expected one of {}", name, what, fmt::join(known, ", ")));
}

std::string existing_file(const StrictTable& table, const std::string& key, const AnimationJob& job) {
  namespace fs = std::filesystem;
  const std::string name = table.path(key);
  const std::string path = (fs::path(job.path).parent_path() / name).lexically_normal().string();
  std::error_code error;
  if (!fs::is_regular_file(path, error))
    table.refuse(key, fmt::format("is \"{}\", but the file {} does not exist", name, path));
  return path;
}

void read_animation_samples(const StrictTable& job_table, const std::vector<std::string>& meshes, AnimationJob& job) {
  std::size_t count = 1;
  for (const AnimationParameter& parameter : job.parameters) count *= static_cast<std::size_t>(parameter.count);
  std::vector<std::optional<AnimationSample>> grid(count);
  std::set<std::string> names;
  for (const toml::table* entry : job_table.tables("sample")) {
    const StrictTable table(job.path, *entry, "sample",
                            {"at", "name", "radiance", "geometry", "object_index", "camera", "object_to_world"});
    AnimationSample sample = read_sample(table, meshes, job);
    const std::size_t number = grid_number(table, job, sample.at);
    if (grid[number])
      table.refuse("at", fmt::format("is [{}], which another sample already has", fmt::join(sample.at, ", ")));
    if (!names.insert(sample.name).second)
      table.refuse(table.has("name") ? "name" : "",
                   fmt::format("is \"{}\", which another sample already has", sample.name));
    grid[number] = std::move(sample);
  }
  const auto is_missing = [](const std::optional<AnimationSample>& sample) { return !sample; };
  const auto missing = std::find_if(grid.begin(), grid.end(), is_missing);
  if (missing != grid.end())
    job_table.refuse(
        "", fmt::format("lacks {} of {} samples, the first at {}", std::count_if(grid.begin(), grid.end(), is_missing),
                        count, grid_point_text(job, static_cast<std::size_t>(missing - grid.begin()))));
  for (std::optional<AnimationSample>& sample : grid) job.samples.push_back(std::move(*sample));
}

}  // namespace multum
