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
using testing::former_names;
using testing::FormerName;
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

std::string unquoted(std::string text) {
  std::erase(text, '"');
  return text;
}

TEST(FormerNames, AreNoNamesOfToday) {
  EXPECT_GE(former_names(kOnCommandLine).size(), 3u);
  for (const ParameterTable* table : all_tables())
    for (const Parameter& row : table->rows()) {
      for (const std::string& former : row.former_names) {
        EXPECT_EQ(table->find(former), &row) << former << " is the name of another";
        for (const unsigned surface : {kOnCommandLine, kInManifest, kInScene, kInService}) {
          const std::vector<std::string> names = table->names(surface);
          EXPECT_EQ(std::count(names.begin(), names.end(), former), 0) << former;
        }
      }
      for (const auto& [former, choice] : row.former_choices) {
        EXPECT_EQ(std::count(row.choices.begin(), row.choices.end(), former), 0) << former;
        EXPECT_EQ(std::count(row.choices.begin(), row.choices.end(), choice), 1) << choice;
      }
    }
}

// What `arguments` say, as today's options.
std::string parsed_options(const ParameterTable& table, const std::vector<std::string>& arguments) {
  ParameterValues values(table);
  CLI::App app;
  add_parameter_options(app, values);
  app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  return values.options_text();
}

TEST(FormerNames, AreTakenByCommandLinesButNotBesideTheNewOne) {
  for (const FormerName& one : former_names(kOnCommandLine)) {
    SCOPED_TRACE(one.table->command() + " " + one.former_name + " = " + one.former_value);
    const bool is_flag = one.row->kind == ParameterKind::kFlag;
    const std::string former = option_of(one.former_name) + (is_flag ? "" : "=" + unquoted(one.former_value));
    const std::string now = one.row->option() + (is_flag ? "" : "=" + unquoted(one.value));
    EXPECT_EQ(parsed_options(*one.table, {former}), one.row->option() + (is_flag ? "" : " " + unquoted(one.value)));
    if (!one.renames_row()) continue;
    try {
      parsed_options(*one.table, {former, now});
      ADD_FAILURE() << "took both";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
      for (const std::string& name : {one.former_name, one.name})
        EXPECT_NE(std::string(error.what()).find(option_of(name)), std::string::npos) << error.what();
    }
    ParameterValues values(*one.table);
    CLI::App app;
    add_parameter_options(app, values);
    EXPECT_EQ(app.help().find(option_of(one.former_name)), std::string::npos) << "is shown";
  }
}

TEST_F(ParameterFileTest, ManifestsTakeFormerNamesButNotBesideTheNewOne) {
  const auto settings = [&](const std::string& lines) {
    const std::string path = write("maps.toml", "[[map]]\ninput = \"a.png\"\noutput = \"a.ndf.exr\"\n" + lines);
    return all_settings_json(read_bake_manifest(path, {}).at(0).job);
  };
  for (const FormerName& one : former_names(kInManifest)) {
    const std::string former = one.former_name + " = " + one.former_value + "\n";
    const std::string now = one.name + " = " + one.value + "\n";
    SCOPED_TRACE(former);
    EXPECT_EQ(settings(former), settings(now));
    if (!one.renames_row()) continue;
    EXPECT_NE(settings(former), settings("")) << "is read over";
    try {
      settings(now + former);
      ADD_FAILURE() << "took both";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("maps.toml:5: map." + one.former_name + " is given beside " + one.name),
                std::string::npos)
          << error.what();
    }
  }
}

// [defaults] and [[map]] are tables of their own: one may have the former name, the other the new one.
TEST_F(ParameterFileTest, AMapsOwnNameGoesBeforeTheFormerOneOfDefaults) {
  const std::string path = write("maps.toml",
                                 "[defaults]\nsweeps = 3\n[[map]]\ninput = \"a.png\"\noutput = \"a.ndf.exr\"\n"
                                 "passes = 4\n[[map]]\ninput = \"a.png\"\noutput = \"b.ndf.exr\"\n");
  const std::vector<ManifestMap> maps = read_bake_manifest(path, {});
  EXPECT_EQ(maps.at(0).job.fitting.pass_count, 4);
  EXPECT_EQ(maps.at(1).job.fitting.pass_count, 3);
}

// No parameter of scenes has a former name yet, so a table of its own stands for them.
TEST_F(ParameterFileTest, TablesOfTomlTakeFormerNames) {
  const ParameterTable rows("test", {{.name = "width",
                                      .former_names = {"breadth", "wideness"},
                                      .kind = ParameterKind::kInteger,
                                      .help = "a width",
                                      .low = 1,
                                      .high = 9,
                                      .surfaces = kInScene}});
  const auto width = [&](const std::string& lines) {
    const toml::table toml = toml::parse(lines);
    const std::string file = "scene.toml";
    const StrictTable table(file, toml, "map", rows.names(kInScene), "the scene", rows.former_names(kInScene));
    ParameterValues values(rows);
    read_parameters(table, kInScene, values);
    return values.integer("width").value_or(0);
  };
  EXPECT_EQ(width("width = 3"), 3);
  EXPECT_EQ(width("breadth = 3"), 3);
  EXPECT_EQ(width("wideness = 4"), 4);
  EXPECT_THROW(width("breadth = 3\nwidth = 3"), Error);
  EXPECT_THROW(width("breadth = 3\nwideness = 3"), Error);
  try {
    width("breadht = 3\nbreadth = 3");
    FAIL() << "took it";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find("did you mean"), std::string::npos) << "suggests a former name";
  }
}

}  // namespace
}  // namespace multum
