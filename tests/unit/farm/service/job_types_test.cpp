// SPDX-License-Identifier: Apache-2.0
// Tests the types of jobs that multum registers, and which parameters jobs accept and refuse because of the rows of the
// table.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "host/farm/service/workers/job_types.h"
#include "host/foundation/base/error.h"
#include "tests/unit/foundation/base/test_folder.h"
#include "tools/multum/farm/multum_job_types.h"

namespace multum {
namespace {

using Json = nlohmann::json;

// The types are registered once for all tests of this program.
[[maybe_unused]] const bool kHasJobTypes = (register_job_types(multum_job_types()), true);

// A measured BRDF is a file. A text parameter must not give access to files that jobs may not read.
TEST(JobTypes, TakeBrdfsOfFamiliesAlone) {
  const JobType& bake = find_job_type("bake");
  const auto parameters = [](const char* brdf) { return Json{{"input", "a.png"}, {"brdf", brdf}}; };
  for (const char* brdf : {"lambert", "blinn-phong:1e2", "ggx:0.4,0.04", "torrance-sparrow:.1", "charlie:0.5"})
    EXPECT_NO_THROW(check_parameters(bake, parameters(brdf))) << brdf;
  for (const char* brdf : {"", "/etc/passwd", "gold.brdf", "ggx:../x", "ggx:", "lambert\n", "ggx:0.4\n/x"})
    EXPECT_THROW(check_parameters(bake, parameters(brdf)), Error) << brdf;
}

TEST(JobTypes, AMisspeltParameterIsAnsweredWithTheOneThatWasMeant) {
  try {
    check_parameters(find_job_type("bake"), {{"input", "a.png"}, {"lobs", 2}});
    FAIL() << "took it";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "unknown parameter 'lobs' of bake (did you mean 'lobes'?)");
  }
}

std::string input_refusal(const JobType& type, const std::string& input) {
  try {
    check_input(type, {{type.input, input}});
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// Commands also accept scenes and tile sets, but the service would not have checked the files that these name.
TEST(JobTypes, ThoseOfOneMapTakeNothingElse) {
  for (const char* name : {"bake", "export"}) {
    const JobType& type = find_job_type(name);
    EXPECT_EQ(input_refusal(type, "/a.png"), "");
    EXPECT_EQ(input_refusal(type, "/a.toml"),
              "parameters.input is /a.toml, expected a map; for a scene, submit a job of type scene");
    EXPECT_EQ(input_refusal(type, "/a_<UDIM>.png"), "parameters.input is /a_<UDIM>.png, expected one map, not a set");
  }
  EXPECT_EQ(input_refusal(find_job_type("export"), "/a.ndf.exr"),
            "parameters.input is /a.ndf.exr, expected a map, not a baked file");
  for (const char* name : {"scene", "infer", "pack"}) EXPECT_EQ(input_refusal(find_job_type(name), "/a.toml"), "");
}

TEST(JobTypes, HashTheFilesThatTheirInputNames) {
  const testing::TemporaryFolder folder;
  const std::string job = folder / "job.toml";
  std::ofstream(job) << "geometry = \"scene.gltf\"\n[[sample]]\nradiance = \"a.exr\"\n";
  const std::vector<std::string> all = {job, folder / "scene.gltf", folder / "a.exr"};
  EXPECT_EQ(input_files(find_job_type("infer"), {{"job", job}}), all);
  EXPECT_EQ(input_files(find_job_type("bake"), {{"input", job}}), std::vector<std::string>{job});
}

// No two views of a job type may write a file with the same name or share a folder.
TEST(JobTypes, ViewsAreTold) {
  std::set<std::string> names;
  for (const JobType& type : job_types()) {
    std::set<std::string> files, endings;
    for (const JobView& view : type.views) {
      EXPECT_TRUE(endings.insert(view.folder_ending).second) << type.name;
      EXPECT_TRUE(view.kept_max == 0 || !view.folder_ending.empty())
          << "other views of the type would be removed with them";
      for (const std::string& file : view.files) {
        EXPECT_TRUE(files.insert(file).second) << type.name << " " << file;
        EXPECT_EQ(type.find_view(file), &view);
      }
    }
    EXPECT_EQ(type.find_view("other.png"), nullptr);
    EXPECT_EQ(type.views.empty(), type.no_other_view.empty()) << type.name;
    names.insert(files.begin(), files.end());
  }
  // These are the names of all routes in the web interface (docs/reference/openapi.json).
  EXPECT_EQ(names, (std::set<std::string>{"error.png", "input.png", "look.html", "player.html", "render.png"}));
}

TEST(JobTypesDeathTest, AreRegisteredOnce) { EXPECT_DEATH(register_job_types(multum_job_types()), ""); }

}  // namespace
}  // namespace multum
