// SPDX-License-Identifier: Apache-2.0
// Tests multum plan and multum bake scene.toml. Compares the pictures of six scenes with the pictures of the default
// bake. Also compares the numbers of kernel launches and builds with the numbers in the plan.
#include <fmt/format.h>

#include <OpenImageIO/imageio.h>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>

#include "tests/cli/program.h"
#include "tests/cli/shader_text.h"

namespace multum::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr char kHead[] = "[camera]\nresolution = [96, 72]\n[[map]]\nname = \"wall\"\nnormal = \"{}_normal.png\"\n{}\n";
constexpr char kObject[] =
    "[[object]]\nname = \"front\"\nmap = \"wall\"\nmaterial = \"paint\"\nwidth = 2.0\ndistance = [{}]\n";
constexpr char kSky[] = "[environment]\nfile = \"sky.exr\"\n";
constexpr char kSun[] = "[[light]]\ndirection = [0.3, 0.8, 0.5]\n";

constexpr double kFarther = 16.0;  // this distance shows coarser levels; the nearest distance magnifies the finest
                                   // level

struct SceneCase {
  std::string name;
  std::string normal = "map";  // NORMAL_normal.png
  std::string albedo = "";     // name of the file; empty if there is no map
  std::string material = "brdf = \"blinn-phong\"\nexponent = 100\n";
  std::string distance = "0.4, 20";
  std::string light = kSun;
  std::string object = "";       // more keys
  double difference_max = 1e-5;  // the largest allowed difference from the default bake's pictures, which is 1.5 times
                                 // the measured difference, or almost 0
};

// A shader's code and its active uniforms contain these texts only if an effect is needed, and always in that case.
struct EffectMark {
  const char *effect, *mark;
};
const EffectMark kMarks[] = {
    {"highlight", "u_specular|multum_(lobe_|sh_)?facets|multum_environment_specular"},
    {"Fresnel", "multum_fresnel|multum_schlick|u_f0"},
    {"distant lights", "u_light_directions"},
    {"point lights", "u_point_positions"},
    {"environment, diffuse", "multum_irradiance|u_smooth_mean"},
    {"environment, highlight", "multum_environment_specular|u_environment_map"},
    {"several lobes, EM", R"(for\s*\(int j)"},
    {"colours", "u_(mean_)?colours|albedo"},
    {"colours of each lobe", "u_colours"},
    {"roughness in normals", "u_mean_cosine|without_roughness"},
    {"weights of BRDFs", "u_weights"},
    {"moments of slopes (LEAN)", "u_slopes|multum_moments"},
    {"spherical harmonics", "u_harmonics|multum_sh_"},
};

class SceneCommandTest : public CliTest {
 protected:
  void SetUp() override { make_map("map", 64); }

