// SPDX-License-Identifier: Apache-2.0
// Reads the job file of texture inference. docs/reference/animation_jobs.md describes every key of animation.toml.
#pragma once

#include <string>
#include <vector>

#include "host/fields/inference/job/animation_job.h"

namespace multum {

/// Reads and validates a job: unknown keys, values out of range, names that nothing answers to, missing samples and
/// files are refused with the file's line. Throws Error(kInput), Error(kUsage) never.
AnimationJob read_animation_job(const std::string& path);

/// The files that a job names, as resolved, each once: read without looking at them or checking anything else. Throws
/// Error(kInput) when the job is no TOML.
std::vector<std::string> animation_job_files(const std::string& path);

}  // namespace multum
