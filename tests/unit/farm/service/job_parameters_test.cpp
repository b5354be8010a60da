// SPDX-License-Identifier: Apache-2.0
// What jobs of the service take of the tables of parameters.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/farm/service/workers/job_types.h"
#include "host/foundation/base/error.h"
#include "tests/unit/foundation/parameters/parameter_probes.h"

namespace multum {
namespace {

using Json = nlohmann::json;
using testing::for_each_probe;
using testing::former_names;
using testing::FormerName;
using testing::Probe;

TEST(JobParameters, TakeWhatIsLegalAndNothingElse) {
  for (const JobType& type : job_types())
    for_each_probe(*type.table, kInService, [&](const Parameter& row, const Probe& probe) {
      Json parameters = {{row.name, probe.json}};
      if (!type.input.empty()) parameters[type.input] = "/a.png";
      if (probe.is_legal) {
        EXPECT_NO_THROW(check_parameters(type, parameters));
      } else {
        EXPECT_THROW(check_parameters(type, parameters), Error);
      }
    });
}

TEST(JobParameters, TakeNothingThatTheirCommandRefuses) {
  for (const JobType& type : job_types())
    if (!type.command.empty() && type.name != "scene")
      for (const Parameter& row : type.table->rows()) {
        const bool is_handed_on = row.is_on(kInService) && row.name != type.input;
        EXPECT_TRUE(!is_handed_on || row.is_on(kOnCommandLine)) << type.name << " " << row.name;
      }
}

TEST(JobParameters, FormerNamesAreTakenByJobsButNotBesideTheNewOne) {
  for (const FormerName& one : former_names(kInService))
    for (const JobType& type : job_types()) {
      if (type.table != one.table) continue;
      SCOPED_TRACE(type.name + " " + one.former_name + " = " + one.former_value);
      Json former = {{one.former_name, Json::parse(one.former_value)}}, now = {{one.name, Json::parse(one.value)}};
      former[type.input] = now[type.input] = "/a.png";
      EXPECT_NO_THROW(check_parameters(type, former));
      EXPECT_EQ(with_current_names(type, former), now);
      EXPECT_EQ(with_current_names(type, now), now);
      EXPECT_EQ(job_arguments(type, with_current_names(type, former), "o"), job_arguments(type, now, "o"));
      const Json schema = parameters_schema(type);
      if (!one.renames_row()) continue;
      EXPECT_FALSE(schema.at("properties").contains(one.former_name));
      EXPECT_TRUE(schema.at("patternProperties").contains("^" + one.former_name + "$"));
      former[one.name] = now[one.name];
      EXPECT_THROW(check_parameters(type, former), Error);
    }
}

// A ledger may hold a job from before a name changed: its worker is told today's.
TEST(JobParameters, FormerNamesAreTakenFromStoredJobs) {
  const JobType& bake = find_job_type("bake");
  const std::vector<std::string> arguments = job_arguments(bake, {{"input", "/a.png"}, {"sweeps", 3}}, "");
  EXPECT_EQ(arguments, (std::vector<std::string>{"bake", "--passes=3", "--", "/a.png"}));
}

}  // namespace
}  // namespace multum
