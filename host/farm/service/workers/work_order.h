// SPDX-License-Identifier: Apache-2.0
// Defines orders to workers, which the daemon writes to their sockets and into Slurm's folders.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

namespace multum {

struct WorkOrder {
  std::int64_t job = 0;
  int attempt = 0;
  std::string type;           // a type of job_types.h
  nlohmann::json parameters;  // a checked object
  std::string share;          // "--shard=3/8", an extra option for a part of the job; "" means the whole job
  std::string output;         // the path of the result; "" if there is none
  std::string folder;         // the staging folder, where the worker runs and makes the result
  std::string log;
  std::string inputs;              // input_identity() when the job was submitted
  std::string copy_from, copy_to;  // a finished result to copy if the inputs are the same; "" if there is none
};

/// Writes paths as texts (path_text.h).
nlohmann::json work_json(const WorkOrder& order);
/// Throws nlohmann::json::exception if the JSON is not an order.
WorkOrder work_from(const nlohmann::json& json);

}  // namespace multum
