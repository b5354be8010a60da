// SPDX-License-Identifier: Apache-2.0
// Tests the settings of the service. Names that do not exist are refused before a job can wait for them.
#include "host/farm/service/dispatch/service_settings.h"

#include <gtest/gtest.h>

#include "host/foundation/base/error.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

TEST(ServiceSettingsTest, SlurmTakesQueuesThatThereAre) {
  const testing::TemporaryFolder folder;
  const std::string path = folder / "service.toml";
  const auto read = [&](const std::string& queue) {
    testing::write_bytes(path,
                         "[[queue]]\nname = \"farm\"\n[slurm]\nfolder = \"/shared\"\nqueues = [\"" + queue + "\"]\n");
    ServiceSettings settings;
    read_service_settings(path, settings);
    return settings.slurm.queues;
  };
  EXPECT_EQ(read("farm"), std::vector<std::string>{"farm"});
  testing::expect_error(ErrorCode::kInput, {path, "queues", "\"fram\"", "[[queue]]"}, [&] { read("fram"); });
}

}  // namespace
}  // namespace multum
