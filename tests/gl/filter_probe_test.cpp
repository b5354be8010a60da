// SPDX-License-Identifier: Apache-2.0
// Tests that the filter matrix A describes what OpenGL draws. A times a texture must equal the picture of that texture.
// Slower ways of measuring must find the same matrix.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "runtime_gl/probe/texel_classes.h"
#include "tests/gl/probe_references.h"
#include "tests/gl/probe_scene.h"
#include "tests/gl/test_context.h"

namespace multum::gl {
namespace {

struct Sampling {
  int texture_width, texture_height;
  WrapMode wrap_s, wrap_t;
  ProbeSampler sampler;
  int supersampling;
};

// Holds a context and the waves (object 0), which a board partly hides.
class Waves {
 public:
  explicit Waves(float repeats)
      : context_(make_test_context(test_backend())),
        waves_(context_->functions(), wave_mesh(repeats)),
        board_(context_->functions(), board_mesh()) {}

  const HeadlessContext& context() const { return *context_; }
  ProbeCase make_case(const Sampling& sampling, int width, int height) const {
    TextureMapping mapping;
    mapping.width = sampling.texture_width;
    mapping.height = sampling.texture_height;
    mapping.wrap_s = sampling.wrap_s;
    mapping.wrap_t = sampling.wrap_t;
    const glm::mat4 camera = probe_camera(width, height);
    return {&context_->functions(), width, height, {{&waves_, camera}, {&board_, camera}}, 0, mapping,
            sampling.sampler};
  }

