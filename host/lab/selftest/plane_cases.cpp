// SPDX-License-Identifier: Apache-2.0
// Tests the pictures of planes (kernels/plane_picture.cl) at places where a formula divides by 0 or leaves the range of
// an integer. The plane is flat, so the reference is a formula of one line.
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "host/delivery/picture/plane_picture.h"
#include "host/lab/selftest/case_lists.h"

namespace multum {
namespace {

constexpr int kFlatSide = 4, kFlatLevels = 3;

// A flat map of one lobe whose texels all have the normal +z.
class FlatTexels : public PlaneTexels {
 public:
  FlatTexels() {
    header_.width = header_.height = kFlatSide;
    header_.wrap_s = header_.wrap_t = WrapMode::kPeriodic;
    for (int level = 0; level < kFlatLevels; ++level)
      for (int i = 0; i < (kFlatSide >> level) * (kFlatSide >> level); ++i)
        for (const float value : {0.0f, 0.0f, 1.0f, 1.0f}) lobes_[level].push_back(value);
  }
  const BakedHeader& header() const override { return header_; }
  int lobe_count() const override { return 1; }
  const std::vector<float>& lobes(int level) const override { return lobes_[level]; }
  const std::vector<float>& colours(int level) const override { return lobes_[level]; }

 private:
  BakedHeader header_;
  std::vector<float> lobes_[kFlatLevels];
};

std::vector<float> draw_lambert(Device& device, const PlaneView& view) {
  Brdf brdf;
  brdf.kind = BrdfKind::kLambert;
  brdf.specular = glm::vec3(0.0f);
  return draw_plane(device, FlatTexels(), {brdf, {}, 0.0}, view, nullptr);
}

PlaneView small_view(const glm::dvec3& eye, const glm::dvec3& target) {
  PlaneView view;
  view.eye = eye;
  view.target = target;
  view.width = view.height = 16;
  return view;
}

// Texture coordinates of up to 1e12, near the horizon and below a camera that is far away.
void far_away(Device& device, WorstError& worst) {
  for (const double distance : {1.0, 1e4, 1e10, 1e12}) {
    const std::vector<float> picture = draw_lambert(
        device, small_view({0.3 * distance, 0.7 * distance, distance}, {0.31 * distance, 0.7 * distance, 0.0}));
    for (std::size_t i = 0; i < picture.size(); i += 4)
      worst.add(static_cast<double>(picture[i]), 0.5 / std::numbers::pi, 0.5 / std::numbers::pi,
                fmt::format("distance {:g}, pixel {}", distance, i / 4));
  }
}

// Half of the picture is above the horizon.
void horizon(Device& device, WorstError& worst) {
  const PlaneView view = small_view({0.0, 0.0, 0.5}, {0.0, 1.0, 0.5});
  const std::vector<float> picture = draw_lambert(device, view);
  for (int row = 0; row < view.height; ++row)
    for (int column = 0; column < view.width; ++column)
      worst.add(static_cast<double>(picture[static_cast<std::size_t>(4 * (row * view.width + column) + 3)]),
                row < view.height / 2 ? 0.0 : 1.0, 1.0, fmt::format("row {}, column {}", row, column));
}

SourceEdit edit(const char* text, const char* replacement) { return {"plane_picture", text, replacement}; }

}  // namespace

std::vector<NumericalCase> plane_cases() {
  return {
      {{"planes-seen-from-far-away", "plane_picture",
        "a place in texels is outside the range of an integer, so the shares of neighbouring texels are arbitrary",
        "places are clamped to 1e9 texels", 1e-5, "of the light",
        "all texels are equal, so only the rounding errors of the four shares remain"},
       far_away,
       {edit("const float x = clamp(st.x * width - 0.5f, -1e9f, 1e9f), y = clamp(st.y * height - 0.5f, -1e9f, 1e9f);",
             "const float x = st.x * width - 0.5f, y = st.y * height - 0.5f;")}},
      {{"planes-up-to-the-horizon", "plane_picture",
        "rays above the horizon meet the plane behind the camera, so the plane is also drawn in the sky",
        "rays that do not fall towards the plane are left out", 1e-6, "of full coverage", "coverage is 0 or 1"},
       horizon,
       {edit("if (ray.z > -1e-6f || eye.z <= 0.0f) return;", "if (eye.z <= 0.0f) return;")}},
  };
}

}  // namespace multum