  std::string write_scene(const SceneCase& c) const {
    const std::string text = fmt::format(kHead, c.normal, c.albedo.empty() ? "" : "albedo = \"" + c.albedo + "\"") +
                             "[[material]]\nname = \"paint\"\n" + c.material + fmt::format(kObject, c.distance) +
                             c.object + c.light;
    write_bytes(path(c.name + ".toml"), text);
    return path(c.name + ".toml");
  }
  // Makes a scene with an object that names its own materials.
  static std::string with_object(const std::string& materials) {
    return "[[object]]\nname = \"front\"\nmap = \"wall\"\n" + materials + "\nwidth = 2.0\ndistance = [0.4, 20]\n";
  }
  Json json(const std::string& name) const { return Json::parse(read_bytes(path(name))); }
  // Writes an image with three channels, as bytes or as floats.
  void write_image(const std::string& name, int size, const std::function<float(int x, int y, int c)>& value,
                   bool half_as_high = false) const {
    const int height = half_as_high ? size / 2 : size;
    std::vector<float> values;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < size; ++x)
        for (int c = 0; c < 3; ++c) values.push_back(value(x, y, c));
    const auto out = OIIO::ImageOutput::create(path(name));
    const bool is_exr = name.ends_with(".exr");
    ASSERT_TRUE(out && out->open(path(name), OIIO::ImageSpec(size, height, 3,
                                                             is_exr ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8)));
    ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, values.data()));
    ASSERT_TRUE(out->close());
  }
  void write_sky() const {
    write_image(
        "sky.exr", 32, [](int, int y, int c) { return y < 8 ? 1.0f + static_cast<float>(c) : 0.1f; }, true);
  }
  static std::vector<std::string> viewer(const std::string& plan) {
    return {std::string(MULTUM_BIN_DIR) + "/multum-view", "scene", plan, "--context", "osmesa", "--evaluations", "0"};
  }
  // If `repeat` is 0, the picture repeats the map as often as the plan says, and the view is from the nearest distance.
  std::vector<float> draw(const std::string& plan, double repeat = 0.0) const {
    std::vector<std::string> command = viewer(plan);
    command.insert(command.end(), {"-o", path("picture.exr"), "--shaders", path("shaders.json")});
    if (repeat > 0.0) command.insert(command.end(), {"--repeat", fmt::format("{:.9g}", repeat)});
    const ProgramResult drawn = run_program(command);
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
    const auto in = OIIO::ImageInput::open(path("picture.exr"));
    if (!in) return {};
    std::vector<float> values(static_cast<std::size_t>(in->spec().width) * static_cast<std::size_t>(in->spec().height) *
                              3);
    EXPECT_TRUE(in->read_image(0, 0, 0, 3, OIIO::TypeDesc::FLOAT, values.data()));
    return values;
  }

  // Returns the relative L1 error of a plan's picture, compared with a picture whose normals are shaded one by one.
  double error_of_picture(const std::string& plan, double repeat) const {
    std::vector<std::string> command = viewer(plan);
    command.insert(command.end(),
                   {"-o", path("reference.exr"), "--report", path("reference.json"), "--compare", "reference"});
    // The plan names the maps that the reference is drawn from.
    command.insert(command.end(), {"--samples", "64", "--repeat", fmt::format("{:.9g}", repeat)});
    const ProgramResult drawn = run_program(command);
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
    return json("reference.json")["pictures"].back()["relative_l1"];
  }

  // Checks the shader of the picture that was drawn last.
  void hold_shader_to_plan(const Json& plan) const {
    const Json variants = json("shaders.json");
    ASSERT_EQ(variants.size(), 1u);
    std::string held = reached_code(variants[0]["fragment"], path("fragment.c"));
    EXPECT_NE(held.find("multum_fetch_surface"), std::string::npos);
    for (const Json& uniform : variants[0]["uniforms"]) held += uniform.get<std::string>() + "\n";
    Json effects = plan["objects"][0]["effects"];
    for (const Json& effect : plan["maps"][0]["effects"]) effects.push_back(effect);
    std::size_t decided = 0;
    for (const Json& effect : effects)
      for (const EffectMark& mark : kMarks) {
        if (effect["effect"] != mark.effect) continue;
        ++decided;
        EXPECT_EQ(std::regex_search(held, std::regex(mark.mark)), effect["needed"].get<bool>()) << effect << held;
      }
    EXPECT_GE(decided, std::size(kMarks) - 1);  // The plan decides whether lobes have colours only if the map has
                                                // colours.
    // Levels that are not stored must never be visible.
    EXPECT_EQ(held.find("normal_map"), std::string::npos);
  }

  // Expects that the picture's difference from the expected picture is at most the error that the bakes and the plan
  // state, and at most the known difference of the scene.
  void hold_picture(const SceneCase& c, const std::string& from, const std::vector<float>& picture,
                    const std::vector<float>& expected, double stated, double planned) const {
    double off = 0.0, all = 0.0;
    for (std::size_t i = 0; i < picture.size() && i < expected.size(); ++i) {
      off += static_cast<double>(std::abs(picture[i] - expected[i]));
      all += static_cast<double>(expected[i]);
    }
    EXPECT_GT(all, 0.0);
    EXPECT_EQ(picture.size(), expected.size());
    EXPECT_LE(off, (stated + 1e-6) * all) << 100.0 * off / all << " %, stated " << 100.0 * stated;
    EXPECT_LE(off, (planned + 1e-6) * all) << 100.0 * off / all << " %, planned " << 100.0 * planned;
    EXPECT_LE(off, c.difference_max * all) << 100.0 * off / all << " %";
    RecordProperty(c.name + " " + from, fmt::format("{:.3g} of {:.3g} %", 100.0 * off / all, 100.0 * stated));
  }

  // Bakes and draws; the pictures must differ by no more than the plan states. Returns the report.
  Json hold_to_default(const SceneCase& c) const {
    SCOPED_TRACE(c.name);
    const ProgramResult baked = multum({"bake", write_scene(c), "-o", path(c.name)});
    EXPECT_EQ(baked.exit_code, 0) << baked.err;
    Json plan = json(c.name + "/plan.json");
    const Json report = json(c.name + "/report.json");
    const double of_map = plan["maps"][0]["stated_difference"];
    const double planned = plan["objects"][0]["stated_difference"];
    double stated = planned;
    if (report["maps"][0].contains("difference_from_default"))
      stated += report["maps"][0]["difference_from_default"]["at_most"].get<double>() - of_map;
    const std::vector<float> picture = draw(path(c.name + "/plan.json"));
    hold_shader_to_plan(plan);
    std::vector<std::string> command = {"bake", path(c.normal + "_normal.png"), "-o",
                                        path(c.name + "/default.ndf.exr")};
    if (!c.albedo.empty()) command.insert(command.end(), {"--albedo", path(c.albedo)});
    EXPECT_EQ(multum(command).exit_code, 0);
    Json& view = plan["objects"][0]["view"];
    const bool is_fresnel_fixed = view.contains("fixed-fresnel");
    view["file"] = "default.ndf.exr";
    view.erase("colour_map");
    view.erase("stored_only");
    view.erase("fixed-fresnel");
    write_bytes(path(c.name + "/default.json"), plan.dump());
    hold_picture(c, "near", picture, draw(path(c.name + "/default.json")), stated, planned);
    // From a larger distance, each pixel covers several texels and shows coarser levels.
    const double repeat = kFarther * view["repeat"].get<double>();
    hold_picture(c, "far", draw(path(c.name + "/plan.json"), repeat), draw(path(c.name + "/default.json"), repeat),
                 stated, planned);
    // The stated errors were measured on these bakes. The error of the scene's picture, compared with normals that are
    // shaded one by one, must not be higher.
    if (!is_fresnel_fixed) {  // otherwise the reference would have a fixed Fresnel term too
      const double own = error_of_picture(path(c.name + "/plan.json"), repeat),
                   usual = error_of_picture(path(c.name + "/default.json"), repeat);
      EXPECT_LT(own, usual + 0.012);  // With diffuse light the errors are 5.5 % and 4.5 %. Otherwise they are equal.
    }
    return report;
  }
  static bool is_compared(const Json& report) { return report["maps"][0].contains("difference_from_default"); }
  static bool has_em(const Json& report) {
    bool launched = false, built = false;
    for (const auto& [kernel, count] : report["launches"].items())
      launched |= kernel.find("_em_") != std::string::npos || kernel == "movmf_start" || kernel == "movmf_level_zero";
    for (const auto& [file, count] : report["builds"].items())
      built |= file.find("_em_") != std::string::npos || file == "movmf_start" || file == "movmf_level_zero";
    EXPECT_EQ(launched, built);
    return launched;
  }
  static std::vector<std::string> names(const Json& counts) {
    std::vector<std::string> found;
    for (const auto& [name, count] : counts.items()) found.push_back(name);
    return found;
  }
};

