// SPDX-License-Identifier: Apache-2.0
// Compares movmf_refine with the double reference on random texels and on hard ones. The results of the scalar and
// vector variants must be equal bit for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>
#include <utility>

#include <glm/geometric.hpp>

#include "host/formats/opencl/launch_shape.h"
#include "host/lab/reference/movmf_refine.h"
#include "kernels/shared/movmf_fit.h"
#include "kernels/shared/movmf_refine.h"
#include "kernels/shared/vmf_lobe.h"
#include "tests/fixtures/test_device.h"

namespace multum::testing {
namespace {

constexpr std::size_t kLanes = MULTUM_GROUP;

using reference::RefinedTexel;  // here with samples and lobes that are rounded to floats

double as_float(double value) { return static_cast<double>(static_cast<float>(value)); }
glm::dvec3 as_float(const glm::dvec3& v) { return {as_float(v.x), as_float(v.y), as_float(v.z)}; }

// Makes lobes near facets, similar to the result of a fit.
std::vector<reference::MeanLobe> random_lobes(const std::vector<glm::dvec3>& facets, std::mt19937& random) {
  const auto uniform = [&] { return static_cast<double>(random() >> 8) * 0x1p-24 * 2.0 - 1.0; };
  std::vector<reference::MeanLobe> lobes;
  double total = 0.0;
  for (const glm::dvec3& facet : facets) {
    const double x = uniform(), y = uniform(), length = 0.97 + 0.02 * uniform();
    lobes.push_back({as_float(length * glm::normalize(facet + 0.05 * glm::dvec3(x, y, 0.0))), 1.0 + 0.5 * uniform()});
    total += lobes.back().amplitude;
  }
  for (reference::MeanLobe& lobe : lobes) lobe.amplitude = as_float(lobe.amplitude / total);
  return lobes;
}

// Makes slightly rough facets, lobes near them, and up to four neighbours with similar facets.
RefinedTexel random_texel(std::size_t sample_count, std::size_t lobe_count, std::mt19937& random) {
  const auto uniform = [&] { return static_cast<double>(random() >> 8) * 0x1p-24 * 2.0 - 1.0; };
  std::vector<glm::dvec3> facets;
  for (std::size_t j = 0; j < lobe_count; ++j) facets.push_back(glm::normalize(glm::dvec3(uniform(), uniform(), 1.0)));
  RefinedTexel texel;
  for (std::size_t i = 0; i < sample_count; ++i) {
    const double x = uniform(), y = uniform(), z = uniform();
    texel.samples.push_back({as_float(glm::normalize(facets[random() % lobe_count] + 0.2 * glm::dvec3(x, y, z))),
                             as_float(1.0 + 0.5 * uniform())});
  }
  texel.lobes = random_lobes(facets, random);
  for (std::size_t beside = random() % 5; beside > 0; --beside) texel.beside.push_back(random_lobes(facets, random));
  return texel;
}

double weight_of(const RefinedTexel& texel) {
  double total = 0.0;
  for (const reference::Sample& sample : texel.samples) total += sample.weight;
  return total;
}

// Returns a position in a level at which a texel has this number of neighbours. The order is that of movmf_refine.cl:
// left, right, above, below. In a level that repeats, all four exist.
struct Place {
  int width, height, x, y;
  bool repeats;

