// SPDX-License-Identifier: Apache-2.0
// Reads files with independent programs: OpenImageIO's oiiotool, and the Python files of docs/reference.
#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <sstream>

#include "host/fields/inferred/filter_matrix.h"
#include "host/fields/inferred/inferred_texture.h"
#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/asset/lobes/gmm_quantize.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/foundation/base/files/content_hash.h"
#include "tests/cli/program.h"

namespace multum::testing {
namespace {

class OtherReadersTest : public CliTest {
 protected:
  void bake(const std::vector<std::string>& options) {
    make_map("map", 64);
    std::vector<std::string> arguments = {"bake", path("map_normal.png"), "--albedo", path("map_albedo.png"),
                                          "-o",   path("map.ndf.exr")};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ProgramResult result = multum(arguments);
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
  // Uses the colours also as roughness and as three weights.
  void append_materials(std::vector<std::string>& options) const {
    options.insert(options.end(), {"--roughness", path("map_albedo.png") + ":G", "--weights", path("map_albedo.png")});
  }
};

int count_of(const std::string& text, const std::string& all) {
  int count = 0;
  for (std::size_t i = all.find(text); i != std::string::npos; i = all.find(text, i + 1)) ++count;
  return count;
}

TEST_F(OtherReadersTest, OiiotoolFindsEveryPartChannelAndAttribute) {
  if (!program_works("oiiotool", "--help")) GTEST_SKIP() << "no oiiotool (Debian package openimageio-tools)";
  bake({"--lobes", "3", "--wrap", "clamp", "--twrap", "mirror"});
  const ProgramResult info = run_program({"oiiotool", "--info", "-v", "-a", path("map.ndf.exr")});
  ASSERT_EQ(info.exit_code, 0) << info.err;
  std::vector<std::string> in_order = {
      "7 subimages: 64x64 [h,h,h,h,f,f], 32x32 [f,f,f,f], 32x32 [f,f,f,f], 32x32 [f,f,f,f], 32x32 [h,h,h]",
      "subimage  0:   64 x   64, 6 channel, half/half/half/half/float/float openexr",
      "channel list: finest.albedo.R (half), finest.albedo.G (half), finest.albedo.B (half), finest.lobe.X (half), "
      "finest.normalX.X (float), finest.normalY.X (float)",
      "name: \"finest\""};
  for (int part = 0; part < 6; ++part) {
    const int j = part % 3;
    in_order.push_back(fmt::format("subimage  {}:   32 x   32, {} channel, {} openexr", part + 1, part < 3 ? 4 : 3,
                                   part < 3 ? "float" : "half"));
    in_order.push_back("MIP-map levels: 32x32 16x16 8x8 4x4 2x2 1x1");
    in_order.push_back(
        part < 3 ? fmt::format("channel list: lobe{0}.vMF.R, lobe{0}.vMF.G, lobe{0}.vMF.B, lobe{0}.vMF.A", j)
                 : fmt::format("channel list: colour{0}.albedo.R, colour{0}.albedo.G, colour{0}.albedo.B", j));
    in_order.push_back(fmt::format("name: \"{}.{}\"", part < 3 ? "lobe" : "colour", j));
  }
  std::size_t at = 0;
  for (const std::string& line : in_order) {
    const std::size_t found = info.out.find(line, at);
    ASSERT_NE(found, std::string::npos) << line << " is not in its place in\n" << info.out;
    at = found + line.size();
  }
  const BakedProvenance from = read_movmf_header(path("map.ndf.exr")).header.provenance;
  for (const std::string& attribute :
       {std::string("multum:representation: \"movmf\""), std::string("multum:formatVersion: 3\n"),
        std::string("multum:lobeCount: 3\n"), std::string("multum:hasColours: 1\n"),
        std::string("multum:mapWidth: 64\n"), std::string("multum:mapHeight: 64\n"),
        std::string("multum:firstLevel: 0\n"), std::string("multum:encoding: \"snorm16\""),
        std::string("multum:channels: \""), std::string("multum:kappaMax: 20000\n"),
        std::string("multum:sourceName: \"map_normal.png\""),
        "multum:sourceHash: \"" + hash_file(path("map_normal.png")) + "\"",
        "multum:settings: \"" + from.settings + "\"", "multum:settingsHash: \"" + hash_text(from.settings) + "\"",
        "multum:contentHash: \"" + from.content_hash + "\"", std::string("wrapmodes: \"clamp,mirror\""),
        std::string("software: \"multum "), std::string("colorInteropID: \"data\"")}) {
    EXPECT_EQ(count_of(attribute, info.out), 7) << attribute << " is not in each part of\n" << info.out;
  }
  EXPECT_EQ(count_of("multum:measuredError: \"" + from.measured_error, info.out), 1);
  EXPECT_EQ(count_of("multum:measuredError: ", info.out), 1);
}

TEST_F(OtherReadersTest, OiiotoolFindsPartsThatBeginAtTheFirstLevel) {
  if (!program_works("oiiotool", "--help")) GTEST_SKIP() << "no oiiotool (Debian package openimageio-tools)";
  bake({"--lobes", "2", "--first-level", "2", "--no-measure"});
  const ProgramResult info = run_program({"oiiotool", "--info", "-v", "-a", path("map.ndf.exr")});
  ASSERT_EQ(info.exit_code, 0) << info.err;
  for (const char* line : {"4 subimages: 16x16 [f,f,f,f], 16x16 [f,f,f,f], 16x16 [h,h,h], 16x16 [h,h,h]",
                           "MIP-map levels: 16x16 8x8 4x4 2x2 1x1", "multum:formatVersion: 3\n",
                           "multum:firstLevel: 2\n", "multum:mapWidth: 64\n", "multum:mapHeight: 64\n"})
    EXPECT_NE(info.out.find(line), std::string::npos) << line << " is not in\n" << info.out;
}

// Imports docs/reference/read_baked.py and read_inferred.py, which the format pages link to.
std::string python_of_format_page() {
  return "import sys\nsys.dont_write_bytecode = True\nsys.path.insert(0, \"" + std::string(MULTUM_SOURCE_DIR) +
         "/docs/reference\")\nfrom read_baked import *\nfrom read_inferred import *\n";
}

// The command line names each file, its output file, its first level and its number of levels. The script writes
// amplitudes, mean vectors and colours of every level as 32-bit floats. It also asks for a level that is finer than the
// first stored one, and prints the result.
constexpr char kDriver[] = R"(
import sys
for path, output, first_level, levels in zip(*[iter(sys.argv[1:])] * 4):
    with open(output, "wb") as out:
        for level in range(int(first_level), int(levels)):
            for values in read_lobes(path, level):
                out.write(np.ascontiguousarray(values, dtype="<f4").tobytes())
    print(content_hash(path))
    print(oiio.ImageInput.open(path).spec()["multum:contentHash"])
    try:
        read_lobes(path, int(first_level) - 1)
        print("read")
    except Exception as error:
        print(error)
)";

class FloatStream {
 public:
  explicit FloatStream(const std::string& bytes) : values_(bytes.size() / sizeof(float)) {
    std::copy_n(bytes.data(), values_.size() * sizeof(float), reinterpret_cast<char*>(values_.data()));
  }
  float next() { return at_ < values_.size() ? values_[at_++] : (ADD_FAILURE() << "too few values", 0.0f); }
  std::size_t left() const { return values_.size() - at_; }