const std::vector<std::string> kAverageKernels = {"mip_blocks", "mip_features", "mip_levels", "movmf_shade"};
const std::vector<std::string> kAveragePrograms = {"mip_box", "movmf_shade"};

TEST_F(SceneCommandTest, AFlatWallIsOneTexel) {
  write_image("flat_normal.png", 64, [](int, int, int c) { return c == 2 ? 1.0f : 128.0f / 255.0f; });
  const Json report = hold_to_default({.name = "flat", .normal = "flat"});
  EXPECT_EQ(names(report["launches"]), (std::vector<std::string>{"mip_blocks", "mip_features", "mip_levels"}));
  EXPECT_EQ(names(report["builds"]), std::vector<std::string>{"mip_box"});
  EXPECT_EQ(report["bytes"], 8.0);
  EXPECT_FALSE(is_compared(report)) << "a bound for the map itself must be stated";
}

TEST_F(SceneCommandTest, DiffuseLightFitsNothing) {
  const Json report = hold_to_default({.name = "diffuse", .material = "brdf = \"lambert\"\n", .difference_max = 0.04});
  EXPECT_EQ(names(report["launches"]), kAverageKernels);
  EXPECT_EQ(names(report["builds"]), kAveragePrograms);
  ASSERT_TRUE(is_compared(report));
  const Json difference = report["maps"][0]["difference_from_default"];
  EXPECT_EQ(difference["brdf"], "lambert");
  EXPECT_GT(difference["error"], 0.0);
  EXPECT_EQ(difference["confidence"], 0.0) << "the whole map was compared";
  EXPECT_GE(difference["at_most"], difference["error"]);
}

