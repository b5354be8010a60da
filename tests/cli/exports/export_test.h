// SPDX-License-Identifier: Apache-2.0
// Runs multum export on one normal map, map.png, into the folder out.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/cli/exports/exported_levels.h"
#include "tests/cli/program.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {

class ExportTest : public CliTest {
 protected:
  ProgramResult run(std::vector<std::string> more) const {
    more.insert(more.begin(),
                {"export", path("map.png"), "-o", path("out"), "--bumpformat", "normal", "--green", "up"});
    return multum(more);
  }
  void expect_refused(const std::vector<std::string>& more, int code, const std::vector<std::string>& parts) const {
    expect_refusal(run(more), code, parts);
    EXPECT_FALSE(std::filesystem::exists(path("out"))) << parts[0];
  }
  Picture level(const std::string& name) const { return read_picture(path("out/" + name)); }
  void write(const std::string& name, const TestImage& image) const { write_test_image(path(name), image); }
};

}  // namespace multum::testing
