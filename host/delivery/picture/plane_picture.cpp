// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/picture/plane_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>

#include "host/formats/brdf/fresnel.h"
#include "host/foundation/base/error.h"
#include "kernels/shared/plane_picture.h"

namespace multum {
namespace {

constexpr int kSideMax = 16384, kTapsMax = 64;

void check(const PlaneView& view) {
  const auto refuse = [](const std::string& found, const std::string& expected) {
    throw Error(ErrorCode::kUsage, fmt::format("render_plane: {}, expected {}", found, expected));
  };
  if (view.width < 1 || view.height < 1 || view.width > kSideMax || view.height > kSideMax)
    refuse(fmt::format("the size is {} x {} pixels", view.width, view.height),
           fmt::format("1 to {} per side", kSideMax));
  if (view.taps < 1 || view.taps > kTapsMax)
    refuse(fmt::format("taps is {}", view.taps), fmt::format("1 to {}", kTapsMax));
  if (!(view.fov > 0.0 && view.fov < 180.0))
    refuse(fmt::format("fov is {}", view.fov), "an angle above 0 and below 180");
  for (const glm::dvec3* one : {&view.eye, &view.target, &view.light})
    for (int c = 0; c < 3; ++c)
      if (!std::isfinite((*one)[c])) refuse("eye, target or light is not finite", "finite numbers");
  if (!(view.eye.z > 0.0)) refuse(fmt::format("eye is at z = {}", view.eye.z), "a point above the plane, with z > 0");
  if (!(glm::length(view.target - view.eye) > 1e-9)) refuse("eye and target are the same point", "different points");
  if (!(std::abs(glm::length(view.light) - 1.0) < 1e-3))
    refuse(fmt::format("light has length {:g}", glm::length(view.light)), "a unit vector");
}

void store(const glm::dvec3& v, float* to) {
  for (int c = 0; c < 3; ++c) to[c] = static_cast<float>(v[c]);
}

int wrap_number(WrapMode mode) {
  switch (mode) {
    case WrapMode::kBlack: return 0;
    case WrapMode::kClamp: return 1;
    case WrapMode::kPeriodic: return 2;
    case WrapMode::kMirror: return 3;
  }
  return 2;
}

int visibility_number(const Brdf& brdf) {
  switch (brdf.kind) {
    case BrdfKind::kCookTorrance: return MULTUM_PLANE_V_GROOVES;
    case BrdfKind::kGgx: return MULTUM_PLANE_V_SMITH;
    case BrdfKind::kCharlie: return MULTUM_PLANE_V_SHEEN;
    default: MULTUM_CHECK(family_of(brdf).visibility == nullptr); return MULTUM_PLANE_V_ONE;
  }
}

void set_camera(const PlaneView& view, MultumPlanePicture& picture) {
  const glm::dvec3 forward = glm::normalize(view.target - view.eye);
  const glm::dvec3 upright = std::abs(forward.z) < 0.999 ? glm::dvec3(0.0, 0.0, 1.0) : glm::dvec3(0.0, 1.0, 0.0);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, upright)), down = glm::cross(forward, right);
  const double pixel = 2.0 * std::tan(view.fov * std::numbers::pi / 360.0) / view.height;
  store(view.eye, picture.eye);
  store(pixel * right, picture.along_x);
  store(pixel * down, picture.along_y);
  store(forward - 0.5 * pixel * (static_cast<double>(view.width) * right + static_cast<double>(view.height) * down),
        picture.corner);
  store(view.light, picture.light);
  picture.width = view.width;
  picture.height = view.height;
  picture.taps = view.taps;
}

void set_map(const PlaneTexels& texels, MultumPlanePicture& picture) {
  const BakedHeader& header = texels.header();
  picture.map_width = header.width;
  picture.map_height = header.height;
  picture.first_level = header.first_level;
  picture.last_level = header.level_count() - 1;
  picture.wrap_s = wrap_number(header.wrap_s);
  picture.wrap_t = wrap_number(header.wrap_t);
  picture.has_colours = header.has_colours ? 1 : 0;
  picture.mean_cosine = header.has_roughness ? header.mean_cosine : 0.0f;
}

void set_brdf(const PlaneBrdf& brdf, bool has_roughness, MultumPlanePicture& picture) {
  picture.has_diffuse_fresnel = has_diffuse_fresnel(brdf.brdf) ? 1 : 0;
  store(glm::dvec3(brdf.brdf.diffuse), picture.diffuse);
  store(glm::dvec3(brdf.brdf.specular), picture.specular);
  picture.exponent = static_cast<float>(brdf.exponent);
  picture.alpha = ggx_alpha(brdf.brdf);
  if (brdf.terms.empty()) return;
  if (has_roughness) {  // the lobes themselves are the highlight
    picture.term_count = 1;
    store(glm::dvec3(1.0), picture.weights[0]);
    return;
  }
  MULTUM_CHECK(brdf.terms.size() <= MULTUM_PLANE_TERMS);
  picture.is_blinn_phong = brdf.brdf.kind == BrdfKind::kBlinnPhong ? 1 : 0;
  picture.visibility = visibility_number(brdf.brdf);
  picture.term_count = static_cast<int>(brdf.terms.size());
  for (std::size_t i = 0; i < brdf.terms.size(); ++i) {
    store(brdf.terms[i].weight, picture.weights[i]);
    picture.spreads[i] = static_cast<float>(brdf.terms[i].spread);
  }
}