TEST_F(SceneCommandTest, OneFarObjectFitsNoFineLevels) {
  const Json report = hold_to_default({.name = "far", .distance = "60, 80"});
  EXPECT_TRUE(has_em(report));
  EXPECT_FALSE(is_compared(report)) << "omitted levels must not change other levels";
  for (const auto& [kernel, count] : report["launches"].items()) EXPECT_NE(kernel, "movmf_level_zero");
  EXPECT_FALSE(report["builds"].contains("movmf_level_zero"));
  EXPECT_GT(report["bytes_saved"], 0.0);
}

TEST_F(SceneCommandTest, ColoursThatKnowNoSlopesAreOneATexel) {
  write_image("smooth.png", 64, [](int x, int y, int c) {
    return 0.5f + 0.3f * std::sin(6.2831853f / 64.0f * static_cast<float>(c == 0 ? x : c == 1 ? y : x + y));
  });
  const Json report = hold_to_default({.name = "colour",
                                       .albedo = "smooth.png",
                                       .material = "brdf = \"blinn-phong\"\nexponent = 20\n",
                                       .difference_max = 0.008});
  EXPECT_TRUE(has_em(report));
  EXPECT_FALSE(report["builds"].contains("movmf_features")) << "no kernel may distribute colours among lobes";
  EXPECT_TRUE(fs::exists(path("colour/wall.colours.exr")));
}

TEST_F(SceneCommandTest, AnEnvironmentNeedsNoLights) {
  write_sky();
  SceneCase scene{.name = "sky", .material = "brdf = \"lambert\"\n", .difference_max = 1e-4};
  scene.light = kSky;
  const Json report = hold_to_default(scene);
  EXPECT_FALSE(has_em(report));
  const Json plan = json("sky/plan.json");
  for (const Json& effect : plan["objects"][0]["effects"]) {
    const bool is_light = effect["effect"] == "distant lights" || effect["effect"] == "environment, highlight";
    if (is_light || effect["effect"] == "environment, diffuse") {
      EXPECT_EQ(effect["needed"], !is_light) << effect;
    }
  }
}

// Four directions with their own colours, seen from near, need exactly the file of the default bake.
TEST_F(SceneCommandTest, EverythingIsTheDefaultBake) {
  write_image("four_normal.png", 64, [](int x, int y, int c) {
    return c == 0 ? (x % 2 == 0 ? 0.2f : 0.8f) : c == 1 ? (y % 2 == 0 ? 0.2f : 0.8f) : 0.7646f;
  });
  write_image("four_albedo.png", 64, [](int x, int y, int c) {
    return c == 0 ? static_cast<float>(x % 2) : c == 1 ? static_cast<float>(y % 2) : 0.3f;
  });
  write_sky();
  const Json report = hold_to_default({.name = "every",
                                       .normal = "four",
                                       .albedo = "four_albedo.png",
                                       .material = "brdf = \"ggx\"\nroughness = [0.3, 0.6]\n",
                                       .light = std::string(kSun) + "[[light]]\nposition = [0, 30, 2]\n" + kSky});
  EXPECT_TRUE(has_em(report));
  EXPECT_TRUE(report["builds"].contains("movmf_features"));
  EXPECT_EQ(json("every/plan.json")["maps"][0]["stated_difference"], 0.0);
}

