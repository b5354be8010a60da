// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/check/gain_meter.h"

#include <cmath>
#include <glm/vec4.hpp>
#include <memory>
#include <numbers>
#include <utility>

#include "host/bakes/movmf/movmf_bake.h"
#include "host/delivery/export/held_material.h"
#include "host/delivery/forms/simple_views.h"
#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr double kObjectRadiusLeast = 4.0;  // pixels
constexpr double kSphereRadius = 3000.0;    // pixels
constexpr std::size_t kModelPixelsLeast = 24;
// Samples per side of a pixel, and of a pixel that covers many texels.
constexpr int kReferenceSamples = 8, kWideReferenceSamples = 16;
constexpr double kWideTexels = 16.0;

// Copies a small texture into memory, where lookups are several times as fast.
class CopiedTexture final : public SharesTexture {
 public:
  explicit CopiedTexture(const SharesTexture& from) : SharesTexture(from.frame()) {
    for (int level = 0; level < frame().level_count; ++level) {
      const int width = mip_level_size(frame().width, level), height = mip_level_size(frame().height, level);
      Level& made = levels_.emplace_back(Level{size_of(width), {}});
      made.texels.reserve(size_of(width) * size_of(height));
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) made.texels.push_back(from.texel(level, x, y));
    }
  }
  glm::dvec4 texel(int level, int x, int y) const override { return levels_[size_of(level)].texel(x, y); }
  glm::dvec4 linear(int level, const glm::dvec2& place) const override {
    const Level& at = levels_[size_of(level)];
    return linear_lookup(frame(), level, place, [&](int x, int y) -> const glm::dvec4& { return at.texel(x, y); });
  }

 private:
  struct Level {
    std::size_t width;
    std::vector<glm::dvec4> texels;

    const glm::dvec4& texel(int x, int y) const { return texels[size_of(y) * width + size_of(x)]; }
  };
  std::vector<Level> levels_;
};

LobeLevels fitted_lobes(Device& device, const GainSurface& surface, const GainSettings& gain, Progress* progress) {
  MovmfSettings settings;
  settings.periodic_x = settings.periodic_y = true;
  settings.first_level = 1;
  settings.search_start = false;  // the search takes longer than the whole fit of a mosaic
  FitReport report;
  MapInputs inputs{&surface.normals};
  inputs.threads = gain.threads;
  return {bake_movmf(device, inputs, settings, report, progress, gain.starts), WrapMode::kPeriodic,
          WrapMode::kPeriodic};
}

// Fits the export for one roughness, and measures all forms.
class RoughnessMeter {
 public:
  RoughnessMeter(Device& device, const GainSurface& surface, const GainSettings& settings, double roughness,
                 Progress* progress)
      : surface_(surface), settings_(settings) {
    inputs_.normals = &surface.normals;
    if (surface.material) inputs_.material = &*surface.material;
    inputs_.has_roughness = surface.has_roughness;
    inputs_.has_metalness = surface.has_metalness;
    inputs_.threads = settings.threads;
    inputs_.wants_means = true;
    OneLobeSettings one_lobe;
    one_lobe.base_roughness = roughness;
    held_.emplace(inputs_, one_lobe, filter_of(settings.engine).rebuilds_z, SpillPolicy{}, nullptr);
    fit_one_lobe(device, inputs_, one_lobe, *held_, progress);
    held_->average_roughness();
    textures_ = held_->textures();
    for (std::unique_ptr<SharesTexture>* one : {&textures_.averages, &textures_.normals, &textures_.surface})
      *one = std::make_unique<CopiedTexture>(**one);
  }

  void measure(const std::vector<ModelPicture>& seen, const LobeLevels& lobes, std::optional<double> roughness,
               std::vector<GainError>& made) const {
    const FormTextures textures = textures_.form_textures(surface_.metalness, surface_.colour);
    const NormalForm form =
        choose_export_form(textures, settings_.engine, settings_.threads, settings_.form_pixels).normals;
    const FormMeter meter(textures, seen, {settings_.engine, true, settings_.threads, FormSurroundings::kSky});
    const LitErrors plain = meter.lit_normals(NormalForm::of(meter.level_count(), {})),
                    exported = meter.lit_normals(form), of_lobes = meter.lit_lobes(lobes, form),
                    noise = meter.lit_noise();
    for (std::size_t view = 0; view < meter.views().size(); ++view)
      for (const auto& [light, errors] :
           {std::pair{GainLight::kSun, &LitErrors::suns}, std::pair{GainLight::kSky, &LitErrors::surroundings}})
        made.push_back({meter.views()[view].distance, roughness, light, (plain.*errors).by_view[view],
                        (exported.*errors).by_view[view], (of_lobes.*errors).by_view[view],
                        (noise.*errors).by_view[view]});
  }

 private:
  const GainSurface& surface_;
  const GainSettings& settings_;
  OneLobeInputs inputs_;
  std::optional<HeldMaterial> held_;
  HeldMaterial::Textures textures_;
};

// Returns pixels of the model from each distance, or pixels of a sphere if the model has too few there.
std::vector<ModelPicture> seen_pixels(const GainSurface& surface, const GainCase& settings, int threads) {
  std::vector<ModelPicture> made;
  for (const double distance : settings.distances) {
    const double pixel = kPixelAtOneMetre * distance, texels = pixel * surface.texels_per_metre;
    if (surface.radius < kObjectRadiusLeast * pixel) break;
    std::vector<ModelPicture> pictures;
    if (surface.model_pixels) pictures = surface.model_pixels(distance, settings.pixels_per_view);
    std::size_t count = 0;
    for (const ModelPicture& picture : pictures) count += picture.pixels.size();
    if (count >= kModelPixelsLeast) {
      for (ModelPicture& picture : pictures) made.push_back(std::move(picture));
      continue;
    }
    const ShapeViews views{{{texels, distance}},
                           {kSphere},
                           kSphereRadius * texels,
                           0.0,
                           settings.pixels_per_view,
                           texels > kWideTexels ? kWideReferenceSamples : kReferenceSamples,
                           threads};
    for (ModelPicture& picture : shape_views(surface.normals.width(), surface.normals.height(), views))
      made.push_back(std::move(picture));
  }
  return made;
}

}  // namespace

const double kPixelAtOneMetre = 2.0 * std::tan(22.5 * std::numbers::pi / 180.0) / 1080.0;

std::vector<GainError> measure_gain(Device& device, const GainSurface& surface, const GainSettings& settings,
                                    Progress* progress) {
  std::vector<GainError> made;
  std::optional<LobeLevels> lobes;
  for (const GainCase& one : settings.cases) {
    const std::vector<ModelPicture> seen = seen_pixels(surface, one, settings.threads);
    if (seen.empty()) continue;
    if (!lobes) lobes.emplace(fitted_lobes(device, surface, settings, progress));
    const std::optional<double> stated = surface.has_roughness ? std::nullopt : std::make_optional(one.roughness);
    RoughnessMeter(device, surface, settings, one.roughness, progress).measure(seen, *lobes, stated, made);
  }
  return made;
}

}  // namespace multum
