// SPDX-License-Identifier: Apache-2.0
// Lists the files that a job reads. The scenes, inference jobs and manifests of clients name other files. The daemon
// never parses such files. Only a child process parses them, confined to the roots and with limits of memory and time.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/farm/service/workers/job_types.h"
#include "host/foundation/sandbox/confinement.h"
#include "host/foundation/sandbox/path_roots.h"

namespace multum {

struct InputList {
  std::vector<std::string> files;  // files in the form of input_files()
  std::string identity;            // result of input_identity()
};

/// Blocks. Throws Error like the reader of such a file, and Error(kInput) when the child exceeds its limits.
InputList list_inputs_in_child(const JobType& type, const nlohmann::json& parameters, const PathRoots& roots);

/// Runs in the child, `multum inputs`, confined to the roots and the readable part of `system`. Prints the list. Throws
/// Error.
void print_input_list(const std::string& type, const std::string& parameters, const std::vector<std::string>& roots,
                      Confinement system);

}  // namespace multum