// For a metal seen from almost straight above, the Fresnel factor F varies so little that the shader needs no code for
// it. For other materials it varies more.
TEST_F(SceneCommandTest, FresnelIsANumberWhereItDiffersLittle) {
  SceneCase scene{
      .name = "metal", .material = "brdf = \"ggx\"\nroughness = 0.4\nf0 = 0.97\ndiffuse = 0\n", .difference_max = 0.02};
  scene.object = "tilt = 20\n";
  hold_to_default(scene);
  const Json plan = json("metal/plan.json");
  EXPECT_TRUE(plan["objects"][0]["view"].contains("fixed-fresnel"));
  EXPECT_GT(plan["objects"][0]["stated_difference"], plan["maps"][0]["stated_difference"]);
  scene.name = "dielectric";
  scene.material = "brdf = \"ggx\"\nroughness = 0.4\n";
  EXPECT_EQ(multum({"plan", write_scene(scene), "-o", path("dielectric.json")}).exit_code, 0);
  EXPECT_FALSE(json("dielectric.json")["objects"][0]["view"].contains("fixed-fresnel"));
}

TEST_F(SceneCommandTest, ARunGoesOnWhereItWas) {
  const std::string scene = write_scene({.name = "diffuse", .material = "brdf = \"lambert\"\n"});
  ASSERT_EQ(multum({"bake", scene, "-o", path("out"), "-q"}).exit_code, 0);
  const auto time = fs::last_write_time(path("out/wall.ndf.exr"));
  Json row = json("out/report.json")["maps"][0];
  EXPECT_TRUE(row.contains("difference_from_default"));
  EXPECT_FALSE(row["bake"]["measured_error"].empty());
  const ProgramResult again = multum({"bake", scene, "-o", path("out")});
  ASSERT_EQ(again.exit_code, 0);
  EXPECT_NE(again.out.find("nothing to bake"), std::string::npos) << again.out;
  EXPECT_EQ(fs::last_write_time(path("out/wall.ndf.exr")), time);
  EXPECT_EQ(json("out/report.json")["launches"], Json::object());
  row["unchanged"] = true;
  EXPECT_EQ(json("out/report.json")["maps"][0], row) << "the measured errors must stay";
  ASSERT_EQ(multum({"bake", scene, "-o", path("out"), "-q", "--force"}).exit_code, 0);
  EXPECT_NE(fs::last_write_time(path("out/wall.ndf.exr")), time);
}

TEST_F(SceneCommandTest, PlansArePrintedAndWritten) {
  const std::string scene = write_scene({.name = "diffuse", .material = "brdf = \"lambert\"\n"});
  const ProgramResult table = multum({"plan", scene, "--width", "80", "-o", path("plan.json")});
  ASSERT_EQ(table.exit_code, 0) << table.err;
  EXPECT_NE(table.out.find("several lobes, EM         no"), std::string::npos) << table.out;
  const ProgramResult printed = multum({"plan", scene, "--json"});
  EXPECT_EQ(Json::parse(printed.out)["maps"][0]["chosen"]["lobes"], 1);
  EXPECT_EQ(json("plan.json")["maps"][0]["chosen"], Json::parse(printed.out)["maps"][0]["chosen"]);
}

TEST_F(SceneCommandTest, AMapAloneIsNoScene) {
  make_map("alone", 16);
  expect_refusal(multum({"plan", path("alone_normal.png")}), kUsage,
                 {"alone_normal.png: is an image", "scene.toml", "multum tradeoff "});
}

