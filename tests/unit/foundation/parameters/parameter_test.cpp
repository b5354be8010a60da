// SPDX-License-Identifier: Apache-2.0
// The tables of parameters, and every surface against them: values at, below and above each bound.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "host/bakes/bake/job_parameters.h"
#include "host/bakes/bake/output_state.h"
#include "host/bakes/manifest/bake_manifest.h"
#include "host/bakes/scene/scene_file.h"
#include "host/foundation/parameters/export_parameters.h"
#include "host/foundation/parameters/gltf_parameters.h"
#include "host/foundation/parameters/infer_parameters.h"
#include "host/foundation/parameters/pack_parameters.h"
#include "host/foundation/parameters/pyramid_parameters.h"
#include "host/foundation/toml/parameter_keys.h"
#include "tests/unit/foundation/base/test_folder.h"
#include "tests/unit/foundation/parameters/parameter_probes.h"
#include "tools/command_line/parameter_options.h"

namespace multum {
namespace {

using Json = nlohmann::json;
using testing::all_tables;
using testing::another_value;
using testing::for_each_probe;
using testing::Probe;

TEST(ParameterTable, RowsAreWhole) {
  for (const ParameterTable* table : all_tables()) {
    std::set<std::string> names;
    for (const Parameter& row : table->rows()) {
      SCOPED_TRACE(table->command() + " " + row.name);
      EXPECT_TRUE(names.insert(row.name).second) << "is there twice";
      EXPECT_FALSE(row.help.empty());
      EXPECT_EQ(row.kind == ParameterKind::kChoice, !row.choices.empty());
      EXPECT_TRUE(!row.is_numeric() || row.low < row.high);
      for (const std::string& other : row.excludes) {
        const std::vector<std::string>& back = table->at(other).excludes;
        EXPECT_NE(std::find(back.begin(), back.end(), row.name), back.end()) << "both ways";
      }
      if (row.is_numeric() && !row.default_text.empty() && row.kind != ParameterKind::kBytes) {
        const auto value = parse_value(row, row.default_text);
        ASSERT_TRUE(value.has_value());
        EXPECT_TRUE(is_legal(row, *value)) << "the default is not legal";
      }
    }
  }
}

TEST(ParameterTable, CommandLinesTakeWhatIsLegalAndNothingElse) {
  for (const ParameterTable* table : all_tables())
    for_each_probe(*table, kOnCommandLine, [&](const Parameter& row, const Probe& probe) {
      ParameterValues values(*table);
      CLI::App app;
      add_parameter_options(app, values);
      const std::string argument = row.option() + "=" + probe.command_line;
      const char* const argv[] = {"multum", argument.c_str()};
      const auto parse = [&] { app.parse(2, argv); };
      if (probe.is_legal) {
        EXPECT_NO_THROW(parse());
        EXPECT_TRUE(values.has(row.name));
        return;
      }
      try {
        parse();
        ADD_FAILURE() << "took it";
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kUsage);
        const std::string text = error.what();
        EXPECT_TRUE(text.starts_with(row.option() + " is ")) << text;
        EXPECT_NE(text.find(expected_text(row)), std::string::npos) << text;
      }
    });
}

TEST(ParameterTable, FlagsAndTextsOfCommandLinesArriveAsTheyAre) {
  for (const ParameterTable* table : all_tables())
    for (const Parameter& row : table->rows()) {
      const bool is_flag = row.kind == ParameterKind::kFlag;
      if (!row.is_on(kOnCommandLine) || row.is_numeric() || row.kind == ParameterKind::kChoice) continue;
      SCOPED_TRACE(table->command() + " " + row.name);
      ParameterValues values(*table);
      CLI::App app;
      add_parameter_options(app, values);
      const std::string argument = row.option() + (is_flag ? "" : "=some text");
      const char* const argv[] = {"multum", argument.c_str()};
      app.parse(2, argv);
      if (is_flag) {
        EXPECT_TRUE(values.flag(row.name));
      } else {
        EXPECT_EQ(values.text(row.name), "some text");
      }
    }
}

class ParameterFileTest : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    const std::string path = folder_.path() + "/" + name;
    std::ofstream(path) << text;
    return path;
  }
  testing::TemporaryFolder folder_;
};

