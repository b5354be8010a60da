// SPDX-License-Identifier: Apache-2.0
// The [[sample]] tables of a job, in the order of the parameter grid; and what the readers of a job's parts share.
#pragma once

#include <string>
#include <vector>

#include "host/fields/inference/job/animation_job.h"
#include "host/foundation/toml/strict_toml.h"

namespace multum {

template <typename Item>
std::vector<std::string> names_of(const std::vector<Item>& items) {
  std::vector<std::string> names;
  for (const Item& item : items) names.push_back(item.name);
  return names;
}

/// Throws Error(kInput) listing the known names unless `name`, the value of `key`, is among them.
void check_known(const StrictTable& table, const std::string& key, const std::string& name,
                 const std::vector<std::string>& known, const std::string& what);

/// The path that `key` names, against the job's folder. Throws Error(kInput) unless there is such a file.
std::string existing_file(const StrictTable& table, const std::string& key, const AnimationJob& job);

/// Reads job.samples: one for each point of the grid of job.parameters. Throws Error(kInput): points that are missing
/// or there twice, unknown cameras and objects, files that are not there, objects whose pixels cannot be told.
void read_animation_samples(const StrictTable& job_table, const std::vector<std::string>& meshes, AnimationJob& job);

}  // namespace multum
