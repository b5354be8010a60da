// SPDX-License-Identifier: Apache-2.0
// Tests that the vector variant of movmf_shade gives the same values as the scalar variant, bit for bit, for all of its
// formulas: half vectors with and without a light, sums of vMFs, Lambert, roughness in the lobes, and Gaussians.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <random>
#include <vector>

#include "host/bakes/accuracy/highlight.h"
#include "host/formats/opencl/launch_shape.h"
#include "tests/fixtures/test_device.h"

namespace multum::testing {
namespace {

constexpr int kLobes = 3;

class MovmfShadeTest : public ::testing::TestWithParam<bool> {
 protected:
  glm::vec3 direction() {
    return glm::normalize(glm::vec3(normal_(random_), normal_(random_), std::abs(normal_(random_)) + 0.01f));
  }
  // Returns lobes of many widths, among them empty lobes, lobes of a single direction, and lobes without a direction.
  std::vector<glm::vec4> lobes(int count) {
    std::vector<glm::vec4> made;
    for (int i = 0; i < count * kLobes; ++i) {
      const float amplitude = i % 11 == 0 ? 0.0f : uniform_(random_);
      const float length = i % 7 == 0 ? 1.0f : i % 7 == 1 ? 0.0f : std::sqrt(uniform_(random_));
      if (!GetParam()) {
        made.emplace_back(amplitude * length * direction(), amplitude);
        continue;
      }
      const glm::vec3 mu = direction();
      const float spread = 0.3f * uniform_(random_);
      made.emplace_back(amplitude * mu.x, amplitude * mu.y, amplitude * (spread + mu.x * mu.x + mu.y * mu.y),
                        amplitude);
    }
    return made;
  }
  std::vector<float> shade(const std::vector<glm::vec4>& lobes, bool has_lights, float mean_cosine, int width) {
    Device& device = test_device();
    std::vector<glm::vec4> half_vectors, lights;
    for (std::size_t i = 0; i < 5; ++i)
      half_vectors.emplace_back(directions_[i], has_lights ? 1.0f + static_cast<float>(i % 2) : 0.0f);
    for (std::size_t i = 5; i < 7; ++i) lights.emplace_back(directions_[i], mean_cosine);
    const std::vector<MultumHighlight> highlights = {shaded_highlight(20.0), shaded_highlight(500.0), terms_};
    const int samples = static_cast<int>(lobes.size()) / kLobes;
    std::vector<float> values(static_cast<std::size_t>(samples) * (3 * 5 + 2), NAN);
    const auto wrapped = [&](const auto& all) {
      return device.wrap_buffer(all.data(), all.size() * sizeof(all[0]), "arguments");
    };
    const DeviceBuffer lobe_buffer = wrapped(lobes), halves = wrapped(half_vectors), light_buffer = wrapped(lights),
                       highlight_buffer = wrapped(highlights);
    DeviceBuffer out = device.make_buffer(values.size() * sizeof(float), "values");
    device.write(out, values.data(), out.byte_count());
    device.kernel("movmf_shade", "movmf_shade", {kLobes, width, false, GetParam()})
        .launch({static_cast<std::size_t>((samples + width - 1) / width)}, lobe_buffer, halves, light_buffer,
                highlight_buffer, out, samples, 5, 2, 3);
    device.read(out, values.data(), out.byte_count());
    return values;
  }

 private:
  static MultumHighlight make_terms() {
    MultumHighlight terms = shaded_highlight(50.0);
    terms.term_count = 2;
    terms.weights[0] = 1.3f;
    terms.weights[1] = -0.3f;
    terms.spreads[0] = 0.02f;
    terms.spreads[1] = 0.2f;
    return terms;
  }
  std::mt19937 random_{4};
  std::normal_distribution<float> normal_;
  std::uniform_real_distribution<float> uniform_;
  const MultumHighlight terms_ = make_terms();
  const std::vector<glm::vec3> directions_ = {direction(), direction(), direction(), direction(),
                                              direction(), direction(), direction()};
};

TEST_P(MovmfShadeTest, VariantsGiveTheSameBits) {
  const int width = test_device().shape().vector_width;
  if (width == 1) GTEST_SKIP() << "this device has no vector variant";
  for (const int samples : {1, 16, 37})
    for (const bool has_lights : {false, true})
      for (const float mean_cosine : {0.0f, 0.8f}) {
        SCOPED_TRACE(::testing::Message() << samples << " samples, lights " << has_lights << ", " << mean_cosine);
        const std::vector<glm::vec4> all = lobes(samples);
        const std::vector<float> scalar = shade(all, has_lights, mean_cosine, 1),
                                 vector = shade(all, has_lights, mean_cosine, width);
        for (std::size_t i = 0; i < scalar.size(); ++i) EXPECT_EQ(scalar[i], vector[i]) << "value " << i;
      }
}

INSTANTIATE_TEST_SUITE_P(Families, MovmfShadeTest, ::testing::Values(false, true),
                         [](const ::testing::TestParamInfo<bool>& is_planar) {
                           return is_planar.param ? "Gaussians" : "Vmf";
                         });

}  // namespace
}  // namespace multum::testing