TEST_F(ParameterFileTest, ManifestsTakeWhatIsLegalAndNothingElse) {
  for_each_probe(bake_parameters(), kInManifest, [&](const Parameter& row, const Probe& probe) {
    std::string text = "[[map]]\ninput = \"a.png\"\noutput = \"a.ndf.exr\"\n";
    if (row.scope == ParameterScope::kHarmonics) text += "ndf = \"sh\"\n";
    const std::string path = write("maps.toml", text + row.name + " = " + probe.toml + "\n");
    if (probe.is_legal) {
      EXPECT_NO_THROW(read_bake_manifest(path, {}));
      return;
    }
    try {
      read_bake_manifest(path, {});
      ADD_FAILURE() << "took it";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("map." + row.name), std::string::npos) << error.what();
    }
  });
}

TEST_F(ParameterFileTest, ScenesTakeWhatIsLegalAndNothingElse) {
  write("a.png", "");
  for_each_probe(bake_parameters(), kInScene, [&](const Parameter& row, const Probe& probe) {
    const std::string path = write(
        "scene.toml", "[[map]]\nname = \"m\"\nnormal = \"a.png\"\n" + row.name + " = " + probe.toml +
                          "\n[[material]]\nname = \"p\"\nbrdf = \"lambert\"\n[[object]]\nname = \"o\"\nmap = \"m\"\n"
                          "material = \"p\"\nwidth = 1\ndistance = 1\n");
    std::string refusal;
    try {
      read_scene(path, {});
    } catch (const Error& error) {
      refusal = error.what();
    }
    const bool names_it = refusal.find("map." + row.name) != std::string::npos;
    EXPECT_EQ(names_it, !probe.is_legal) << refusal;
  });
}

// What a job is without any parameter is what the table says that it is.
TEST(ParameterTable, DefaultsAreThoseOfTheJob) {
  BakeJob all;
  ParameterValues defaults(bake_parameters());
  for (const Parameter& row : bake_parameters().rows()) {
    const bool is_value = row.kind == ParameterKind::kInteger || row.kind == ParameterKind::kNumber ||
                          (row.kind == ParameterKind::kChoice && row.default_text != "detected");
    if (!is_value || row.default_text.empty() || row.surfaces == 0) continue;
    if (row.name == "iterations" || row.name == "wrap") continue;  // set two, or say that somebody said it
    defaults.set(row.name, *parse_value(row, row.default_text));
  }
  apply(defaults, all);
  EXPECT_EQ(all_settings_json(all), all_settings_json(BakeJob()));
  EXPECT_EQ(all.fitting.iteration_count, 12);
  EXPECT_EQ(bake_parameters().at("iterations").default_text, "12");
}

TEST(ParameterTable, HashKeysAreTheSettingsThatFilesState) {
  const Json before = Json::parse(all_settings_json(BakeJob()));
  for (const Parameter& row : bake_parameters().rows()) {
    const std::optional<ParameterValue> value = another_value(row);
    if (!value || row.surfaces == 0) continue;
    SCOPED_TRACE(row.name);
    BakeJob job;
    ParameterValues values(bake_parameters());
    if (row.scope == ParameterScope::kHarmonics) values.set("ndf", "sh");
    BakeJob without;
    apply(values, without);
    const Json base = Json::parse(all_settings_json(without));
    values.set(row.name, *value);
    apply(values, job);
    const Json after = Json::parse(all_settings_json(job));
    if (row.hashed_as.empty()) {
      EXPECT_EQ(after, base) << "changes what files state";
      continue;
    }
    EXPECT_NE(base.value(row.hashed_as, Json()), after.value(row.hashed_as, Json())) << "is not hashed as its row says";
  }
  for (const auto& [key, value] : before.items()) {
    static const std::set<std::string> kDerived = {"kernels", "periodic"};
    const auto has_it = [&](const Parameter& row) { return row.hashed_as == key; };
    const auto& rows = bake_parameters().rows();
    EXPECT_TRUE(kDerived.contains(key) || std::any_of(rows.begin(), rows.end(), has_it)) << key << " has no row";
  }
}

}  // namespace
}  // namespace multum
