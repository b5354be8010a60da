// SPDX-License-Identifier: Apache-2.0
// Tests that the field names in the web interface and in the ledger stay the same if the table of job fields changes.
#include "host/farm/service/ledger/job_fields.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/farm/service/http/http_reply.h"
#include "host/farm/service/http/job_request.h"
#include "host/farm/service/ledger/job_json.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using Json = nlohmann::json;
using testing::TemporaryFolder;

constexpr const char* kPlainText =
    R"({"attempt":0,"attempt_max":5,"created":"1970-01-01T00:00:00.000Z","deadline":null,"device":"","exit_code":null,)"
    R"("finished":null,"id":0,"label":"","memory_bytes":0,"message":"","needs":[],"not_before":null,"output":"",)"
    R"("parameters":{},"priority":0,"queue":"default","reused_from":null,"started":null,"state":"queued","type":""})";

constexpr const char* kFullText =
    R"({"attempt":2,"attempt_max":7,"created":"2026-11-22T07:30:00.123Z","deadline":"2026-11-22T07:30:09.000Z",)"
    R"("device":"gpu","exit_code":4,"finished":"2026-11-22T07:30:04.000Z","id":12,"label":"für \"alle\"",)"
    R"("memory_bytes":1024,"message":"why","needs":[3,4],"not_before":"2026-11-22T07:30:01.000Z","output":"/r/a.exr",)"
    R"("parameters":{"lobes":4},"priority":-3,"queue":"night","reused_from":9,"started":"2026-11-22T07:30:02.000Z",)"
    R"("state":"dead","type":"bake"})";

Job full_job() {
  constexpr TimeMs kNow = 1795332600000;  // 2026-11-22T07:30:00Z
  Job job;
  job.id = 12;
  job.type = "bake";
  job.parameters = R"({"lobes":4})";
  job.queue = "night";
  job.label = "für \"alle\"";
  job.priority = -3;
  job.needs = {3, 4};
  job.attempt_max = 7;
  job.deadline = kNow + 9000;
  job.memory_bytes = 1024;
  job.device = "gpu";
  job.output = "/r/a.exr";
  job.key = "k";
  job.inputs = "i";
  job.state = JobState::kDead;
  job.attempt = 2;
  job.owner = "o";
  job.created = kNow + 123;
  job.not_before = kNow + 1000;
  job.started = kNow + 2000;
  job.finished = kNow + 4000;
  job.exit_code = 4;
  job.message = "why";
  job.reused_from = 9;
  return job;
}

// The job may have more fields than `expected`.
void expect_told(const Job& job, const char* expected) {
  const Json told = Json::parse(job_text(job));
  Json known = Json::parse(expected);
  for (auto& [name, value] : known.items()) value = told.at(name);
  EXPECT_EQ(known.dump(), expected);
}

TEST(JobFields, AreToldAsEver) {
  expect_told(Job(), kPlainText);
  expect_told(full_job(), kFullText);
  for (const char* name : {"key", "inputs", "owner", "needs_left", "attempts_counted", "result_identity", "stop_asked"})
    EXPECT_FALSE(job_json(full_job()).contains(name)) << name;
}

std::string submit_refusal(const Json& body, const JobRoots& roots) {
  try {
    parse_submit(body, roots, {{{"default", {}}}, {}, 0}, 0);
  } catch (const Refusal& refusal) {
    return refusal.message;
  }
  return "";
}

TEST(JobFields, AreRefusedAsEver) {
  const TemporaryFolder folder;
  const PathRoots all({folder / ""});
  const JobRoots roots = {all, all, all, ResultSeal{""}};
  testing::write_bytes(folder / "job.toml", "x");
  const Json job = {{"type", "infer"}, {"parameters", {{"job", folder / "job.toml"}}}, {"output", folder / "made"}};
  EXPECT_EQ(submit_refusal(job, roots), "");
  const auto with = [&](const char* key, const Json& value) {
    Json changed = job;
    changed[key] = value;
    return submit_refusal(changed, roots);
  };
  EXPECT_EQ(with("colour", 1),
            "unknown key \"colour\" of the job, expected one of type, parameters, output, queue, label, priority, "
            "needs, attempt_max, deadline_s, memory_bytes, device, again");
  EXPECT_EQ(with("type", 1), "type is 1, expected a string");
  EXPECT_EQ(with("output", 1), "output is 1, expected a path");
  EXPECT_EQ(with("queue", "a\n"), "queue is \"a\\n\", expected the name of a queue");
  EXPECT_EQ(with("queue", "day"), "queue is \"day\", expected one of default");
  EXPECT_EQ(with("label", 1), "label is 1, expected a string of up to 1000 characters");
  EXPECT_EQ(with("priority", 1001), "priority is 1001, expected an integer from -1000 to 1000");
  EXPECT_EQ(with("needs", {0}), "needs is [0], expected a list of up to 1000 job numbers");
  EXPECT_EQ(with("attempt_max", 0), "attempt_max is 0, expected an integer from 1 to 100");
  EXPECT_EQ(with("deadline_s", 0), "deadline_s is 0, expected seconds from now, 1 to 100000000");
  EXPECT_EQ(with("deadline_s", nullptr), "deadline_s is null, expected seconds from now, 1 to 100000000");
  EXPECT_EQ(with("memory_bytes", -1), "memory_bytes is -1, expected bytes");
  EXPECT_EQ(with("device", true), "device is true, expected the name of a device");
  EXPECT_EQ(with("again", 1), "again is 1, expected true or false");
  Json more = job;
  more.update({{"deadline_s", 3}, {"label", "l"}, {"needs", {2, 1}}});
  const JobSubmission taken = parse_submit(more, roots, {{{"default", {}}}, {}, 0}, 500).job;
  EXPECT_EQ(taken.deadline, 3500);
  EXPECT_EQ(taken.label, "l");
  EXPECT_EQ(taken.needs, (std::vector<std::int64_t>{2, 1}));
  EXPECT_EQ(taken.memory_bytes, std::int64_t{2048} << 20) << "the type's default, since the job sets none";
  EXPECT_EQ(taken.attempt_max, 5);
}

}  // namespace
}  // namespace multum
