// SPDX-License-Identifier: Apache-2.0
// Reads the job file of texture inference. docs/reference/animation_jobs.md describes every key of animation.toml.
#pragma once

#include <string>
#include <vector>

#include "host/fields/inference/job/animation_job.h"

namespace multum {

/// Reads and validates a job. Refuses unknown keys, values out of range, unknown names, missing samples and missing
/// files. Throws Error(kInput), which names the line. Never throws Error(kUsage).
AnimationJob read_animation_job(const std::string& path);

/// Returns the resolved paths of the files that a job names, without duplicates. Opens none of these files and checks
/// nothing else. Throws Error(kInput) if the job is not TOML.
std::vector<std::string> animation_job_files(const std::string& path);

}  // namespace multum