 private:
  std::vector<float> values_;
  std::size_t at_ = 0;
};

// Compares a level's arrays of read_lobes() with the lobes that host/formats/asset reads.
void expect_level(const MovmfLevel& level, const MovmfMipmap& header, FloatStream& python) {
  const bool is_half = header.header.encoding == StorageEncoding::kHalf,
             planar = header.header.representation == Representation::kGmm;
  const std::size_t texels = level.lobes[0].size(), lobes = level.lobes.size();
  std::vector<double> sums(texels, 0.0);
  for (const auto& lobe : level.lobes)
    for (std::size_t i = 0; i < texels; ++i) {
      const float amplitude = python.next();
      ASSERT_EQ(amplitude, lobe[i].w);
      sums[i] += static_cast<double>(amplitude);
    }
  for (const double sum : sums)
    ASSERT_NEAR(sum, 1.0, is_half ? 1.0 / 2048.0 : 2e-6);  // the tolerance of `multum
                                                           // verify`
  for (std::size_t j = 0; j < lobes; ++j)
    for (std::size_t i = 0; i < texels; ++i) {
      const glm::dvec4 stored(level.lobes[j][i]);
      glm::dvec3 mean = stored.w > 0.0 ? glm::dvec3(stored) / stored.w : glm::dvec3(0.0);
      if (planar) mean.z = static_cast<double>(gmm_variance(level.lobes[j][i]));
      else mean /= std::max(1.0, glm::length(mean));
      // The page's code never divides by less than 1e-20. Smaller shares are invisible, and only 32-bit floats can
      // store them.
      for (int c = 0; c < 3; ++c) {
        const auto found = static_cast<double>(python.next());
        if (stored.w > 0.0 && stored.w <= 1e-20) continue;
        ASSERT_NEAR(found, mean[c], 1e-6);
      }
    }
  const auto expect_feature = [&](std::size_t lobe, std::size_t texel, float stored) {
    const double value = static_cast<double>(stored) / std::max(static_cast<double>(level.lobes[lobe][texel].w), 1e-20);
    ASSERT_NEAR(static_cast<double>(python.next()), value, 1e-6 * std::max(1.0, value));
  };
  for (std::size_t j = 0; j < level.colours.size(); ++j)
    for (std::size_t i = 0; i < texels; ++i)
      for (int c = 0; c < 3; ++c) ASSERT_NO_FATAL_FAILURE(expect_feature(j, i, level.colours[j][i][c]));
  const auto weights = static_cast<std::size_t>(header.header.weight_count);
  for (std::size_t j = 0; j < level.weights.size(); ++j)
    for (std::size_t i = 0; i < texels * weights; ++i)
      ASSERT_NO_FATAL_FAILURE(expect_feature(j, i / weights, level.weights[j][i]));
}

TEST_F(OtherReadersTest, ThePythonOfTheFormatPageReadsWhatWeRead) {
  const std::string python = MULTUM_OIIO_PYTHON;
  if (python.empty())
    GTEST_SKIP() << "no Python that imports OpenImageIO and numpy when this was configured (Debian packages "
                    "python3-openimageio and python3-numpy)";
  const std::string code = python_of_format_page();
  write_bytes(path("read.py"), code + kDriver);
  struct Case {
    const char *encoding, *first_level, *ndf;
    bool has_materials;
  };
  std::vector<std::string> command = {python, path("read.py")};
  std::vector<MovmfMipmap> mipmaps;
  for (const auto& [encoding, first_level, ndf, has_materials] :
       {Case{"snorm16", "0", "vmf", false}, Case{"half", "0", "vmf", true}, Case{"float", "0", "vmf", false},
        Case{"snorm16", "2", "vmf", true}, Case{"half", "6", "vmf", false}, Case{"snorm16", "0", "gmm", false},
        Case{"half", "0", "gmm", false}, Case{"snorm16", "0", "gmm", true}, Case{"float", "1", "gmm", true}}) {
    std::vector<std::string> options = {"--ndf",         ndf,         "--data-format", encoding,
                                        "--first-level", first_level, "--no-measure",  "--no-start-search"};
    if (has_materials) append_materials(options);
    bake(options);
    const std::string file = path(std::to_string(mipmaps.size()));
    std::filesystem::rename(path("map.ndf.exr"), file + ".ndf.exr");
    mipmaps.push_back(read_movmf_mipmap(file + ".ndf.exr"));
    EXPECT_EQ(std::to_string(mipmaps.back().header.first_level), first_level);
    command.insert(command.end(), {file + ".ndf.exr", file, first_level, std::to_string(mipmaps.back().levels.size())});
  }
  const ProgramResult read = run_program(command);
  ASSERT_EQ(read.exit_code, 0) << read.err;
  std::istringstream said(read.out);
  for (std::size_t i = 0; i < mipmaps.size(); ++i) {
    const MovmfMipmap& mipmap = mipmaps[i];
    SCOPED_TRACE(mipmap.header.provenance.settings);
    std::string hash, stated_hash, finer;
    std::getline(said, hash), std::getline(said, stated_hash), std::getline(said, finer);
    EXPECT_EQ(hash.size(), 64u);
    EXPECT_EQ(hash, mipmap.header.provenance.content_hash);
    EXPECT_EQ(stated_hash, mipmap.header.provenance.content_hash);
    EXPECT_NE(finer.find("normal map"), std::string::npos) << finer;
    FloatStream values(read_bytes(path(std::to_string(i))));
    for (std::size_t l = static_cast<std::size_t>(mipmap.header.first_level); l < mipmap.levels.size(); ++l)
      ASSERT_NO_FATAL_FAILURE(expect_level(mipmap.levels[l], mipmap, values));
    EXPECT_EQ(values.left(), 0u);
  }
}

// Writes the arrays of every level of a file of moments.
constexpr char kMomentDriver[] = R"(
import sys
path, output, first_level, levels = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
with open(output, "wb") as out:
    for level in range(first_level, levels):
        for values in read_moments(path, level):
            out.write(np.ascontiguousarray(values, dtype="<f4").tobytes())
print(content_hash(path))
)";

TEST_F(OtherReadersTest, ThePythonOfTheFormatPageReadsMoments) {
  const std::string python = MULTUM_OIIO_PYTHON;
  if (python.empty()) GTEST_SKIP() << "no Python that imports OpenImageIO and numpy when this was configured";
  write_bytes(path("read.py"), python_of_format_page() + kMomentDriver);
  for (const int first_level : {0, 2}) {
    std::vector<std::string> options = {"--ndf", "moments", "--first-level", std::to_string(first_level),
                                        "--no-measure"};
    if (first_level == 2) append_materials(options);
    bake(options);
    const MomentMipmap mipmap = read_moment_mipmap(path("map.ndf.exr"));
    const ProgramResult read =
        run_program({python, path("read.py"), path("map.ndf.exr"), path("values"), std::to_string(first_level), "7"});
    ASSERT_EQ(read.exit_code, 0) << read.err;
    EXPECT_EQ(read.out, mipmap.header.provenance.content_hash + "\n");
    FloatStream values(read_bytes(path("values")));
    for (std::size_t l = static_cast<std::size_t>(first_level); l < mipmap.levels.size(); ++l) {
      const MomentLevel& level = mipmap.levels[l];
      for (const SlopeMoments& m : level.slopes)
        for (const float value : {m.height, m.s, m.t, m.ss, m.tt, m.st}) ASSERT_EQ(values.next(), value);
      for (const std::vector<glm::vec3>* plane : {&level.normals, &level.colours})
        for (const glm::vec3& texel : *plane)
          for (int c = 0; c < 3; ++c) ASSERT_EQ(values.next(), texel[c]);
      for (const float weight : level.weights) ASSERT_EQ(values.next(), weight);
    }
    EXPECT_EQ(values.left(), 0u);
  }
}

// Writes coefficients, colours and weights of every level of a file of spherical harmonics.
constexpr char kHarmonicsDriver[] = R"(
import sys
path, output, levels = sys.argv[1], sys.argv[2], int(sys.argv[3])
with open(output, "wb") as out:
    for level in range(levels):
        for values in read_harmonics(path, level):
            out.write(np.ascontiguousarray(values, dtype="<f4").tobytes())
print(content_hash(path))
)";