 private:
  std::unique_ptr<HeadlessContext> context_;
  Mesh waves_, board_;
};

FilterMatrix probe(const ProbeCase& one, int supersampling, int threads = 1) {
  const FilterProbe filter_probe(*one.gl, one.width, one.height, supersampling);
  return filter_probe.probe(one.objects, one.object, one.mapping, one.sampler, threads);
}

class FilterProbeTest : public testing::TestWithParam<Sampling> {};

TEST_P(FilterProbeTest, TimesATextureIsThePictureOfIt) {
  const Sampling& sampling = GetParam();
  const Waves waves(sampling.wrap_s == WrapMode::kPeriodic ? 2.0f : 1.0f);
  const ProbeCase one = waves.make_case(sampling, 160, 120);
  const FilterMatrix matrix = probe(one, sampling.supersampling);
  const std::vector<float> texels = random_texels(matrix.layout().texel_count, 99991);
  // Only the waves are red; the board is black.
  const FloatImage picture = draw_texels(one, sampling.supersampling, texels);
  double worst = 0.0;
  for (std::size_t r = 0; r < matrix.row_count(); ++r) {
    double sum = 0.0;
    for (std::uint32_t i = matrix.row_begin[r]; i < matrix.row_begin[r + 1]; ++i)
      sum += static_cast<double>(matrix.weights[i]) * static_cast<double>(texels[4u * matrix.columns[i]]);
    const double drawn =
        static_cast<double>(picture.rgba[4u * matrix.pixels[r]]) / static_cast<double>(matrix.coverage[r]);
    worst = std::max(worst, std::abs(sum - drawn));
  }
  EXPECT_LE(worst, 1e-5);
  EXPECT_GT(matrix.row_count(), 5000u);
  EXPECT_LE(matrix.rows_rejected, matrix.row_count() / 1000);
  EXPECT_TRUE(std::is_sorted(matrix.pixels.begin(), matrix.pixels.end()));
  RecordProperty("worst", std::to_string(worst));
}

constexpr WrapMode kClamp = WrapMode::kClamp, kPeriodic = WrapMode::kPeriodic;

INSTANTIATE_TEST_SUITE_P(
    Samplings, FilterProbeTest,
    testing::Values(Sampling{256, 256, kClamp, kClamp, {}, 1}, Sampling{256, 128, kPeriodic, kPeriodic, {}, 1},
                    Sampling{203, 77, kClamp, kClamp, {}, 1}, Sampling{203, 77, kPeriodic, kPeriodic, {}, 1},
                    Sampling{64, 101, kPeriodic, kClamp, {}, 2}, Sampling{128, 128, kClamp, kClamp, {1.0f, false}, 1},
                    Sampling{256, 256, kClamp, kClamp, {}, 4}, Sampling{128, 128, kClamp, kClamp, {2.0f, true}, 1},
                    Sampling{128, 128, kPeriodic, kPeriodic, {4.0f, true}, 1},
                    Sampling{128, 128, kClamp, kClamp, {16.0f, true}, 1},
                    Sampling{101, 77, kClamp, kClamp, {4.0f, true}, 1},
                    Sampling{101, 77, kPeriodic, kClamp, {8.0f, true}, 2}),
    [](const auto& test) {
      const Sampling& s = test.param;
      return std::to_string(s.texture_width) + "x" + std::to_string(s.texture_height) + "_" + wrap_mode_name(s.wrap_s) +
             "_" + wrap_mode_name(s.wrap_t) + "_anisotropy" + std::to_string(static_cast<int>(s.sampler.anisotropy)) +
             (s.sampler.has_mips ? "" : "_bilinear") + "_ss" + std::to_string(s.supersampling);
    });

TEST(FilterProbe, EqualsProbingTexelByTexel) {
  const Waves waves(1.0f);
  for (const ProbeSampler sampler : {ProbeSampler{1.0f, true}, ProbeSampler{4.0f, true}, ProbeSampler{1.0f, false}}) {
    const ProbeCase one = waves.make_case({16, 16, kClamp, kClamp, sampler, 1}, 64, 48);
    EXPECT_LE(largest_difference(rows_of(probe(one, 1)), probe_texel_by_texel(one)), 1e-5);
  }
  const ProbeCase odd = waves.make_case({13, 9, kPeriodic, kPeriodic, {}, 1}, 64, 48);
  EXPECT_LE(largest_difference(rows_of(probe(odd, 1)), probe_texel_by_texel(odd)), 1e-5);
}

TEST(FilterProbe, EqualsThePapersRenderings) {
  for (const WrapMode wrap : {kClamp, kPeriodic}) {
    const Waves waves(wrap == kPeriodic ? 2.0f : 1.0f);
    const ProbeCase one = waves.make_case({128, 128, wrap, wrap, {}, 1}, 96, 72);
    EXPECT_LE(largest_difference(rows_of(probe(one, 1)), probe_in_parallel(one)), 1e-5) << wrap_mode_name(wrap);
  }
}

// In Mesa 25.0.7, the level of detail that textureQueryLod() returns differs by up to 0.042 from the one that texture()
// uses, so the weights of the two levels differ as much. The probe measures what texture() does.
TEST(FilterProbe, AgreesWithTextureQueryLod) {
  for (const WrapMode wrap : {kClamp, kPeriodic}) {
    const Waves waves(wrap == kPeriodic ? 2.0f : 1.0f);
    const ProbeCase one = waves.make_case({150, 128, wrap, wrap, {}, 1}, 160, 120);
    // The coordinate is read back in single precision, so its error is 1e-7 times 150 texels.
    const bool is_coarse = waves.context().description().find("Mesa 25.") != std::string::npos;
    EXPECT_LE(largest_difference(rows_of(probe(one, 1)), rows_by_query_lod(one)),
              filter_tolerance(waves.context(), is_coarse ? 0.05 : 1e-4, 1e-2))
        << wrap_mode_name(wrap);
  }
}

TEST(FilterProbe, ThreadsChangeNothing) {
  const Waves waves(1.0f);
  const ProbeCase one = waves.make_case({100, 60, kClamp, kClamp, {}, 1}, 96, 72);
  const FilterMatrix a = probe(one, 2, 1), b = probe(one, 2, 3);
  EXPECT_EQ(a.pixels, b.pixels);
  EXPECT_EQ(a.columns, b.columns);
  EXPECT_EQ(a.weights, b.weights);
}

TEST(FilterProbe, AnObjectOutOfSightHasNoRows) {
  const Waves waves(1.0f);
  ProbeCase one = waves.make_case({32, 32, kClamp, kClamp, {}, 1}, 64, 48);
  one.objects[0].object_to_clip = glm::translate(one.objects[0].object_to_clip, glm::vec3(0.0f, 500.0f, 0.0f));
  const FilterMatrix matrix = probe(one, 1);
  EXPECT_EQ(matrix.row_count(), 0u);
  EXPECT_EQ(matrix.row_begin, std::vector<std::uint32_t>{0});
}

// Any `span` neighbouring texels have different classes, even across the seam.
TEST(TexelBlocks, NeighboursDiffer) {
  for (int span = 2; span <= 20; ++span)
    for (int count = 1; count <= 130; ++count) {
      const TexelBlocks blocks(count, span);
      for (int i = 0; i < count; ++i) {
        ASSERT_GE(blocks.class_of(i), 0);
        ASSERT_LT(blocks.class_of(i), blocks.class_count()) << count << " span " << span << " at " << i;
        for (int k = 1; k < std::min(span, count); ++k)
          ASSERT_NE(blocks.class_of(i), blocks.class_of((i + k) % count)) << count << " span " << span << " at " << i;
      }
      ASSERT_LE(blocks.class_count(), std::max(2 * span - 1, std::min(count, 2 * span - 1)));
    }
}

}  // namespace
}  // namespace multum::gl