TEST_F(SceneCommandTest, ABudgetOfTimeIsKeptOrRefused) {
  SceneCase scene{.name = "quick"};
  scene.material = "brdf = \"blinn-phong\"\nexponent = 100\n[budget]\nbake_ms = ";
  const std::string material = scene.material;
  ASSERT_EQ(multum({"plan", write_scene({.name = "free"}), "-o", path("free.json")}).exit_code, 0);
  const double free = json("free.json")["bake_ms"];
  scene.material = material + fmt::format("{:.6g}\n", 1.001 * free);
  ASSERT_EQ(multum({"plan", write_scene(scene), "-o", path("quick.json")}).exit_code, 0);
  EXPECT_EQ(json("quick.json")["maps"][0]["chosen"], json("free.json")["maps"][0]["chosen"]);
  scene.material = material + fmt::format("{:.6g}\n", 0.999 * free);
  ASSERT_EQ(multum({"bake", write_scene(scene), "-o", path("quick")}).exit_code, 0);
  EXPECT_LE(json("quick/plan.json")["bake_ms"], 0.999 * free);
  EXPECT_NE(json("quick/plan.json")["maps"][0]["chosen"], json("free.json")["maps"][0]["chosen"]);
  scene.material = material + "1\n";
  const ProgramResult refused = multum({"bake", write_scene(scene), "-o", path("none")});
  expect_refusal(refused, kVerification, {"no settings", "bake_ms", "1", "lowest"});
  EXPECT_FALSE(fs::exists(path("none/plan.json")));
}

// The estimates are close to the measured errors. The plan and the report state the settings that the trials chose,
// both after the trials and in a later run that finds every map up to date.
TEST_F(SceneCommandTest, ATargetIsReachedByTrialsThatAreReported) {
  SceneCase scene{.name = "target"};
  scene.material = "brdf = \"blinn-phong\"\nexponent = 100\n[budget]\ntarget_error = 0.25\n";
  const std::string file = write_scene(scene);
  for (const bool again : {false, true}) {
    SCOPED_TRACE(again);
    const ProgramResult baked = multum({"bake", file, "-o", path("target")});
    ASSERT_EQ(baked.exit_code, 0) << baked.err;
    EXPECT_EQ(baked.out.find("differs from the default bake"), std::string::npos) << baked.out;
    for (const char* of_plan : {"map wall: ", "several lobes, EM", "object front: ", "in total: "}) {
      const std::size_t at = baked.out.find(of_plan);
      EXPECT_TRUE(at != std::string::npos && baked.out.find(of_plan, at + 1) == std::string::npos)
          << of_plan << ", expected once\n"
          << baked.out;
    }
    EXPECT_TRUE(contains(baked.out, "1 to 8 lobes (trials choose the")) << baked.out;
    const Json plan = json("target/plan.json"), report = json("target/report.json");
    const ProgramResult info = multum({"info", path("target/wall.ndf.exr")});
    ASSERT_EQ(info.exit_code, 0) << info.err;
    const std::string lobes = fmt::format("movmf: {} von Mises-Fisher", plan["maps"][0]["chosen"]["lobes"].get<int>());
    EXPECT_NE(info.out.find(lobes), std::string::npos) << info.out << lobes;
    EXPECT_EQ(report["bytes"], plan["maps"][0]["chosen"]["bytes"]);
    EXPECT_FALSE(plan["maps"][0].contains("trials")) << "they have been made";
    EXPECT_EQ(plan["bytes_range"], Json::array({plan["bytes"], plan["bytes"]}));
    for (const Json& error : report["maps"][0]["bake"]["error"])
      if (error["brdf"] == "blinn-phong:100") {
        EXPECT_LE(error["relative_l1"].get<double>() + error["confidence_95"].get<double>(), 0.25);
      }
  }
}

