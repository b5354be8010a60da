// SPDX-License-Identifier: Apache-2.0
// Runs every kernel once under oclgrind, a simulator that finds errors which drivers do not report: accesses outside
// buffers, data races, and wrong calls. Whole bakes run in it, as a user would start them.
//
// The option --uninitialized is not used, because with it oclgrind 21.10 (Debian 12) stops at LLVM's freeze
// instruction. Without optimisation, the option also reports tens of thousands of values as uninitialised. They are in
// buffers over the program's own memory (CL_MEM_USE_HOST_PTR) and in structs that are passed by value.
#include <nlohmann/json.hpp>
#include <regex>

#include "tests/cli/program.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

class OclgrindTest : public CliTest {
 protected:
  void SetUp() override {
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "oclgrind is preloaded, and the address sanitizer must be first";
#endif
    if (!program_works("oclgrind", "--version")) GTEST_SKIP() << "no oclgrind (Debian package oclgrind)";
  }

  // Runs the program in oclgrind and expects no report.
  ProgramResult simulate(const std::vector<std::string>& arguments, const std::vector<std::string>& options = {}) {
    std::vector<std::string> command = {"oclgrind", "--data-races", "--check-api", "--log", path("complaints")};
    command.insert(command.end(), options.begin(), options.end());
    command.insert(command.end(), arguments.begin(), arguments.end());
    std::filesystem::remove(path("complaints"));
    ProgramResult result = run_program(command);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(std::filesystem::exists(path("complaints"))) << "oclgrind did not run";
    EXPECT_EQ(read_bytes(path("complaints")), "");
    return result;
  }

  // Bakes in oclgrind and collects the launched kernels from the report.
  void bake(std::vector<std::string> options) {
    options.insert(options.begin(),
                   {"bake", "--bumpformat", "normal", "--report", path("report.json"), "-o", path("map.ndf.exr")});
    simulate(multum_command(options));
    const auto report = nlohmann::json::parse(read_bytes(path("report.json")));
    EXPECT_EQ(report["device"], "Oclgrind Simulator");
    EXPECT_EQ(report["counts"]["nonfinite"], 0);
    for (const auto& [kernel, count] : report["launches"].items()) launched_.insert(kernel);
  }

  // Exports in oclgrind and collects the launched kernels.
  void export_material(std::vector<std::string> options, const std::vector<std::string>& of_oclgrind = {}) {
    options.insert(options.begin(), "export");
    options.insert(options.end(),
                   {"--bumpformat", "normal", "--no-measure", "--report", path("report.json"), "-o", path("material")});
    simulate(multum_command(options), of_oclgrind);
    const auto report = nlohmann::json::parse(read_bytes(path("report.json")));
    for (const auto& [kernel, count] : report["launches"].items()) launched_.insert(kernel);
  }

  // Runs a command that makes a pyramid in oclgrind, and collects the launched kernels.
  void make_pyramid(std::vector<std::string> command) {
    command.insert(command.end(), {"--report", path("report.json"), "-o", path("pyramid.exr")});
    simulate(multum_command(command));
    const auto report = nlohmann::json::parse(read_bytes(path("report.json")));
    for (const auto& [kernel, count] : report["launches"].items()) launched_.insert(kernel);
  }

  void write_maps(const std::string& name, const TestImage& normals) {
    write_test_image(path(name + ".png"), normals);
    TestImage albedo = normals;  // the colours do not matter
    albedo.colour_space = "sRGB";
    write_test_image(path(name + "_albedo.png"), albedo);
  }

  std::set<std::string> launched_;
};

// Makes a map of six normals, in tiles of 3 x 4 pixels.
TestImage few_normals(int width, int height) {
  TestImage all = normal_image(width, height), image = all;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = all.at((x / 3 + y / 4 * 5) % 6 * 5, 0, c);
  return image;
}

// Returns the names of all kernels in kernels/*.cl.
std::set<std::string> all_kernels() {
  std::set<std::string> names;
  const std::regex kernel("__kernel void (\\w+)\\(");
  for (const auto& entry : std::filesystem::directory_iterator(std::string(MULTUM_SOURCE_DIR) + "/kernels")) {
    if (entry.path().extension() != ".cl") continue;
    const std::string text = read_bytes(entry.path().string());
    for (std::sregex_iterator i(text.begin(), text.end(), kernel), end; i != end; ++i) names.insert((*i)[1]);
  }
  return names;
}