TEST_F(OtherReadersTest, ThePythonOfTheFormatPageReadsHarmonics) {
  const std::string python = MULTUM_OIIO_PYTHON;
  if (python.empty()) GTEST_SKIP() << "no Python that imports OpenImageIO and numpy when this was configured";
  write_bytes(path("read.py"), python_of_format_page() + kHarmonicsDriver);
  for (const bool has_materials : {false, true}) {
    std::vector<std::string> options = {"--ndf", "sh", "--sh-order", "3", "--no-measure"};
    if (has_materials) append_materials(options);
    bake(options);
    const ShMipmap mipmap = read_sh_mipmap(path("map.ndf.exr"));
    const ProgramResult read = run_program({python, path("read.py"), path("map.ndf.exr"), path("values"), "7"});
    ASSERT_EQ(read.exit_code, 0) << read.err;
    EXPECT_EQ(read.out, mipmap.header.provenance.content_hash + "\n");
    FloatStream values(read_bytes(path("values")));
    for (const ShLevel& level : mipmap.levels) {
      for (std::size_t i = 0; i < level.parts[0].size(); ++i)
        for (int k = 0; k < sh_coefficient_count(3); ++k) ASSERT_EQ(values.next(), level.value(k, i));
      for (const glm::vec3& texel : level.colours)
        for (int c = 0; c < 3; ++c) ASSERT_EQ(values.next(), texel[c]);
      for (const float weight : level.weights) ASSERT_EQ(values.next(), weight);
    }
    EXPECT_EQ(values.left(), 0u);
  }
}