// The plan estimates that one lobe is enough. A bake with one lobe already exists, so its measured error decides.
// Estimates cover exponents up to s = 200, so for s = 3000 they are less certain than the measurement of a bake.
TEST_F(SceneCommandTest, WhatIsThereIsHeldToANewTarget) {
  SceneCase scene{.name = "one"};
  const std::string sharp = "brdf = \"blinn-phong\"\nexponent = 3000\n", material = sharp + "[budget]\n";
  const auto lobes_and_error = [&](const std::string& budget) {
    scene.material = material + budget;
    const ProgramResult baked = multum({"bake", write_scene(scene), "-o", path("one")});
    EXPECT_EQ(baked.exit_code, 0) << baked.err;
    const Json row = json("one/report.json")["maps"][0];
    double error = 0.0;
    for (const Json& one : row["bake"]["error"])
      if (one["brdf"] == "blinn-phong:3000")
        error = one["relative_l1"].get<double>() + one["confidence_95"].get<double>();
    return std::pair(json("one/plan.json")["maps"][0]["chosen"]["lobes"].get<int>(), error);
  };
  ASSERT_EQ(multum({"plan", write_scene({.name = "free", .material = sharp}), "-o", path("free.json")}).exit_code, 0);
  const Json free = json("free.json");
  double estimate = 0.0;
  for (const Json& candidate : free["maps"][0]["candidates"])
    if (candidate["name"] == "vmf, 1 lobe") estimate = candidate["error"];
  const auto [lobes, error] = lobes_and_error(fmt::format("target_error = {}\n", 3.0));
  EXPECT_EQ(lobes, 1);
  ASSERT_GT(estimate, 0.0) << "no such candidate";
  ASSERT_LT(estimate, 0.9 * error) << "a target between them would test nothing";
  const double target = 0.5 * (estimate + error);
  const auto [more, better] = lobes_and_error(fmt::format("target_error = {}\n", target));
  EXPECT_GT(more, 1);
  EXPECT_LE(better, target);
}

// The basis BRDFs have their own colours: red for the first weight and blue for the second.
TEST_F(SceneCommandTest, EveryMaterialKeepsItsColour) {
  write_image("flat_normal.png", 64, [](int, int, int c) { return c == 2 ? 1.0f : 128.0f / 255.0f; });
  const auto weights = OIIO::ImageOutput::create(path("weights.tif"));
  std::vector<std::uint8_t> values;
  for (int i = 0; i < 64 * 64; ++i) {
    values.push_back(i % 16 < 8 ? 255 : 0);
    values.push_back(i % 16 < 8 ? 0 : 255);
  }
  ASSERT_TRUE(weights && weights->open(path("weights.tif"), OIIO::ImageSpec(64, 64, 2, OIIO::TypeDesc::UINT8)));
  ASSERT_TRUE(weights->write_image(OIIO::TypeDesc::UINT8, values.data()));
  ASSERT_TRUE(weights->close());
  const std::string lambert = "brdf = \"lambert\"\ndiffuse = ";
  const auto write = [&](const std::string& materials) {
    write_bytes(path("two.toml"), fmt::format(kHead, "flat", "weights = \"weights.tif\"") +
                                      "[[material]]\nname = \"red\"\n" + lambert +
                                      "[0.8, 0.1, 0.1]\n[[material]]\nname = \"blue\"\n" + lambert +
                                      "[0.1, 0.1, 0.8]\n" + with_object(materials) + kSun);
  };
  write("materials = [\"red\", \"blue\"]");
  const ProgramResult baked = multum({"bake", path("two.toml"), "-o", path("two")});
  ASSERT_EQ(baked.exit_code, 0) << baked.err;
  const std::vector<float> picture = draw(path("two/plan.json"));
  int red = 0, blue = 0;
  for (std::size_t i = 0; i + 2 < picture.size(); i += 3) {
    red += picture[i] > 4.0f * picture[i + 2] ? 1 : 0;
    blue += picture[i + 2] > 4.0f * picture[i] ? 1 : 0;
  }
  EXPECT_GT(red, 500);
  EXPECT_GT(blue, 500);
  write("materials = [\"red\", \"blue\", \"red\"]");
  const ProgramResult refused = multum({"plan", path("two.toml")});
  expect_refusal(refused, kInput, {"weights.tif: ", "2 weights", "expected 3", "\"front\"", "for each material"});
}