  int number(int dx, int dy) const { return (y + dy + height) % height * width + (x + dx + width) % width; }
  bool is_there(int dx, int dy) const {
    return repeats || (x + dx >= 0 && x + dx < width && y + dy >= 0 && y + dy < height);
  }
};
Place place_of(std::size_t beside_count, bool repeats) {
  constexpr Place kPlaces[] = {{1, 1, 0, 0, false}, {2, 1, 0, 0, false}, {3, 1, 1, 0, false},
                               {3, 2, 1, 0, false}, {3, 3, 1, 1, false}, {3, 3, 0, 0, true}};
  return kPlaces[beside_count + (beside_count == 4 && repeats ? 1 : 0)];
}

// Runs the kernel on one texel in slot 3 of a group; the other slots are unused.
std::vector<MultumVmfLobe> run_kernel(const RefinedTexel& texel, int vector_width, bool repeats) {
  Device& device = test_device();
  const Place place = place_of(texel.beside.size(), repeats);
  const std::size_t count = texel.samples.size(), lobe_count = texel.lobes.size(), slot = 3;
  const auto level_size = static_cast<std::size_t>(place.width * place.height);
  const auto own = static_cast<std::size_t>(place.number(0, 0));
  std::vector<float> samples(count * 4 * kLanes);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t l = 0; l < kLanes; ++l) {
      const reference::Sample& s = texel.samples[i];
      const double values[4] = {s.normal.x, s.normal.y, s.normal.z, s.weight};
      for (std::size_t k = 0; k < 4; ++k) samples[(i * 4 + k) * kLanes + l] = static_cast<float>(values[k]);
    }
  const std::vector<int> counts = {static_cast<int>(count)};
  std::vector<int> list(kLanes, -1);
  list[slot] = static_cast<int>(own);
  std::vector<MultumVmfLobe> level(lobe_count * level_size);
  const auto put = [&](const std::vector<reference::MeanLobe>& lobes, std::size_t at) {
    for (std::size_t j = 0; j < lobe_count; ++j)
      level[j * level_size + at] = {static_cast<float>(lobes[j].r.x), static_cast<float>(lobes[j].r.y),
                                    static_cast<float>(lobes[j].r.z), static_cast<float>(lobes[j].amplitude)};
  };
  put(texel.lobes, own);
  std::size_t beside = 0;
  for (const auto& [dx, dy] : {std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1)})
    if (place.is_there(dx, dy)) put(texel.beside.at(beside++), static_cast<std::size_t>(place.number(dx, dy)));
  // Fills all values with poison. The values of texels that are not in the list must stay.
  std::vector<MultumVmfLobe> refined(lobe_count * level_size, MultumVmfLobe{7.0f, 7.0f, 7.0f, 7.0f});
  MultumMovmfFit fit = {};
  fit.map_width = fit.width = place.width;
  fit.map_height = fit.height = fit.window_rows = fit.map_window_rows = place.height;
  fit.periodic_x = fit.periodic_y = place.repeats ? 1 : 0;
  fit.slot_count = MULTUM_GROUP;
  fit.sample_capacity = static_cast<int>(count);
  fit.total_weight_inverse = static_cast<float>(1.0 / weight_of(texel));
  const DeviceBuffer sample_buffer = device.wrap_buffer(samples.data(), samples.size() * sizeof(float), "samples");
  const DeviceBuffer count_buffer = device.wrap_buffer(counts.data(), sizeof(int), "sample counts");
  const DeviceBuffer list_buffer = device.wrap_buffer(list.data(), list.size() * sizeof(int), "texels");
  const std::size_t level_bytes = level.size() * sizeof(MultumVmfLobe);
  DeviceBuffer level_buffer = device.make_buffer(level_bytes, "lobes");
  DeviceBuffer refined_buffer = device.make_buffer(level_bytes, "refined lobes");
  device.write(level_buffer, level.data(), level_bytes);
  device.write(refined_buffer, refined.data(), level_bytes);
  device.kernel("movmf_refine", "movmf_refine", {static_cast<int>(lobe_count), vector_width, true})
      .launch({kLanes / static_cast<std::size_t>(vector_width)}, sample_buffer, count_buffer, list_buffer, level_buffer,
              refined_buffer, fit);
  device.read(refined_buffer, refined.data(), level_bytes);
  std::vector<MultumVmfLobe> found;
  for (std::size_t j = 0; j < lobe_count; ++j)
    for (std::size_t at = 0; at < level_size; ++at) {
      const MultumVmfLobe& lobe = refined[j * level_size + at];
      if (at == own) found.push_back(lobe);
      else EXPECT_TRUE(lobe.mean_x == 7.0f && lobe.amplitude == 7.0f) << "texel " << at;
    }
  return found;
}