TEST_F(OtherReadersTest, OiiotoolFindsThePartsAndAttributesOfMoments) {
  if (!program_works("oiiotool", "--help")) GTEST_SKIP() << "no oiiotool (Debian package openimageio-tools)";
  bake({"--ndf", "moments", "--wrap", "clamp"});
  const ProgramResult info = run_program({"oiiotool", "--info", "-v", "-a", path("map.ndf.exr")});
  ASSERT_EQ(info.exit_code, 0) << info.err;
  for (const char* line : {"3 subimages: 64x64 [h,h,h,h,h,h], 64x64 [h,h,h], 64x64 [h,h,h]",
                           "channel list: b0_h, b1_dhds, b2_dhdt, b3_dhds2, b4_dhdt2, b5_dh2dsdt",
                           "channel list: normal.mean.X, normal.mean.Y, normal.mean.Z",
                           "channel list: colour.albedo.R, colour.albedo.G, colour.albedo.B"})
    EXPECT_EQ(count_of(line, info.out), 1) << line << " is not in\n" << info.out;
  for (const char* attribute :
       {"multum:representation: \"moments\"", "multum:formatVersion: 1\n", "multum:encoding: \"half\"",
        "multum:slopeMax: 20\n", "multum:slopeDeviationMin: 0.044", "MIP-map levels: 64x64 32x32 16x16 8x8 4x4 2x2 1x1",
        "wrapmodes: \"clamp,clamp\"", "multum:firstLevel: 0\n", "multum:hasColours: 1\n"})
    EXPECT_EQ(count_of(attribute, info.out), 3) << attribute << " is not in each part of\n" << info.out;
  EXPECT_EQ(count_of("multum:lobeCount", info.out) + count_of("multum:kappaMax", info.out), 0);
  EXPECT_EQ(count_of("multum:measuredError: \"[[", info.out), 1);
}

