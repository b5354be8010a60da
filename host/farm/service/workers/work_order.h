// SPDX-License-Identifier: Apache-2.0
// Orders to workers, as the daemon writes them to their sockets and into Slurm's folders.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

namespace multum {

struct WorkOrder {
  std::int64_t job = 0;
  int attempt = 0;
  std::string type;           // of job_types.h
  nlohmann::json parameters;  // checked, an object
  std::string share;          // "--shard=3/8": an option more, for a part of the job; "": all of it
  std::string output;         // where its result is to be; "": nowhere
  std::string folder;         // the staging folder, where its worker works and makes it
  std::string log;
  std::string inputs;              // input_identity() when the job was submitted
  std::string copy_from, copy_to;  // instead, if inputs are the same: a finished result; "": none
};

/// Paths are texts in it (path_text.h).
nlohmann::json work_json(const WorkOrder& order);
/// Throws nlohmann::json::exception for what is none.
WorkOrder work_from(const nlohmann::json& json);

}  // namespace multum
