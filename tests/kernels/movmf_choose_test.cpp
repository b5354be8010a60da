// SPDX-License-Identifier: Apache-2.0
// Compares movmf_choose with the double reference, which tries every assignment of normals to lobes, on random texels
// with random neighbours. The results of the scalar and the vector variant must be equal bit for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include <glm/geometric.hpp>

#include "host/formats/opencl/launch_shape.h"
#include "host/lab/reference/movmf_choose.h"
#include "host/lab/reference/planar_em.h"
#include "kernels/shared/movmf_choose.h"
#include "kernels/shared/movmf_fit.h"
#include "kernels/shared/vmf_lobe.h"
#include "tests/fixtures/test_device.h"

namespace multum::testing {
namespace {

using Lobes = std::vector<MultumVmfLobe>;

struct ChoiceCase {
  int width, height, lobes;
  bool planar = false, shortened = false, periodic = false;
  int order = MULTUM_ORDER_COLOUR;
};

void PrintTo(const ChoiceCase& c, std::ostream* out) {
  *out << c.width << "x" << c.height << ", " << c.lobes << " lobes" << (c.planar ? ", Gaussians" : "")
       << (c.shortened ? ", shortened" : "") << (c.periodic ? ", repeating" : "")
       << (c.order == MULTUM_ORDER_AGAIN ? ", again" : "");
}

// Holds a level in which the texels of colour (1, 0) are fitted next. Some texels of other colours are already fitted.
struct ChoiceLevel {
  ChoiceCase which;
  int parent_width, parent_height;
  std::vector<float> normals[3], values[3];  // [2 height][2 width]
  Lobes parent, level;                       // [lobe][texel]
};

std::size_t texel_at(int x, int y, int width) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
}

Lobes random_lobes(int lobe_count, int texels, bool planar, std::mt19937& random) {
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  Lobes lobes(static_cast<std::size_t>(lobe_count * texels));
  for (std::size_t i = 0; i < lobes.size(); ++i) {
    // Lobe j has nearly the same direction in every texel, as in aligned levels. One lobe in five is dead.
    const auto turn = 6.28f * static_cast<float>(i / static_cast<std::size_t>(texels)) / static_cast<float>(lobe_count);
    const glm::vec3 near(std::cos(turn), std::sin(turn), 1.0f);
    const glm::vec3 r = glm::normalize(near + 0.8f * glm::vec3(uniform() - 0.5f, uniform() - 0.5f, 0.0f));
    const float length = 0.9f + 0.1f * uniform(), spread = 0.1f * uniform();
    const float amplitude = random() % 5 == 0 ? 0.0f : uniform();
    if (planar) lobes[i] = {r.x, r.y, spread, amplitude};
    else lobes[i] = {r.x * length, r.y * length, r.z * length, amplitude};
  }
  return lobes;
}

ChoiceLevel random_level(const ChoiceCase& c, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&] { return static_cast<double>(random() >> 8) * 0x1p-24; };
  ChoiceLevel level{c, std::max(1, c.width / 2), std::max(1, c.height / 2), {}, {}, {}, {}};
  glm::dvec3 last(0.0, 0.0, 1.0);
  for (int i = 0; i < 4 * c.width * c.height; ++i) {
    // One normal in four equals the previous normal, which causes ties.
    const double x = uniform(), y = uniform();
    if (random() % 4 != 0) last = glm::normalize(glm::dvec3(2.0 * x - 1.0, 2.0 * y - 1.0, 0.7));
    const glm::dvec3 n = c.shortened ? last * (0.6 + 0.4 * uniform()) : last;
    for (int k = 0; k < 3; ++k) {
      level.normals[k].push_back(static_cast<float>(n[k]));
      level.values[k].push_back(static_cast<float>(uniform()));
    }
  }
  level.parent = random_lobes(c.lobes, level.parent_width * level.parent_height, c.planar, random);
  level.level = random_lobes(c.lobes, c.width * c.height, c.planar, random);
  return level;
}

bool is_fitted(int x, int y) { return x % 2 == 1 && y % 2 == 0; }

std::vector<int> fitted_texels(const ChoiceCase& c) {
  std::vector<int> texels;
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x)
      if (is_fitted(x, y)) texels.push_back(static_cast<int>(texel_at(x, y, c.width)));
  return texels;
}

struct Chosen {
  Lobes level;
  std::vector<int> ways;        // the chosen assignment of each fitted texel
  std::vector<float> features;  // [lobe][texel][3]
};

