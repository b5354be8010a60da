// SPDX-License-Identifier: Apache-2.0
// Implements multum testmap, which makes the maps of materials, and the four-quarter map.
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "host/formats/testmap/four_quarter_map.h"
#include "host/formats/testmap/materials/test_material.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/shown_text.h"
#include "tools/command_line/choices.h"
#include "tools/multum/commands.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

struct TestmapOptions {
  std::string prefix;
  std::optional<MaterialKind> material;
  int size = 1024;
  std::uint64_t seed = 7;
  std::optional<Quarter> quarter;
  GreenAxis green = GreenAxis::kDown;
  bool json = false;
};

int run_testmap(TestmapOptions& o) {
  if (o.size % 2 != 0) throw Error(ErrorCode::kUsage, fmt::format("--size is {}, expected an even number", o.size));
  // The name of a material is enough: `multum testmap water` writes water_normal.png.
  if (!o.material) o.material = find_choice(kMaterialKinds, std::filesystem::path(o.prefix).filename().string());
  if (o.material && o.quarter)
    throw Error(ErrorCode::kUsage,
                "--quarter: found a material, expected no material, because only the four-quarter map has quarters");
  OrderedJson json;
  std::string names;
  for (const std::string part : {"normal", "albedo", "orm"}) {
    if (!o.material && part == "orm") continue;
    const std::string name = o.prefix + "_" + part + ".png";
    check_writable(name);
    json[part] = path_json(name);
    names += (names.empty() ? "" : ", ") + name;
  }
  if (o.material) write_material(*o.material, o.size, o.seed, o.prefix, o.green);
  else write_four_quarter_map(o.size, o.seed, o.prefix, o.quarter, o.green);
  if (o.json) print_json(json);
  else
    print_shown(stdout, "%s: written; green points %s, which a bake detects\n", names.c_str(),
                o.green == GreenAxis::kUp ? "up (OpenGL)" : "down (DirectX)");
  return 0;
}

}  // namespace

void add_testmap_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<TestmapOptions>();
  TestmapOptions& o = *options;
  CLI::App* testmap = app.add_subcommand(
      "testmap", "make the maps of a material, or a test map with four quarters: scales, rings, grooves and noise");
  testmap->footer(
      "Examples:\n"
      "  multum testmap hammered     # writes hammered_normal.png, hammered_albedo.png and hammered_orm.png\n"
      "  multum testmap out/test     # the four-quarter map: out/test_normal.png and out/test_albedo.png\n"
      "All maps repeat. ORM maps contain 1, roughness and metalness.");
  testmap->add_option("prefix,-o,--output", o.prefix, "prefix of the files to write, or the name of a material")
      ->required();
  add_choice(*testmap, "--material", o.material, kMaterialKinds,
             "make the maps of this material: hammered, denim, bricks, car-paint or water");
  testmap->add_option("--size", o.size, "set the number of texels per side, which must be even")
      ->check(CLI::Range(16, 32768))
      ->capture_default_str();
  testmap->add_option("--seed", o.seed, "set the seed of random numbers")->capture_default_str();
  add_choice(*testmap, "--quarter", o.quarter, kQuarters, "make only this quarter: armour, rings, grooves or noise");
  add_choice(*testmap, "--write-green", o.green, kGreenAxes,
             "write normals whose green points up (OpenGL, glTF) or down (DirectX)")
      ->default_str("down");
  add_json_option(*testmap, o.json);
  testmap->callback([options, exit_code] { *exit_code = run_testmap(*options); });
}

}  // namespace multum