// Runs both variants, which give the same bytes.
std::vector<MultumVmfLobe> refined_by_kernel(const RefinedTexel& texel, bool repeats = false) {
  const std::vector<MultumVmfLobe> scalar = run_kernel(texel, 1, repeats), vector = run_kernel(texel, 16, repeats);
  EXPECT_EQ(0, std::memcmp(scalar.data(), vector.data(), scalar.size() * sizeof(MultumVmfLobe)));
  return scalar;
}

// Returns the largest |a - a'| and |a r - a' r'| of a texel's lobes.
double difference(const std::vector<MultumVmfLobe>& found, const std::vector<reference::MeanLobe>& expected) {
  double most = 0.0;
  for (std::size_t j = 0; j < found.size(); ++j) {
    const double a = static_cast<double>(found[j].amplitude);
    const glm::dvec3 r(found[j].mean_x, found[j].mean_y, found[j].mean_z);
    const double off =
        std::max(std::abs(a - expected[j].amplitude), glm::length(a * r - expected[j].amplitude * expected[j].r));
    most = std::isnan(off) ? HUGE_VAL : std::max(most, off);
  }
  return most;
}

// A step in single precision has two errors: about 1e-6 from sums of up to 300 samples, and 3e-5 of kappa from
// kappa_of_mean_length. These errors add up over the damped steps. Near the minimum of the energy, the kernel may
// accept a step that the reference rejects, or the other way round.
TEST(MovmfRefineTest, EqualsReference) {
  constexpr unsigned kSeed = 20271;
  std::mt19937 random(kSeed);
  SCOPED_TRACE(kSeed);
  for (const std::size_t lobe_count : {std::size_t{4}, std::size_t{6}})
    for (int i = 0; i < 10; ++i) {
      const RefinedTexel texel = random_texel(5 + random() % 300, lobe_count, random);
      const auto expected = reference::refine(texel, MULTUM_REFINE_STEPS);
      EXPECT_LT(difference(refined_by_kernel(texel, i % 2 == 1), expected), 5e-4)
          << lobe_count << " lobes, " << texel.beside.size() << " texels beside";
    }
}

// Refining lowers the error of highlights and hardly changes the mean normal of the samples. A texel never gets worse
// than the result of EM.
TEST(MovmfRefineTest, ComesNearerAndKeepsTheMeanNormal) {
  std::mt19937 random(31);
  int nearer = 0;
  for (int i = 0; i < 16; ++i) {
    const RefinedTexel texel = random_texel(64, 4, random);
    std::vector<reference::MeanLobe> refined;
    glm::dvec3 off(0.0);
    double amplitude = 0.0;
    for (const MultumVmfLobe& lobe : refined_by_kernel(texel)) {
      refined.push_back({{lobe.mean_x, lobe.mean_y, lobe.mean_z}, static_cast<double>(lobe.amplitude)});
      off += refined.back().amplitude * refined.back().r;
      amplitude += refined.back().amplitude;
    }
    for (const reference::Sample& sample : texel.samples) off -= sample.weight / weight_of(texel) * sample.normal;
    EXPECT_LE(reference::refined_energy(texel, refined), reference::refined_energy(texel, texel.lobes) + 1e-6);
    EXPECT_LE(reference::seen_error(texel, refined),
              1e-5 + static_cast<double>(MULTUM_REFINE_LOOK_SLACK) * reference::seen_error(texel, texel.lobes));
    nearer += reference::seen_error(texel, refined) < 0.95 * reference::seen_error(texel, texel.lobes) ? 1 : 0;
    EXPECT_LT(glm::length(off), 2e-2);
    EXPECT_NEAR(amplitude, 1.0, 1e-6);
    // From the refined lobes, no further step lowers the energy.
    const RefinedTexel again{texel.samples, refined, texel.beside};
    EXPECT_LE(reference::refined_energy(again, reference::refine(again, 3)),
              reference::refined_energy(again, refined) + 1e-6);
  }
  EXPECT_GE(nearer, 8);
}