// Reads a filter matrix A and a texture x. Writes the stored lists in their order, and the product A x.
constexpr char kMatrixDriver[] = R"(
import sys
matrix = read_filter_matrix(sys.argv[1])
with open(sys.argv[3], "wb") as out:
    for values in matrix[1:]:
        out.write(np.ascontiguousarray(values, dtype="<f4").tobytes())
    out.write(np.ascontiguousarray(picture_of(matrix, read_texels(sys.argv[2])), dtype="<f4").tobytes())
print(json.dumps(sorted(matrix[0])))
)";

// Returns a matrix with rows for 3 of the 3 x 2 pixels. The texture of 3 x 2 texels has 7 texels including its mip
// levels.
FilterMatrix three_pixels() {
  FilterMatrix matrix;
  matrix.width = 3;
  matrix.height = 2;
  matrix.texture_width = 3;
  matrix.texture_height = 2;
  matrix.pixels = {0, 2, 5};
  matrix.coverage = {0.25f, 1.0f, 0.5f};
  matrix.row_begin = {0, 1, 4, 6};
  matrix.columns = {6, 0, 1, 5, 2, 6};
  matrix.weights = {1.0f, 0.5f, 0.375f, 0.125f, 0.75f, 0.25f};
  return matrix;
}

TEST_F(OtherReadersTest, ThePythonOfTheFormatPageMultipliesMatrixAndTexture) {
  const std::string python = MULTUM_OIIO_PYTHON;
  if (python.empty()) GTEST_SKIP() << "no Python that imports OpenImageIO and numpy when this was configured";
  write_bytes(path("read.py"), python_of_format_page() + kMatrixDriver);
  InferredTexture texture{3, 2, {}, "{}"};
  for (int i = 0; i < 3 * 7; ++i) texture.texels.push_back(static_cast<float>(i));
  write_inferred_texture(texture, path("t.exr"));
  FilterMatrix empty = three_pixels();
  empty.pixels.clear(), empty.coverage.clear(), empty.columns.clear(), empty.weights.clear();
  empty.row_begin = {0};
  for (const FilterMatrix& matrix : {three_pixels(), empty}) {
    write_filter_matrix(matrix, path("a.filter"));
    const std::vector<std::string> command = {python, path("read.py"), path("a.filter"), path("t.exr"), path("values")};
    const ProgramResult read = run_program(command);
    ASSERT_EQ(read.exit_code, 0) << read.err;
    FloatStream values(read_bytes(path("values")));
    for (const std::uint32_t value : matrix.pixels) EXPECT_EQ(values.next(), static_cast<float>(value));
    for (const float value : matrix.coverage) EXPECT_EQ(values.next(), value);
    for (const std::uint32_t value : matrix.row_begin) EXPECT_EQ(values.next(), static_cast<float>(value));
    for (const std::uint32_t value : matrix.columns) EXPECT_EQ(values.next(), static_cast<float>(value));
    for (const float value : matrix.weights) EXPECT_EQ(values.next(), value);
    std::vector<float> picture(3 * 3 * 2);
    for (std::size_t r = 0; r < matrix.row_count(); ++r)
      for (std::uint32_t i = matrix.row_begin[r]; i < matrix.row_begin[r + 1]; ++i)
        for (std::size_t c = 0; c < 3; ++c)
          picture[3 * matrix.pixels[r] + c] +=
              matrix.coverage[r] * matrix.weights[i] * texture.texels[3 * matrix.columns[i] + c];
    for (const float value : picture) EXPECT_EQ(values.next(), value) << "these numbers are exact";
    EXPECT_EQ(values.left(), 0u);
    // The page's table names every key of the header.
    const std::string page = read_bytes(std::string(MULTUM_SOURCE_DIR) + "/docs/reference/inferred_textures.md");
    std::istringstream keys(read.out);
    for (std::string key; std::getline(keys, key, '"') && std::getline(keys, key, '"');)
      EXPECT_NE(page.find("`" + key + "`"), std::string::npos) << key;
    std::string bytes = read_bytes(path("a.filter"));
    bytes.back() = static_cast<char>(bytes.back() ^ 4);
    write_bytes(path("a.filter"), bytes);
    EXPECT_NE(run_program(command).err.find("damaged"), std::string::npos);
  }
}

}  // namespace
}  // namespace multum::testing
