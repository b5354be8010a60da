// SPDX-License-Identifier: Apache-2.0
// Reads the [[sample]] tables of a job in the order of the parameter grid. Also contains helper functions for all job
// readers.
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

/// Checks that `name`, the value of `key`, is a known name. Otherwise throws Error(kInput), which lists the known
/// names.
void check_known(const StrictTable& table, const std::string& key, const std::string& name,
                 const std::vector<std::string>& known, const std::string& what);

/// Returns the path of `key`, relative to the job's folder. Throws Error(kInput) if the file does not exist.
std::string existing_file(const StrictTable& table, const std::string& key, const AnimationJob& job);

/// Reads job.samples, which has one sample for each point of the grid of job.parameters. Throws Error(kInput) for
/// missing or repeated points, unknown cameras and objects, missing files, and objects whose pixels cannot be
/// identified.
void read_animation_samples(const StrictTable& job_table, const std::vector<std::string>& meshes, AnimationJob& job);

}  // namespace multum