// Four directions and four BRDFs: the weights say which facets shine. One lobe is not enough, and the plan says so.
TEST_F(SceneCommandTest, WeightsAndRoughnessAreEstimated) {
  write_image("four_normal.png", 64, [](int x, int y, int c) {
    return c == 0 ? (x % 2 == 0 ? 0.2f : 0.8f) : c == 1 ? (y % 2 == 0 ? 0.2f : 0.8f) : 0.7646f;
  });
  write_image("flat_normal.png", 64, [](int, int, int c) { return c == 2 ? 1.0f : 128.0f / 255.0f; });
  write_image("weights.png", 64, [](int x, int, int c) { return c == x % 2 ? 1.0f : 0.0f; });
  write_image("rough.png", 64, [](int, int, int) { return 0.4f; });
  const auto lobes = [&](const std::string& normal, const std::string& keys, const std::string& material,
                         const std::string& object) {
    const std::string text =
        fmt::format(kHead, normal, keys) + "[[material]]\nname = \"paint\"\n" + material + with_object(object) + kSun;
    write_bytes(path("w.toml"), text);
    const ProgramResult planned = multum({"plan", path("w.toml"), "-o", path("w.json")});
    EXPECT_EQ(planned.exit_code, 0) << planned.err;
    const Json map = json("w.json")["maps"][0];
    EXPECT_GT(map["default"]["error"], 0.0);
    return map["chosen"]["lobes"].get<int>();
  };
  const std::string rough = "brdf = \"roughness-map\"\n", keys = "roughness = \"rough.png:R\"";
  EXPECT_EQ(lobes("flat", keys, rough, "material = \"paint\""), 1) << "a flat map with one roughness needs one lobe";
  EXPECT_GT(lobes("four", keys, rough, "material = \"paint\""), 1);
  const std::string two =
      "brdf = \"lambert\"\n[[material]]\nname = \"shine\"\nbrdf = \"blinn-phong\"\nexponent = 100\n";
  EXPECT_EQ(lobes("flat", "weights = \"weights.png\"", two, "materials = [\"paint\", \"shine\", \"paint\"]"), 1);
  EXPECT_GT(lobes("four", "weights = \"weights.png\"", two, "materials = [\"paint\", \"shine\", \"paint\"]"), 1);
}

TEST_F(SceneCommandTest, WhatIsWrongIsRefused) {
  const std::string scene = write_scene({.name = "s"});
  ProgramResult result = multum({"bake", scene, "-o", path("out"), "--lobes", "2"});
  expect_refusal(result, kUsage, {"--lobes", "cannot be given with"});
  result = multum({"bake", scene});
  EXPECT_EQ(result.exit_code, 2);
  write_bytes(path("bad.toml"), "[scene]\n");
  result = multum({"plan", path("bad.toml")});
  expect_refusal(result, kInput, {"bad.toml:1: ", "scene", "unknown key"});
  result = multum({"plan", path("none.toml")});
  EXPECT_EQ(result.exit_code, 3);
  result = multum({"plan", path("")});
  expect_refusal(result, kInput, {folder_.path(), "a folder", "scene"});
  SceneCase square{.name = "square"};
  square.light = "[environment]\nfile = \"map_normal.png\"\n";
  result = multum({"plan", write_scene(square)});
  expect_refusal(result, kInput, {"map_normal.png: ", "64 x 64", "environment"});
  const std::string view = std::string(MULTUM_BIN_DIR) + "/multum-view";
  result = run_program({view, "scene", path("none.json"), "-o", path("x.png")});
  expect_refusal(result, kInput, {"none.json: ", "no such"});
  result = run_program({view, "--scene", path("bad.toml"), path("map.ndf.exr"), "-o", path("x.png")});
  expect_refusal(result, kUsage, {"unknown option '--scene'", "'multum-view animate'"});
  result = run_program({std::string(MULTUM_BIN_DIR) + "/multum-view", "scene", path("bad.toml"), "-o", path("x.png")});
  expect_refusal(result, kInput, {"bad.toml", "not a plan"});
}

}  // namespace
}  // namespace multum::testing
