// SPDX-License-Identifier: Apache-2.0
// Fuzzes the code of the service that reads requests (JSON bodies, queries, paths and addresses) and its settings file.
// tests/service/fault_injection/fuzz.py sends whole requests to a running service.
#include <nlohmann/json.hpp>

#include "host/farm/service/dispatch/service_settings.h"
#include "host/farm/service/http/http_reply.h"
#include "host/farm/service/http/job_request.h"
#include "host/farm/service/workers/job_types.h"
#include "tests/fuzz/fuzz.h"
#include "tools/multum/farm/multum_job_types.h"

namespace multum {
namespace {

[[maybe_unused]] const bool kHasJobTypes = (register_job_types(multum_job_types()), true);

void submit(const nlohmann::json& body) {
  static const JobRoots roots{PathRoots({fuzz::scratch_folder()}),
                              PathRoots({fuzz::scratch_folder()}),
                              PathRoots({fuzz::scratch_folder()}),
                              {}};
  const SubmitRequest asked = parse_submit(body, roots, {}, 1);
  job_arguments(find_job_type(asked.job.type), asked.parameters, "out");
}

constexpr char kSettingsFile[] = R"(data = "jobs"
listen = "127.0.0.1:0"
workers = 2
roots = ["/tmp"]
memory_max = "8G"
lease_s = 10
[[queue]]
name = "default"
jobs = 2
memory_max = "1G"
priority = -3
)";

}  // namespace

std::vector<std::string> fuzz::seeds() {
  input_file("map.png", "no picture");
  const std::string folder = scratch_folder();
  return {std::string(1, '\0') + R"({"type":"bake","parameters":{"input":")" + folder +
              R"(/map.png","lobes":4,"green":"up","reference":true,"height_scale":1.5},"output":")" + folder +
              R"(/map.ndf.exr","queue":"default","priority":3,"again":true})",
          std::string(1, '\0') + R"({"type":"scene","parameters":{}})",
          "\1{\"queue\":\"default\"}",
          "\2{\"jobs\":[1,2,3]}",
          "\2{\"finished_before_s\":60}",
          "\3state=queued&limit=10&before=7&queue=default",
          "\4/v1/jobs/7/result",
          "\5[::1]:8470",
          std::string("\6") + kSettingsFile};
}

}  // namespace multum

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multum;
  const auto input = fuzz::split(data, size, 7);
  HttpRequest request;
  request.body = input.bytes;
  const std::string text(input.bytes);
  fuzz::may_refuse([&] {
    try {
      switch (input.kind) {
        case 0: submit(parse_body(request)); break;
        case 1: parse_retry(parse_body(request)); break;
        case 2: parse_purge(parse_body(request)); break;
        case 3: {
          for (std::size_t begin = 0; begin < text.size();) {
            const std::size_t end = std::min(text.find('&', begin), text.size());
            const std::string pair = text.substr(begin, end - begin);
            const std::size_t equals = std::min(pair.find('='), pair.size());
            request.query[pair.substr(0, equals)] = pair.substr(std::min(equals + 1, pair.size()));
            begin = end + 1;
          }
          parse_filter(request);
          break;
        }
        case 4:
          for (const std::string& part : split_path(text)) parse_integer(part);
          check_upload_name(text);
          break;
        case 5: parse_listen_address(text); break;
        default: {
          ServiceSettings settings;
          read_service_settings(fuzz::input_file("input.toml", input.bytes), settings);
        }
      }
    } catch (const Refusal& refusal) {
      MULTUM_CHECK(refusal.status >= 400 && refusal.status < 500);
    }
  });
  return 0;
}
