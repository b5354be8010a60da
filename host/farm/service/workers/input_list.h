// SPDX-License-Identifier: Apache-2.0
// Lists the files that a job reads. A scene, a job of inference and a manifest are files of clients that name others:
// they are parsed in a child that is confined to the roots and held to memory and time, never in the daemon.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/farm/service/workers/job_types.h"
#include "host/foundation/sandbox/confinement.h"
#include "host/foundation/sandbox/path_roots.h"

namespace multum {

struct InputList {
  std::vector<std::string> files;  // as input_files() has them
  std::string identity;            // input_identity()
};

/// Blocks. Throws Error as such a file's reader does, and Error(kInput) when the child needs too much.
InputList list_inputs_in_child(const JobType& type, const nlohmann::json& parameters, const PathRoots& roots);

/// Runs in the child, `multum inputs`, confined to the roots and what is readable of `system`. Prints the list; throws
/// Error.
void print_input_list(const std::string& type, const std::string& parameters, const std::vector<std::string>& roots,
                      Confinement system);

}  // namespace multum