TEST_F(OclgrindTest, EveryKernelRunsWithoutComplaint) {
  // The maps are small, so their coarsest texel has few normals. Either a team of work-items bins these normals, or the
  // kernels fit them in chunks, in 60 iterations.
  write_maps("odd", normal_image(35, 31));  // coarse texels cover fractions of finer ones
  write_maps("odd_of_few", few_normals(35, 31));
  write_maps("even_of_few", few_normals(64, 32));
  write_maps("even", normal_image(32, 16));
  write_maps("tiny", normal_image(7, 6));
  // Measuring errors is slow here, so only the small even map and the tiny map are measured. Some of these bakes have
  // colours or use the scalar kernel.
  bake({path("odd.png"), "--albedo", path("odd_albedo.png"), "--iterations", "1", "--lobes", "3", "--no-measure",
        "--no-start-search"});
  bake({path("odd_of_few.png"), "--albedo", path("odd_of_few_albedo.png"), "--iterations", "1", "--passes", "1",
        "--lobes", "2", "--scalar", "--no-start-search", "--no-measure"});
  bake({path("odd.png"), "--albedo", path("odd_albedo.png"), "--reference", "--iterations", "1", "--passes", "1",
        "--lobes", "2", "--scalar", "--no-start-search", "--no-measure"});
  bake({path("even.png"), "--iterations", "1", "--passes", "1", "--lobes", "2", "--no-start-search"});
  bake({path("even_of_few.png"), "--albedo", path("even_of_few_albedo.png"), "--iterations", "1", "--passes", "1",
        "--lobes", "2", "--no-start-search", "--no-measure"});
  bake({path("even_of_few.png"), "--reference", "--iterations", "2", "--passes", "1", "--lobes", "2",
        "--no-start-search", "--no-measure"});
  bake({path("even_of_few.png"), "--refine", "--iterations", "1", "--passes", "1", "--lobes", "2", "--no-start-search",
        "--no-measure"});
  bake({path("tiny.png"), "--order", "scanline", "--iterations", "2"});
  bake({path("tiny.png"), "--order", "scanline", "--iterations", "1", "--lobes", "8", "--albedo",
        path("tiny_albedo.png"), "--scalar", "--no-start-search"});
  bake({path("odd.png"), "--ndf", "gmm", "--reference", "--iterations", "1", "--passes", "1", "--lobes", "2",
        "--scalar", "--no-start-search", "--no-measure"});
  bake({path("tiny.png"), "--roughness", path("tiny_albedo.png") + ":G", "--weights", path("tiny_albedo.png"),
        "--iterations", "1", "--passes", "1", "--lobes", "2", "--scalar", "--no-start-search", "--no-measure"});
  bake({path("odd.png"), "--albedo", path("odd_albedo.png"), "--ndf", "moments", "--no-measure"});
  bake({path("tiny.png"), "--ndf", "moments", "--first-level", "1"});
  bake({path("tiny.png"), "--albedo", path("tiny_albedo.png"), "--ndf", "sh", "--sh-order", "3", "--first-level", "1"});

  export_material({path("tiny.png"), "--roughness", path("tiny_albedo.png"), "--anisotropy"});
  export_material({path("tiny.png"), "--fast"});
  // Inlined functions that return structs leave the intrinsic llvm.experimental.noalias.scope.decl, which oclgrind does
  // not support.
  export_material({path("tiny.png"), "--roughness", path("tiny_albedo.png"), "--format", "ktx2", "--texels", "bc"},
                  {"--build-options", "-cl-opt-disable"});

  make_pyramid({"mip", path("odd_albedo.png")});
  make_pyramid({"reflectance", "--light", "0,0.6,0.8", "--light", "1,0,-0.2", "--size", "9"});

  // Adds the kernels that only tests launch, and the kernels of texture inference. The instruction counts of oclgrind
  // name these kernels.
  const std::regex counted("kernel '(\\w+)'");
  const std::string programs = MULTUM_BIN_DIR;
  for (const std::vector<std::string>& command :
       {std::vector{programs + "/kernel_test", std::string("--gtest_filter=NumericsTest.*:SharedStructTest.*")},
        std::vector{programs + "/inference_test",
                    std::string("--gtest_filter=*EndsWhereNothingLeadsDown/4:*FindsWhatEigenFinds/3")},
        std::vector{programs + "/transform_test", std::string("--gtest_filter=*CoefficientsOfASmallTexture*")},
        multum_command({"selftest", "--filter", "highlight-cosines-of-every-width"}),
        multum_command({"selftest", "--filter", "planes-up-to-the-horizon"})}) {
    const ProgramResult tests = simulate(command, {"--inst-counts"});
    for (std::sregex_iterator i(tests.out.begin(), tests.out.end(), counted), end; i != end; ++i)
      launched_.insert((*i)[1]);
  }

  const std::set<std::string> all = all_kernels();
  EXPECT_GE(all.size(), 11u);
  for (const std::string& kernel : all) EXPECT_TRUE(launched_.count(kernel) == 1) << kernel << " was never launched";
}

}  // namespace
}  // namespace multum::testing