Chosen choose_on_device(const ChoiceLevel& level, int vector_width) {
  Device& device = test_device();
  const ChoiceCase& c = level.which;
  std::vector<int> list = fitted_texels(c);
  const std::size_t fitted = list.size();
  list.resize((fitted + MULTUM_GROUP - 1) / MULTUM_GROUP * MULTUM_GROUP, -1);
  MultumMovmfFit fit = {};
  fit.map_width = 2 * c.width;
  fit.map_height = fit.map_window_rows = 2 * c.height;
  fit.width = c.width;
  fit.height = fit.window_rows = c.height;
  fit.parent_width = level.parent_width;
  fit.parent_height = fit.parent_window_rows = level.parent_height;
  fit.slot_count = static_cast<int>(list.size());
  fit.order = c.order;
  fit.periodic_x = fit.periodic_y = c.periodic ? 1 : 0;
  fit.shortened = c.shortened ? 1 : 0;
  fit.kappa_cap = 500.0f;
  fit.alignment = 1.4f;
  const auto wrap = [&](const auto& values, const char* what) {
    return device.wrap_buffer(values.data(), values.size() * sizeof(values[0]), what);
  };
  const DeviceBuffer x = wrap(level.normals[0], "x"), y = wrap(level.normals[1], "y"), z = wrap(level.normals[2], "z"),
                     red = wrap(level.values[0], "r"), green = wrap(level.values[1], "g"),
                     blue = wrap(level.values[2], "b"), parent = wrap(level.parent, "parent"),
                     texels = wrap(list, "texels");
  Chosen out{level.level, std::vector<int>(list.size(), -1), std::vector<float>(3 * level.level.size(), -7.0f)};
  DeviceBuffer lobes = device.make_buffer(out.level.size() * sizeof(MultumVmfLobe), "lobes");
  DeviceBuffer ways = device.make_buffer(list.size() * sizeof(int), "ways");
  DeviceBuffer features = device.make_buffer(out.features.size() * sizeof(float), "features");
  device.write(lobes, out.level.data(), lobes.byte_count());
  device.write(features, out.features.data(), features.byte_count());
  const KernelVariant variant{c.lobes, vector_width, false, c.planar};
  device.kernel("movmf_choose", "movmf_choose", variant)
      .launch({list.size() / static_cast<std::size_t>(vector_width)}, x, y, z, parent, lobes, texels, ways, fit);
  device.kernel("movmf_choose", "movmf_feature_chosen", variant)
      .launch({list.size()}, red, green, blue, texels, ways, features, fit, 0);
  device.read(lobes, out.level.data(), lobes.byte_count());
  device.read(ways, out.ways.data(), ways.byte_count());
  device.read(features, out.features.data(), features.byte_count());
  out.ways.resize(fitted);
  return out;
}

reference::SampleSums sums_of(const MultumVmfLobe& lobe, bool planar) {
  return reference::sums_of_lobe({lobe.mean_x, lobe.mean_y, lobe.mean_z}, static_cast<double>(lobe.amplitude), planar);
}

// Returns position i within `size`. The position is wrapped if the level repeats, and clamped otherwise.
int inside(int i, int size, bool periodic) { return periodic ? (i + size) % size : std::clamp(i, 0, size - 1); }

// Returns the sums of the neighbours of texel (x, y).
std::vector<reference::SampleSums> around_texel(const ChoiceLevel& level, int x, int y) {
  const ChoiceCase& c = level.which;
  const auto count = static_cast<std::size_t>(c.lobes);
  std::vector<reference::SampleSums> parent(count);
  const int px = std::min(x / 2, level.parent_width - 1), py = std::min(y / 2, level.parent_height - 1);
  for (int i = 0; i < 4; ++i) {
    const int column = inside(px + (i % 2) * (x % 2 == 0 ? -1 : 1), level.parent_width, c.periodic);
    const int row = inside(py + (i / 2) * (y % 2 == 0 ? -1 : 1), level.parent_height, c.periodic);
    const double share = (i % 2 == 0 ? 0.75 : 0.25) * (i / 2 == 0 ? 0.75 : 0.25);
    for (std::size_t j = 0; j < count; ++j) {
      const std::size_t plane = level.parent.size() / count * j;
      MultumVmfLobe lobe = level.parent[plane + texel_at(column, row, level.parent_width)];
      lobe.amplitude = std::max(lobe.amplitude, MULTUM_CHOICE_AMPLITUDE_MIN);
      parent[j] = parent[j] + share * sums_of(lobe, c.planar);
    }
  }
  std::vector<std::vector<reference::SampleSums>> neighbours;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      if (!c.periodic && (x + dx < 0 || x + dx >= c.width || y + dy < 0 || y + dy >= c.height)) continue;
      const int nx = inside(x + dx, c.width, true), ny = inside(y + dy, c.height, true);
      // Texels of colours (0, 0) and (1, 1) are fitted before (1, 0), and texels of (0, 1) are fitted after it.
      const bool done = nx % 2 == ny % 2 || (c.order == MULTUM_ORDER_AGAIN && !is_fitted(nx, ny));
      if (!done) continue;
      neighbours.emplace_back();
      for (std::size_t j = 0; j < count; ++j)
        neighbours.back().push_back(
            sums_of(level.level[level.level.size() / count * j + texel_at(nx, ny, c.width)], c.planar));
    }
  return reference::sums_around(parent, neighbours);
}

std::vector<glm::dvec3> covered(const ChoiceLevel& level, const std::vector<float>* planes, int x, int y) {
  std::vector<glm::dvec3> found;
  for (int i = 0; i < 4; ++i) {
    const std::size_t at = texel_at(2 * x + i % 2, 2 * y + i / 2, 2 * level.which.width);
    found.emplace_back(planes[0][at], planes[1][at], planes[2][at]);
  }
  return found;
}

