// SPDX-License-Identifier: Apache-2.0
// Compares the tables of parameters with every surface: values at, below and above each bound.
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
      EXPECT_TRUE(names.insert(row.name).second) << "the name appears twice";
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

// A job without any parameter has the defaults of the table.
TEST(ParameterTable, DefaultsAreThoseOfTheJob) {
  BakeJob all;
  ParameterValues defaults(bake_parameters());
  for (const Parameter& row : bake_parameters().rows()) {
    const bool is_value = row.kind == ParameterKind::kInteger || row.kind == ParameterKind::kNumber ||
                          (row.kind == ParameterKind::kChoice && row.default_text != "detected");
    if (!is_value || row.default_text.empty() || row.surfaces == 0) continue;
    // These set two fields, or note that the user has set them.
    if (row.name == "iterations" || row.name == "wrap") continue;
    defaults.set(row.name, *parse_value(row, row.default_text));
  }
  apply(defaults, all);
  EXPECT_EQ(all_settings_json(all), all_settings_json(BakeJob()));
  EXPECT_EQ(all.fitting.iteration_count, 12);
  EXPECT_EQ(bake_parameters().at("iterations").default_text, "12");
}

// The settings hashes of files must not change. Hence the texts must equal the texts of earlier versions, except for
// kernels.
TEST(ParameterTable, HashedTextsKeepTheirBytes) {
  const auto text = [](std::initializer_list<std::pair<const char*, ParameterValue>> values) {
    BakeJob job;
    apply(bake_values(values), job);
    Json json = Json::parse(all_settings_json(job));
    json.erase("kernels");
    return json.dump();
  };
  EXPECT_EQ(text({}),
            R"({"albedo":"","align":0.10000000149011612,"aligned_start":true,"bump_format":"auto",)"
            R"("coarse_normals":"condensed","compression":"zip:1","encoding":"snorm16","first_level":0,)"
            R"("fixnan":"box3","green":"auto","height_scale":1.0,"iterations":12,"iterations_again":6,)"
            R"("iterations_coarse":30,"iterations_top":60,"kappa_cap":500.0,"kappa_cap_slope":10.0,"lobes":4,)"
            R"("order":"colour","periodic":[true,true],"rehearse_start":true,"representation":"movmf",)"
            R"("settled_change":0.009999999776482582,"signed":"auto","start_amplitude_min":0.019999999552965164,)"
            R"("start_kappa_factor":0.5,"sweeps":2,"two_channel":"auto","wrap":"periodic,periodic"})");
  EXPECT_EQ(text({{"reference", true},
                  {"unaligned", true},
                  {"lobes", std::int64_t{3}},
                  {"iterations", std::int64_t{7}},
                  {"passes", std::int64_t{2}},
                  {"refit_iterations", std::int64_t{5}},
                  {"order", "scanline"},
                  {"coarse_normals", "all"},
                  {"no_start_search", true},
                  {"farthest_start", true},
                  {"align", 0.25},
                  {"kappa_cap", 300.0},
                  {"bumpformat", "normal"},
                  {"green", "down"},
                  {"unsigned", true},
                  {"z_range", "positive"},
                  {"normal_scale", 2.0},
                  {"fixnan", "black"},
                  {"wrap", "clamp"},
                  {"twrap", "mirror"},
                  {"surface", "interpolated"},
                  {"data_format", "half"},
                  {"compression", "zip:4"}}),
            R"({"albedo":"","align":0.25,"aligned_start":false,"bump_format":"normal","coarse_normals":"all",)"
            R"("compression":"zip:4","encoding":"half","farthest_start":true,"first_level":1,"fixnan":"black",)"
            R"("green":"down","height_scale":1.0,"iterations":7,"iterations_again":5,"iterations_coarse":7,)"
            R"("iterations_top":60,"kappa_cap":300.0,"kappa_cap_slope":10.0,"lobes":3,"normal_scale":2.0,)"
            R"("order":"scanline","periodic":[false,false],"rehearse_start":false,"representation":"movmf",)"
            R"("settled_change":0.0,"signed":"no","start_amplitude_min":0.019999999552965164,)"
            R"("start_kappa_factor":0.5,"surface":"interpolated","sweeps":2,"two_channel":"auto",)"
            R"("wrap":"clamp,mirror","z_range":"positive"})");
  const std::string refined = text({{"refine", true}, {"ndf", "vmf"}});
  EXPECT_NE(refined.find(R"("periodic":[true,true],"refined":true,"rehearse_start":true)"), std::string::npos);
  EXPECT_EQ(text({{"ndf", "sh"}, {"sh_order", std::int64_t{3}}, {"green", "up"}}),
            R"({"albedo":"","bump_format":"auto","compression":"zip:1","encoding":"half","first_level":0,)"
            R"("fixnan":"box3","green":"up","height_scale":1.0,"representation":"sh","sh_order":3,"signed":"auto",)"
            R"("two_channel":"auto","wrap":"periodic,periodic"})");
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
    const auto has_it = [&wanted = key](const Parameter& row) { return row.hashed_as == wanted; };
    const auto& rows = bake_parameters().rows();
    EXPECT_TRUE(kDerived.contains(key) || std::any_of(rows.begin(), rows.end(), has_it)) << key << " has no row";
  }
}

}  // namespace
}  // namespace multum
