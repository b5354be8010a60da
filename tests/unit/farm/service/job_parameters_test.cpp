// SPDX-License-Identifier: Apache-2.0
// Tests which parameters of the tables a job of the service accepts.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/farm/service/workers/job_types.h"
#include "host/foundation/base/error.h"
#include "tests/unit/foundation/parameters/parameter_probes.h"

namespace multum {
namespace {

using Json = nlohmann::json;
using testing::for_each_probe;
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

}  // namespace
}  // namespace multum