class MovmfChooseTest : public ::testing::TestWithParam<ChoiceCase> {};

// Rounding changes the cost of an assignment by about 1e-6, compared with the reference. Hence either of two
// assignments may win if their costs differ by less. Whichever assignment wins, the lobes are the means of their
// normals.
TEST_P(MovmfChooseTest, TakesTheLeastOfAllWays) {
  const ChoiceCase c = GetParam();
  const ChoiceLevel level = random_level(c, 20061u + static_cast<unsigned>(c.lobes));
  const Chosen chosen = choose_on_device(level, 1), vector = choose_on_device(level, 16);
  EXPECT_EQ(chosen.ways, vector.ways);
  EXPECT_EQ(0, std::memcmp(chosen.level.data(), vector.level.data(), chosen.level.size() * sizeof(MultumVmfLobe)));
  EXPECT_EQ(chosen.features, vector.features);
  const std::vector<int> texels = fitted_texels(c);
  const auto count = static_cast<std::size_t>(c.lobes);
  const std::size_t level_size = level.level.size() / count;
  std::size_t shared = 0;
  for (std::size_t t = 0; t < texels.size(); ++t) {
    const int x = texels[t] % c.width, y = texels[t] / c.width;
    SCOPED_TRACE(texels[t]);
    std::vector<reference::SampleSums> samples;
    for (const glm::dvec3& n : covered(level, level.normals, x, y))
      samples.push_back(reference::sums_of_sample(c.planar ? reference::planar_sample(n, c.shortened) : n, c.planar));
    std::vector<int> way;
    for (int i = 0; i < 4; ++i) way.push_back((chosen.ways[t] >> (4 * i)) & 15);
    ASSERT_LT(*std::max_element(way.begin(), way.end()), c.lobes);
    const auto around = around_texel(level, x, y);
    const std::vector<int> best = reference::least_choice(samples, around, {});
    const double least = reference::cost_of_choice(samples, best, around, {});
    EXPECT_LT(reference::cost_of_choice(samples, way, around, {}), least * (1.0 + 3e-6));
    const std::vector<glm::dvec3> values = covered(level, level.values, x, y);
    for (std::size_t j = 0; j < count; ++j) {
      reference::SampleSums own;
      glm::dvec3 value(0.0);
      for (std::size_t i = 0; i < 4; ++i)
        if (way[i] == static_cast<int>(j)) {
          own = own + samples[i];
          value += 0.25 * values[i];
        }
      const std::size_t place = j * level_size + static_cast<std::size_t>(texels[t]);
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(chosen.features[3 * place + static_cast<std::size_t>(k)], value[k], 1e-6);
      const MultumVmfLobe& lobe = chosen.level[place];
      EXPECT_EQ(static_cast<double>(lobe.amplitude), own.weight / 4.0);
      if (own.weight == 0.0) continue;
      if (own.weight > 1.0) ++shared;
      const reference::SampleSums found = sums_of(lobe, c.planar);
      EXPECT_LT(glm::length(4.0 * found.sum - own.sum), 2e-6);
      EXPECT_NEAR(4.0 * found.square, own.square, 4e-6);
    }
  }
  EXPECT_GE(shared, texels.size() / 8) << "otherwise the test tries only one normal per lobe";
}

TEST_P(MovmfChooseTest, LeavesOtherTexelsAlone) {
  const ChoiceCase c = GetParam();
  const ChoiceLevel level = random_level(c, 77);
  const Chosen chosen = choose_on_device(level, 16);
  const std::size_t level_size = level.level.size() / static_cast<std::size_t>(c.lobes);
  for (std::size_t i = 0; i < level.level.size(); ++i) {
    const int texel = static_cast<int>(i % level_size);
    if (is_fitted(texel % c.width, texel / c.width)) continue;
    EXPECT_EQ(0, std::memcmp(&chosen.level[i], &level.level[i], sizeof(MultumVmfLobe))) << i;
    EXPECT_EQ(chosen.features[3 * i], -7.0f) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Levels, MovmfChooseTest,
                         ::testing::Values(ChoiceCase{12, 8, 4}, ChoiceCase{12, 8, 4, false, false, true},
                                           ChoiceCase{12, 8, 4, false, false, true, MULTUM_ORDER_AGAIN},
                                           ChoiceCase{13, 9, 4},
                                           ChoiceCase{13, 9, 3, false, false, true, MULTUM_ORDER_AGAIN},
                                           ChoiceCase{2, 1, 4}, ChoiceCase{12, 8, 1}, ChoiceCase{12, 8, 2},
                                           ChoiceCase{8, 6, 6}, ChoiceCase{6, 4, 8}, ChoiceCase{12, 8, 4, false, true},
                                           ChoiceCase{12, 8, 4, true},
                                           ChoiceCase{12, 8, 3, true, true, true, MULTUM_ORDER_AGAIN}));

}  // namespace
}  // namespace multum::testing
