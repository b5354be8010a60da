// SPDX-License-Identifier: Apache-2.0
// Reads and checks clients' requests. Turns bodies and queries into requests to the ledger. If a value differs from
// docs/reference/openapi.json, throws a Refusal that names the key, the value found and the value expected.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/farm/service/files/job_roots.h"
#include "host/farm/service/http/http_server.h"
#include "host/farm/service/ledger/job_queue.h"

namespace multum {

/// Parses a text that consists only of a number.
std::optional<std::int64_t> parse_integer(const std::string& text);
/// Splits "/v1/jobs/7" into v1, jobs, 7.
std::vector<std::string> split_path(const std::string& path);

/// Returns the body, or {} if the body is empty.
nlohmann::json parse_body(const HttpRequest& request);

/// Parses the request of POST /v1/jobs. Files must be below `roots`, and are replaced by their canonical names, which
/// the parameters store as texts (path_text.h). check_input_files() checks the files that a scene names.
struct SubmitRequest {
  JobSubmission job;  // submission without its key
  nlohmann::json parameters;
  bool again = false;  // run even if a result exists
};
SubmitRequest parse_submit(const nlohmann::json& body, const JobRoots& roots, const ClaimLimits& limits, TimeMs now);

/// Parses the query of GET /v1/jobs.
JobFilter parse_filter(const HttpRequest& request);

/// Returns the part to cancel, such as "3/8", or "" for the whole job.
std::string parse_cancel(const nlohmann::json& json);
/// Throws Refusal if a job for Slurm's nodes uses files in the daemon's data.
void check_is_on_nodes(const SubmitRequest& request, const JobRoots& roots);
/// Returns the queue of POST /v1/retry, or "" for all queues.
std::string parse_retry(const nlohmann::json& body);

/// Parses the request of POST /v1/purge, which names jobs by number, or all jobs that finished at least a given number
/// of seconds ago.
struct PurgeRequest {
  std::vector<std::int64_t> jobs;
  std::optional<std::int64_t> finished_before_s;
};
PurgeRequest parse_purge(const nlohmann::json& body);

/// Checks the name of an upload.
void check_upload_name(const std::string& name);

}  // namespace multum
