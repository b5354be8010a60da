// SPDX-License-Identifier: Apache-2.0
// Reads and checks clients' requests: turns bodies and queries into what the ledger is asked. Whatever is not as
// docs/reference/openapi.json says is a Refusal that names the key, what was found and what was expected.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/farm/service/files/job_roots.h"
#include "host/farm/service/http/http_server.h"
#include "host/farm/service/ledger/job_queue.h"

namespace multum {

/// A number and nothing else.
std::optional<std::int64_t> parse_integer(const std::string& text);
/// "/v1/jobs/7" -> v1, jobs, 7.
std::vector<std::string> split_path(const std::string& path);

/// The body; {} when there is none.
nlohmann::json parse_body(const HttpRequest& request);

/// Request of POST /v1/jobs. Files are held to `roots`, and given by their canonical names, in the parameters as texts
/// (path_text.h); those that a scene names in it are for check_input_files().
struct SubmitRequest {
  JobSubmission job;  // without its key
  nlohmann::json parameters;
  bool again = false;  // though it has been made
};
SubmitRequest parse_submit(const nlohmann::json& body, const JobRoots& roots, const ClaimLimits& limits, TimeMs now);

/// The query of GET /v1/jobs.
JobFilter parse_filter(const HttpRequest& request);

/// The part that is to be cancelled, "3/8"; "": all of the job.
std::string parse_cancel(const nlohmann::json& json);
/// Throws Refusal for a job that nodes of Slurm's are to do, with files in the daemon's data.
void check_is_on_nodes(const SubmitRequest& request, const JobRoots& roots);
/// The queue of POST /v1/retry; "": all.
std::string parse_retry(const nlohmann::json& body);

/// POST /v1/purge: jobs, or all that finished so many seconds ago.
struct PurgeRequest {
  std::vector<std::int64_t> jobs;
  std::optional<std::int64_t> finished_before_s;
};
PurgeRequest parse_purge(const nlohmann::json& body);

/// The name of an upload.
void check_upload_name(const std::string& name);

}  // namespace multum
