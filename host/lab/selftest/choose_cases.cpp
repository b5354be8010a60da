// SPDX-License-Identifier: Apache-2.0
// Tests the assignment of four normals to lobes (kernels/movmf_choose.cl) with equal lobes and with lobes that get no
// normal.
#include <fmt/format.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "host/formats/opencl/launch_shape.h"
#include "host/lab/selftest/case_lists.h"
#include "host/lab/selftest/em_launch.h"
#include "kernels/shared/movmf_fit.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {
namespace {

// Describes a row of texels. Each texel covers 4 normals, and all parents have the same lobes.
struct ChosenRow {
  std::vector<glm::dvec3> normals;  // [texel][4]
  std::vector<MultumVmfLobe> lobes;
  bool planar = false;
};

constexpr std::size_t kChosenParents = kGroup, kChosenWidth = 2 * kGroup, kChosenMapWidth = 2 * kChosenWidth;

// Returns lobes as [lobe][texel]. If `features` is given, the normals are also treated as features. Their mean in each
// lobe (the sum, divided by the amplitude) is then stored in `features`[lobe][texel].
std::vector<MultumVmfLobe> choose_row(Device& device, const ChosenRow& row, int vector_width,
                                      std::vector<glm::dvec3>* features = nullptr) {
  MultumMovmfFit fit = {};
  fit.map_width = static_cast<int>(kChosenMapWidth);
  fit.map_height = fit.map_window_rows = 2;
  fit.width = static_cast<int>(kChosenWidth);
  fit.slot_count = MULTUM_GROUP;
  fit.height = fit.window_rows = fit.parent_height = fit.parent_window_rows = 1;
  fit.parent_width = static_cast<int>(kChosenParents);
  fit.kappa_cap = 500.0f;
  fit.alignment = 1.4f;
  std::vector<float> planes[3];
  for (std::vector<float>& plane : planes) plane.resize(2 * kChosenMapWidth);
  for (std::size_t i = 0; i < row.normals.size(); ++i)
    for (int k = 0; k < 3; ++k)
      planes[k][i % 4 / 2 * kChosenMapWidth + i / 4 * 4 + i % 2] = static_cast<float>(row.normals[i][k]);
  std::vector<MultumVmfLobe> parent;
  for (const MultumVmfLobe& lobe : row.lobes) parent.insert(parent.end(), kChosenParents, lobe);
  std::vector<MultumVmfLobe> level(row.lobes.size() * kChosenWidth, MultumVmfLobe{NAN, NAN, NAN, NAN});
  std::vector<int> list;
  for (std::size_t i = 0; i < kGroup; ++i) list.push_back(static_cast<int>(2 * i));
  const std::size_t plane_bytes = planes[0].size() * sizeof(float);
  const DeviceBuffer x = device.wrap_buffer(planes[0].data(), plane_bytes, "x"),
                     y = device.wrap_buffer(planes[1].data(), plane_bytes, "y"),
                     z = device.wrap_buffer(planes[2].data(), plane_bytes, "z"),
                     parents = device.wrap_buffer(parent.data(), parent.size() * sizeof(MultumVmfLobe), "parents"),
                     texels = device.wrap_buffer(list.data(), list.size() * sizeof(int), "texels");
  DeviceBuffer lobes = device.make_buffer(level.size() * sizeof(MultumVmfLobe), "lobes");
  DeviceBuffer ways = device.make_buffer(kGroup * sizeof(int), "ways");
  device.write(lobes, level.data(), lobes.byte_count());
  device.kernel("movmf_choose", "movmf_choose", {static_cast<int>(row.lobes.size()), vector_width, false, row.planar})
      .launch({kGroup / static_cast<std::size_t>(vector_width)}, x, y, z, parents, lobes, texels, ways, fit);
  device.read(lobes, level.data(), lobes.byte_count());
  if (features != nullptr) {
    std::vector<float> values(level.size() * 3, NAN);
    DeviceBuffer sums = device.make_buffer(values.size() * sizeof(float), "features");
    device.write(sums, values.data(), sums.byte_count());
    device.kernel("movmf_choose", "movmf_feature_chosen", {static_cast<int>(row.lobes.size()), 1, false, row.planar})
        .launch({kGroup}, x, y, z, texels, ways, sums, fit, 0);
    device.read(sums, values.data(), sums.byte_count());
    for (std::size_t i = 0; i < level.size(); i += 2)
      features->emplace_back(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
  }
  std::vector<MultumVmfLobe> found;
  for (std::size_t i = 0; i < level.size(); i += 2) found.push_back(level[i]);
  return found;
}

glm::dvec4 chosen_moments(const MultumVmfLobe& lobe) {
  return glm::dvec4(lobe.mean_x, lobe.mean_y, lobe.mean_z, 1.0) * static_cast<double>(lobe.amplitude);
}

std::vector<int> chosen_widths(const Device& device) {
  return device.kernels_are_edited() ? std::vector<int>{1} : std::vector<int>{1, device.shape().vector_width};
}

// All normals are equal, so the lobe of the parent must get all of them, even though rounding makes their scatter
// negative.
void choice_of_equal_normals(Device& device, WorstError& worst) {
  const std::vector<MultumVmfLobe> lobes = {
      {0.6f, 0.0f, 0.8f, 0.25f}, {-0.6f, 0.0f, 0.8f, 0.25f}, {0.0f, 0.6f, 0.8f, 0.25f}, {0.0f, -0.6f, 0.8f, 0.25f}};
  for (std::size_t j = 0; j < lobes.size(); ++j) {
    const glm::dvec3 near(lobes[j].mean_x, lobes[j].mean_y, lobes[j].mean_z);
    for (const double length : {1.0 - 0x1p-23, 1.0, 1.0 + 0x1p-22})
      for (const int width : chosen_widths(device)) {
        const std::vector<MultumVmfLobe> found =
            choose_row(device, {std::vector<glm::dvec3>(4 * kGroup, near * length), lobes}, width);
        for (std::size_t i = 0; i < found.size(); ++i) {
          const double expected = i / kGroup == j ? 1.0 : 0.0;
          worst.add(static_cast<double>(found[i].amplitude), expected, 1.0, fmt::format("lobe {}", i / kGroup));
        }
      }
  }
}

// There are more lobes than normals, and one normal is NaN. Every lobe must be finite, except in the texel that
// contains the NaN normal.
void choice_without_normals(Device& device, WorstError& worst) {
  constexpr std::size_t kBad = 5;
  for (const bool planar : {false, true}) {
    std::vector<MultumVmfLobe> lobes;
    for (int j = 0; j < 8; ++j) {
      const glm::dvec3 mu = tilted(40.0, 0.7 * j);
      lobes.push_back({static_cast<float>(mu.x), static_cast<float>(mu.y), planar ? 0.01f : static_cast<float>(mu.z),
                       j == 3 ? 0.0f : 1.0f / 7.0f});
    }
    ChosenRow row{{}, lobes, planar};
    for (std::size_t i = 0; i < 4 * kGroup; ++i) row.normals.push_back(tilted(37.0, 1.1 * static_cast<double>(i)));
    row.normals[4 * kBad].x = static_cast<double>(NAN);
    for (const int width : chosen_widths(device)) {
      std::vector<glm::dvec3> features;
      const std::vector<MultumVmfLobe> found = choose_row(device, row, width, &features);
      for (std::size_t texel = 0; texel < kGroup; ++texel) {
        if (texel == kBad) continue;
        glm::dvec4 sum(0.0);
        for (std::size_t j = 0; j < lobes.size(); ++j) {
          const glm::dvec4 moments = chosen_moments(found[j * kGroup + texel]);
          sum += moments;
          // If the features are normals, their mean is the lobe's first moment. Gaussians store its x and y.
          glm::dvec3 off = features[j * kGroup + texel] - glm::dvec3(moments);
          if (planar) off.z = 0.0;
          worst.add(glm::length(off), fmt::format("features of texel {}, lobe {}", texel, j));
        }
        glm::dvec4 expected(0.0);
        for (std::size_t i = 0; i < 4; ++i) {
          const glm::dvec3& n = row.normals[4 * texel + i];
          expected += 0.25 * glm::dvec4(n, 1.0);
        }
        if (planar) sum.z = expected.z;  // the third value is not a moment
        worst.add(glm::length(sum - expected), fmt::format("texel {}, {}", texel, planar ? "Gaussians" : "lobes"));
      }
    }
  }
}

}  // namespace

std::vector<NumericalCase> choose_cases() {
  return {{{"choice-of-equal-normals", "movmf_choose",
            "rounding makes the scatter of equal normals negative, and the square root of a negative number is NaN, "
            "which is never chosen as the lowest cost",
            "the kernel adds a small constant under every square root, which does not visibly change highlights",
            kNothingWrong, "wrong amplitudes", "every amplitude must be correct"},
           choice_of_equal_normals,
           {{"movmf_choose", "const float e = 0.5f / fit.kappa_cap;", "const float e = 0.0f;"}}},
          {{"choice-without-normals", "movmf_choose, movmf_feature_chosen",
            "the mean of a lobe without normals is 0 divided by 0", "the lobe keeps the mean of its parent", 1e-6,
            "absolute error of the features and of the sums of a and a r over the lobes",
            "only four additions are rounded"},
           choice_without_normals,
           {{"movmf_choose", "if (ANY_V(is_empty))", "if (false)"}}}};
}

}  // namespace multum