std::vector<float> fresnel_table(const Brdf& brdf) {
  std::vector<float> table;
  for (int i = 0; i <= MULTUM_PLANE_FRESNEL_STEPS; ++i) {
    const glm::dvec3 f = fresnel(brdf, static_cast<double>(i) / MULTUM_PLANE_FRESNEL_STEPS);
    for (int c = 0; c < 3; ++c) table.push_back(static_cast<float>(f[c]));
    table.push_back(0.0f);
  }
  return table;
}

// Returns the footprint of a pixel's ray in texels of level 0, along both axes of the picture.
std::pair<double, double> footprint(const MultumPlanePicture& p, double x, double y) {
  glm::dvec3 corner(p.corner[0], p.corner[1], p.corner[2]), along_x(p.along_x[0], p.along_x[1], p.along_x[2]),
      along_y(p.along_y[0], p.along_y[1], p.along_y[2]);
  const glm::dvec3 ray = corner + x * along_x + y * along_y;
  const double t = -static_cast<double>(p.eye[2]) / ray.z;
  const auto texels = [&](const glm::dvec3& along) {
    const glm::dvec3 change = t * (along - ray * (along.z / ray.z));
    return std::hypot(change.x * p.map_width, change.y * p.map_height);
  };
  return {texels(along_x), texels(along_y)};
}

// Returns the finest and the coarsest level of the pixels, rounded outwards, because the kernel rounds differently.
std::pair<int, int> needed_levels(const MultumPlanePicture& p) {
  constexpr double kRounding = 0.01;  // levels
  double least = 1e30, most = -1e30;
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) {
      const double pixel_x = x + 0.5, pixel_y = y + 0.5;
      const double z = static_cast<double>(p.corner[2]) + pixel_x * static_cast<double>(p.along_x[2]) +
                       pixel_y * static_cast<double>(p.along_y[2]);
      if (z > -1e-6) continue;
      const auto [along_x, along_y] = footprint(p, pixel_x, pixel_y);
      const double longer = std::max(along_x, along_y), shorter = std::min(along_x, along_y);
      least = std::min(least, std::log2(std::max({shorter, 0.5 * longer / p.taps, 1e-15})));
      most = std::max(most, std::log2(std::max(longer, 1e-15)));
    }
  if (least > most) return {1, 0};  // the plane is not visible
  const double first = p.first_level, last = p.last_level;
  return {static_cast<int>(std::clamp(std::floor(least - kRounding), first, last)),
          static_cast<int>(std::clamp(std::floor(most + kRounding), first, last))};
}

class PlanePainter {
 public:
  PlanePainter(Device& device, const PlaneTexels& texels, const Brdf& brdf, const MultumPlanePicture& picture)
      : device_(device),
        texels_(texels),
        picture_(picture),
        fresnel_(fresnel_table(brdf)),
        fresnel_buffer_(device.wrap_buffer(fresnel_.data(), fresnel_.size() * sizeof(float), "Fresnel factors")),
        kernel_(device.kernel("plane_picture", "plane_picture", {texels.lobe_count(), 1, false, false})),
        pixels_(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height)),
        painted_(device.make_buffer(pixels_ * 4 * sizeof(float), "a picture")) {
    device_.fill_zero(painted_);
  }

  void paint(int level) {
    picture_.level = level;
    const int coarser = std::min(level + 1, picture_.last_level);
    const DeviceBuffer lobes = buffer(texels_.lobes(level)), coarser_lobes = buffer(texels_.lobes(coarser));
    const bool has_colours = picture_.has_colours != 0;
    const DeviceBuffer colours = has_colours ? buffer(texels_.colours(level)) : DeviceBuffer();
    const DeviceBuffer coarser_colours = has_colours ? buffer(texels_.colours(coarser)) : DeviceBuffer();
    kernel_.launch({pixels_}, picture_, lobes, coarser_lobes, has_colours ? colours : lobes,
                   has_colours ? coarser_colours : lobes, fresnel_buffer_, painted_);
    device_.finish();
  }

  std::vector<float> picture() {
    std::vector<float> rgba(4 * pixels_);
    device_.read(painted_, rgba.data(), rgba.size() * sizeof(float));
    return rgba;
  }

 private:
  DeviceBuffer buffer(const std::vector<float>& values) {
    return device_.wrap_buffer(values.data(), values.size() * sizeof(float), "a level");
  }

  Device& device_;
  const PlaneTexels& texels_;
  MultumPlanePicture picture_;
  std::vector<float> fresnel_;
  DeviceBuffer fresnel_buffer_;
  Kernel kernel_;
  std::size_t pixels_;
  DeviceBuffer painted_;
};

}  // namespace

std::vector<float> draw_plane(Device& device, const PlaneTexels& texels, const PlaneBrdf& brdf, const PlaneView& view,
                              Progress* progress) {
  check(view);
  MultumPlanePicture picture = {};
  set_camera(view, picture);
  set_map(texels, picture);
  set_brdf(brdf, texels.header().has_roughness, picture);
  const auto [first, last] = needed_levels(picture);
  progress_start(progress, static_cast<std::uint64_t>(std::max(last - first + 1, 1)));
  progress_stage(progress, "draw the plane");
  PlanePainter painter(device, texels, brdf.brdf, picture);
  for (int level = first; level <= last; ++level) {
    painter.paint(level);
    progress_advance(progress, 1);
  }
  progress_finish(progress);
  return painter.picture();
}

}  // namespace multum