// The reference's steps end in a minimum of the energy. Zero derivatives would not prove a minimum.
TEST(MovmfRefineTest, ReferenceIsWhereNoLobeMovesNearer) {
  std::mt19937 random(7);
  const RefinedTexel texel = random_texel(100, 3, random);
  const std::vector<reference::MeanLobe> refined = reference::refine(texel, 200);
  const double least = reference::refined_energy(texel, refined);
  for (std::size_t j = 0; j < refined.size(); ++j)
    for (int axis = 0; axis < 3; ++axis)
      for (const double change : {-2e-3, 2e-3}) {
        std::vector<reference::MeanLobe> moved = refined;
        moved[j].r[axis] += change;
        if (glm::length(moved[j].r) > 1.0) continue;
        EXPECT_GT(reference::refined_energy(texel, moved), least) << "lobe " << j << ", axis " << axis;
      }
}

// Tries equal normals, equal lobes, a lobe without weight or direction, a single normal, and normals on the equator.
TEST(MovmfRefineTest, HardCases) {
  const glm::dvec3 up(0.0, 0.0, 1.0), tilted = as_float(glm::normalize(glm::dvec3(0.6, 0.1, 0.8)));
  std::vector<RefinedTexel> texels = {
      {std::vector<reference::Sample>(64, {tilted, 1.0}), {{tilted, 0.5}, {tilted, 0.5}}, {}},
      {{{up, 1.0}, {tilted, 1.0}, {up, 2.0}}, {{0.9 * up, 0.5}, {0.9 * up, 0.5}}, {}},
      {{{up, 1.0}, {tilted, 1.0}}, {{0.9 * up, 1.0}, {0.5 * tilted, 0.0}}, {}},
      {{{{1.0, 0.0, 0.0}, 1.0}, {{-1.0, 0.0, 0.0}, 1.0}}, {{{0.0, 0.0, 0.0}, 0.5}, {{0.0, 0.0, 0.0}, 0.5}}, {}},
      {{{up, 1.0}}, {{up, 0.5}, {0.3 * tilted, 0.5}}, {}},
      {{{{0.0, 1.0, 0.0}, 1.0}, {{0.0, -1.0, 0.0}, 3.0}}, {{{0.0, 0.9, 0.0}, 0.25}, {{0.0, -0.9, 0.0}, 0.75}}, {}}};
  // Refines the same texels next to a flat texel and next to an opposite texel, so that the pooled lobes have no
  // direction.
  for (std::size_t i = 0, count = texels.size(); i < count; ++i) {
    texels.push_back(texels[i]);
    texels.back().beside = {{{up, 1.0}, {up, 0.0}}, texels[i].lobes};
    for (reference::MeanLobe& lobe : texels.back().beside[1]) lobe.r = -lobe.r;
  }
  for (std::size_t i = 0; i < texels.size(); ++i) {
    RefinedTexel texel = texels[i];
    for (reference::MeanLobe& lobe : texel.lobes) lobe.r = as_float(lobe.r);
    for (std::vector<reference::MeanLobe>& beside : texel.beside)
      for (reference::MeanLobe& lobe : beside) lobe.r = as_float(lobe.r);
    const std::vector<MultumVmfLobe> found = refined_by_kernel(texel);
    std::vector<reference::MeanLobe> refined;
    for (const MultumVmfLobe& lobe : found)
      refined.push_back({{lobe.mean_x, lobe.mean_y, lobe.mean_z}, static_cast<double>(lobe.amplitude)});
    EXPECT_LE(reference::refined_energy(texel, refined), reference::refined_energy(texel, texel.lobes) + 2e-6) << i;
    // If lobes are equal, rounding decides how they separate.
    if (texel.lobes[0].r != texel.lobes[1].r) {
      EXPECT_LT(difference(found, reference::refine(texel, MULTUM_REFINE_STEPS)), 2e-3) << i;
    }
    for (const MultumVmfLobe& lobe : found) {
      EXPECT_GE(lobe.amplitude, 0.0f) << i;
      EXPECT_LE(glm::length(glm::dvec3(lobe.mean_x, lobe.mean_y, lobe.mean_z)), 1.0 + 1e-6) << i;
    }
  }
}

}  // namespace
}  // namespace multum::testing
