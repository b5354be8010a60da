// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/forms/material_forms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "host/delivery/forms/chosen_suns.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr int kPointsAnisotropy = 16;  // requested by @multum/three and supported by GPUs
constexpr int kPointsPerSide = 2;
// These values are those of @multum/three (runtime_gl/web/three/lobe_material.js).
constexpr double kPointsBias = -0.25 - 1.0, kLobeBias = -0.5, kLobesFrom = 0.002, kMagnified = -3.0;
constexpr double kLobeRoughnessMin = 0.045;
constexpr int kPixelsAtOnce = 64;

double pow4(double v) { return v * v * (v * v); }

glm::dvec3 turned_by(const SurfacePoint& frame, const glm::dvec3& n) {
  return n.x * frame.tangent + n.y * frame.bitangent + n.z * frame.normal;
}

// Transforms a lobe. A sum of normals or lobes keeps its length even if the frame's tangents are not at right angles.
glm::dvec4 turned_lobe(const SurfacePoint& frame, const glm::dvec4& lobe) {
  const glm::dvec3 turned = turned_by(frame, glm::dvec3(lobe));
  const double length = glm::length(turned);
  return {turned * (length > 1e-12 ? glm::length(glm::dvec3(lobe)) / length : 0.0), lobe.w};
}

// Returns the interpolated values at the point that is `x` and `y` pixels away from the pixel's middle.
SurfacePoint moved(const ModelPixel& pixel, double x, double y) {
  SurfacePoint made = pixel.middle + pixel.along_x * x + pixel.along_y * y;
  made.normal = glm::normalize(made.normal);
  return made;
}

// The offsets of the pixels whose normals are compared with a pixel's normal.
constexpr glm::dvec2 kBeside[] = {{1.0, 0.0}, {0.0, 1.0}};

constexpr double kPictureShare = 100.0 / kFormSuns;  // share of a picture in the error of its lighting, in percent

double part_place(int i, int count) { return (i + 0.5) / count - 0.5; }

}  // namespace

FormMeter::FormMeter(const FormTextures& textures, const std::vector<ModelPicture>& pictures,
                     const FormMeterSettings& settings)
    : textures_(textures),
      filter_(filter_of(settings.engine)),
      has_points_(settings.has_points),
      threads_(settings.threads),
      surroundings_(settings.surroundings) {
  for (const ModelPicture& picture : pictures) views_.push_back({picture.distance, picture.shape});
  std::sort(views_.begin(), views_.end());
  views_.erase(std::unique(views_.begin(), views_.end()), views_.end());
  for (const ModelPicture& picture : pictures) {
    const auto at = std::lower_bound(views_.begin(), views_.end(), FormView{picture.distance, picture.shape});
    for (const ModelPixel& pixel : picture.pixels)
      pixels_.push_back({&picture,
                         &pixel,
                         static_cast<std::size_t>(at - views_.begin()),
                         {},
                         {},
                         {},
                         {},
                         {1.0, 1.0, 1.0},
                         {},
                         {},
                         {}});
  }
  for_each_row_band(static_cast<int>(pixels_.size()), kPixelsAtOnce, threads_, [&](int, int begin, int end) {
    for (int i = begin; i < end; ++i) prepare(pixels_[size_of(i)], size_of(i));
  });
  // The relative L1 error is the sum of differences divided by the sum of references, over all pixels of a view.
  // Returns the mean of this error over lights.
  const auto occurrence = [](const Measured& at, std::size_t l) { return at.sun_weights[l % kFormSuns]; };
  std::vector<FormLight> wholes(views_.size());
  for (const Measured& at : pixels_)
    for (std::size_t l = 0; l < kFormLights; ++l) wholes[at.view][l] += occurrence(at, l) * at.reference[l];
  for (Measured& at : pixels_)
    for (std::size_t l = 0; l < kFormLights; ++l)
      at.weights[l] = occurrence(at, l) * kPictureShare / std::max(wholes[at.view][l], 1e-12);
}

// Chooses lights around the highlights of the surface's normals and of their mean, which mips contain.
void FormMeter::light(Measured& at, std::uint64_t seed) const {
  constexpr std::size_t kSampled = 16;
  constexpr double kAlphaLeast = 0.05;
  const ModelPixel& pixel = *at.pixel;
  std::vector<glm::dvec3> normals;
  glm::dvec3 sum(0.0);
  double alpha = kAlphaLeast;
  for (std::size_t i = 0; i < kSampled; ++i) {
    const SurfacePoint sample = pixel.sample((2 * i + 1) * pixel.sample_count() / (2 * kSampled));
    const glm::dvec4 texel = textures_.averages->linear(0, sample.place);
    normals.push_back(glm::normalize(turned_by(sample, 2.0 * glm::dvec3(texel) - 1.0)));
    sum += normals.back();
    alpha = std::max(alpha, 1.5 * texel.w * texel.w);
  }
  const double length = glm::length(sum);
  normals.resize(2 * kSampled, length > 1e-6 ? sum / length : pixel.middle.normal);
  const auto suns = choose_suns(normals, alpha, glm::normalize(at.picture->eye - pixel.middle.position), seed);
  for (std::size_t i = 0; i < kFormSuns; ++i) {
    at.scene.suns[i] = suns[i].direction;
    at.sun_weights[i] = suns[i].weight;
  }
}

void FormMeter::prepare(Measured& at, std::size_t number) const {
  const ModelPixel& pixel = *at.pixel;
  at.scene.surroundings = surroundings_;
  if (surroundings_ == FormSurroundings::kSky) light(at, number);
  const Reference reference = reference_of(*at.picture, pixel, nullptr, at.scene);
  at.reference = reference.light;
  at.noise = reference.noise;
  at.middle = look(pixel.middle, pixel, filter_.anisotropy_max, 0.0);
  if (filter_.is_of_map)
    for (const glm::dvec2& step : kBeside)
      at.beside.push_back(look(moved(pixel, step.x, step.y), pixel, filter_.anisotropy_max, 0.0));
  if (!has_points_) return;
  for (int p = 0; p < kPointsPerSide * kPointsPerSide; ++p)
    at.points.push_back(look(
        moved(pixel, part_place(p % kPointsPerSide, kPointsPerSide), part_place(p / kPointsPerSide, kPointsPerSide)),
        pixel, kPointsAnisotropy, kPointsBias));
}

double FormMeter::LookedLevel::roughness(const LevelForm& form) const {
  return mixed_roughness(rough, fitted_rough, form.fitted_share);
}

FormMeter::Looked FormMeter::look(const SurfacePoint& point, const ModelPixel& pixel, int anisotropy_max,
                                  double bias) const {
  const PixelTaps taps = PixelTaps::of(point.place, pixel.along_x.place, pixel.along_y.place,
                                       textures_.averages->frame(), anisotropy_max, bias);
  Looked made;
  made.levels = taps.levels;
  made.coarser_share = taps.coarser_share;
  made.metal = textures_.surface == nullptr ? textures_.metallic_factor : 0.0;
  for (std::size_t k = 0; k < 2; ++k) {
    PixelTaps own = taps;
    own.levels = {taps.levels[k], taps.levels[k]};
    own.coarser_share = 0.0;
    LookedLevel& at = made.values[k];
    const glm::dvec4 averaged = own.mean(*textures_.averages);
    at.averaged = 2.0 * glm::dvec3(averaged) - 1.0;
    at.fitted = 2.0 * glm::dvec3(own.mean(*textures_.normals)) - 1.0;
    at.rough = averaged.w;
    if (textures_.surface == nullptr) continue;
    const glm::dvec4 surface = own.mean(*textures_.surface);
    at.fitted_rough = surface.y;
    made.metal += (k == 0 ? 1.0 - taps.coarser_share : taps.coarser_share) * surface.z * textures_.metallic_factor;
  }
  return made;
}

FormMeter::Reference FormMeter::reference_of(const ModelPicture& picture, const ModelPixel& pixel,
                                             const LobeLevels* lobes, const FormScene& scene) const {
  std::array<FormLight, 2> halves{};
  const std::size_t count = pixel.sample_count();
  for (std::size_t i = 0; i < count; ++i) {
    const SurfacePoint sample = pixel.sample(i);
    const glm::dvec4 texel = textures_.averages->linear(0, sample.place);
    const glm::dvec3 normal = glm::normalize(2.0 * glm::dvec3(texel) - 1.0), turned = turned_by(sample, normal);
    FormSurface surface{texel.w, textures_.metallic_factor,
                        lobes == nullptr ? textures_.colour : lobes->finest_luminance(sample.place, normal)};
    if (textures_.surface != nullptr && textures_.has_metalness_map)
      surface.metalness *= textures_.surface->linear(0, sample.place).z;
    const FormLight light =
        shaded_normal(glm::normalize(turned), surface, glm::normalize(picture.eye - sample.position), scene);
    for (std::size_t l = 0; l < kFormLights; ++l) halves[i % 2][l] += light[l];
  }
  const double share = 1.0 / static_cast<double>(count);
  Reference made{};
  for (std::size_t l = 0; l < kFormLights; ++l) {
    made.light[l] = share * (halves[0][l] + halves[1][l]);
    made.noise[l] = share * std::abs(halves[0][l] - halves[1][l]);
  }
  return made;
}

FormMeter::Bent FormMeter::bent(const SurfacePoint& point, const Looked& looked, const NormalForm& form,
                                const EngineFilter& filter) {
  const LevelForm &finer = form.levels[size_of(looked.levels[0])], &coarser = form.levels[size_of(looked.levels[1])];
  const auto mixed = [&](const auto& one, const auto& other) {
    return (1.0 - looked.coarser_share) * one + looked.coarser_share * other;
  };
  glm::dvec3 read = mixed(looked.values[0].normal(finer), looked.values[1].normal(coarser));
  if (filter.rebuilds_z) read.z = std::sqrt(std::max(0.0, 1.0 - read.x * read.x - read.y * read.y));
  const glm::dvec3 turned = turned_by(point, read);
  const double length = glm::length(turned);
  return {length > 1e-9 ? turned / length : point.normal,
          mixed(looked.values[0].roughness(finer), looked.values[1].roughness(coarser))};
}

double FormMeter::contribution(const Measured& at, const FormLight& light, const LightRange& range) {
  double sum = 0.0;
  for (std::size_t l = range.begin; l < range.end; ++l) sum += at.weights[l] * std::abs(light[l] - at.reference[l]);
  return sum;
}

template <typename Shade>
std::vector<double> FormMeter::contributions(const Shade& shade) const {
  std::vector<double> made(pixels_.size());
  for_each_row_band(static_cast<int>(pixels_.size()), kPixelsAtOnce, threads_, [&](int, int begin, int end) {
    for (std::size_t i = size_of(begin); i < size_of(end); ++i)
      made[i] = contribution(pixels_[i], shade(pixels_[i]), kSunLights);
  });
  return made;
}

template <typename Shade>
LitErrors FormMeter::lit_errors(const Shade& shade) const {
  std::vector<double> suns(pixels_.size()), surroundings(pixels_.size());
  for_each_row_band(static_cast<int>(pixels_.size()), kPixelsAtOnce, threads_, [&](int, int begin, int end) {
    for (std::size_t i = size_of(begin); i < size_of(end); ++i) {
      const FormLight light = shade(pixels_[i]);
      suns[i] = contribution(pixels_[i], light, kSunLights);
      surroundings[i] = contribution(pixels_[i], light, kSurroundingLights);
    }
  });
  return {errors_of(suns), errors_of(surroundings)};
}

FormError FormMeter::errors_of(const std::vector<double>& contributions) const {
  FormError made;
  made.by_view.resize(views_.size());
  for (std::size_t i = 0; i < pixels_.size(); ++i) made.by_view[pixels_[i].view] += contributions[i];
  for (const double error : made.by_view) made.mean += error / static_cast<double>(views_.size());
  return made;
}

FormLight FormMeter::middle_light(const Measured& at, const NormalForm& form) const {
  const ModelPixel& pixel = *at.pixel;
  const Bent here = bent(pixel.middle, at.middle, form, filter_);
  std::array<glm::dvec3, 2> along = {pixel.along_x.normal, pixel.along_y.normal};
  for (std::size_t i = 0; i < at.beside.size(); ++i)
    along[i] = bent(moved(pixel, kBeside[i].x, kBeside[i].y), at.beside[i], form, filter_).normal - here.normal;
  const glm::dmat3& to_view = at.picture->to_view;
  const EngineRoughness rough = engine_roughness(filter_, here.roughness, to_view * along[0], to_view * along[1]);
  return shaded_normal(here.normal, {rough.lights, at.middle.metal, textures_.colour, rough.surroundings},
                       glm::normalize(at.picture->eye - pixel.middle.position), at.scene);
}

FormError FormMeter::noise() const { return lit_noise().suns; }

LitErrors FormMeter::lit_noise() const {
  return lit_errors([](const Measured& at) {
    FormLight light = at.reference;
    for (std::size_t l = 0; l < kFormLights; ++l) light[l] += at.noise[l];
    return light;
  });
}

FormError FormMeter::normals(const NormalForm& form) const {
  return errors_of(contributions([&](const Measured& at) { return middle_light(at, form); }));
}

LitErrors FormMeter::lit_normals(const NormalForm& form) const {
  return lit_errors([&](const Measured& at) { return middle_light(at, form); });
}

FormLight FormMeter::point_light(const Measured& at, const NormalForm& form, double colour) const {
  constexpr int kPoints = kPointsPerSide * kPointsPerSide;
  FormLight sum{};
  for (int p = 0; p < kPoints; ++p) {
    const SurfacePoint point = moved(*at.pixel, part_place(p % kPointsPerSide, kPointsPerSide),
                                     part_place(p / kPointsPerSide, kPointsPerSide));
    const Looked& looked = at.points[size_of(p)];
    const Bent here = bent(point, looked, form, filter_of(Engine::kThree));
    const double rough = roughness_of_variance(here.roughness, at.pixel->along_x.normal * (1.0 / kPointsPerSide),
                                               at.pixel->along_y.normal * (1.0 / kPointsPerSide));
    const FormLight light = shaded_normal(here.normal, {rough, looked.metal, colour},
                                          glm::normalize(at.picture->eye - point.position), at.scene);
    for (std::size_t l = 0; l < kFormLights; ++l) sum[l] += light[l] / kPoints;
  }
  return sum;
}

FormError FormMeter::points(const NormalForm& form) const {
  return errors_of(contributions([&](const Measured& at) { return point_light(at, form, textures_.colour); }));
}

FormLight FormMeter::shade_lobes(const Measured& at, const LobeLevels& lobes, const NormalForm& form,
                                 const PixelColours& colours) const {
  const ModelPixel& pixel = *at.pixel;
  const auto count = size_of(lobes.count());
  // Adds the lobes of a part of the pixel in world space. The share that the normal map itself contributes is part of
  // the first lobe.
  const auto add_lobes = [&](int number, const glm::ivec2& grid, std::vector<glm::dvec4>& sums) {
    const double level = lobes.level_of(pixel.along_x.place / static_cast<double>(grid.x),
                                        pixel.along_y.place / static_cast<double>(grid.y), kLobeBias);
    const SurfacePoint point = moved(pixel, part_place(number % grid.x, grid.x), part_place(number / grid.x, grid.y));
    const double map_share = std::clamp(-level, 0.0, 1.0);
    if (map_share < 1.0) {
      const std::vector<glm::dvec4> read = lobes.at(point.place, level);
      for (std::size_t j = 0; j < count; ++j) sums[j] += (1.0 - map_share) * turned_lobe(point, read[j]);
    }
    if (map_share == 0.0) return;
    const glm::dvec3 mean = 2.0 * glm::dvec3(textures_.normals->linear(0, point.place)) - 1.0;
    // Follows multum_movmf_magnified(). Level 0 of the map is one level finer than level 0 of the lobes.
    const double length = std::max(glm::length(mean), 1e-9);
    const double seen = std::exp2(2.0 * std::min(level + 1.0, 0.5) - 1.0);
    sums[0] += map_share * turned_lobe(point, {mean * ((1.0 - seen + seen * std::min(length, 1.0)) / length), 1.0});
  };
  const double level = lobes.level_of(pixel.along_x.place, pixel.along_y.place, kLobeBias);
  if (level <= kMagnified) return point_light(at, form, colours.mean);
  glm::dvec4 all_normals(0.0);
  for (const glm::dvec4& lobe : lobes.at(pixel.middle.place, std::max(level - 1.0, 0.0))) all_normals += lobe;
  if (1.0 - glm::length(glm::dvec3(all_normals)) / std::max(all_normals.w, 1e-6) <= kLobesFrom)
    return point_light(at, form, colours.mean);
  const bool lobes_pay = level >= 1.0 && count <= kPointsPerSide * kPointsPerSide;
  const glm::dvec3 view = glm::normalize(at.picture->eye - pixel.middle.position);
  FormLight made{};
  const auto add_light = [&](const glm::dvec4& lobe, double weight, const Looked& looked, const glm::dvec3& from,
                             double factor) {
    const double rough =
        looked.values[0].rough + looked.coarser_share * (looked.values[1].rough - looked.values[0].rough);
    const double widened = lobes_pay ? rough
                                     : roughness_of_variance(rough, pixel.along_x.normal * (1.0 / kPointsPerSide),
                                                             pixel.along_y.normal * (1.0 / kPointsPerSide));
    const FormSurface surface{std::max(widened, kLobeRoughnessMin), looked.metal, factor * colours.mean};
    const FormLight light = shaded_lobe(lobe / std::max(lobe.w, 1e-6), surface, from, at.scene);
    for (std::size_t l = 0; l < kFormLights; ++l) made[l] += weight * light[l];
  };
  std::vector<glm::dvec4> all(count, glm::dvec4(0.0));
  constexpr int kPoints = kPointsPerSide * kPointsPerSide;
  const glm::ivec2 grid =
      lobes_pay ? lobes.grid(kPoints, pixel.along_x.place, pixel.along_y.place) : glm::ivec2(kPointsPerSide);
  for (int p = 0; p < kPoints; ++p) {
    if (lobes_pay) {
      add_lobes(p, grid, all);
      continue;
    }
    std::vector<glm::dvec4> own(count, glm::dvec4(0.0));
    add_lobes(p, grid, own);
    glm::dvec4 sum(0.0);
    for (const glm::dvec4& lobe : own) sum += lobe;
    const SurfacePoint point = moved(pixel, part_place(p % grid.x, grid.x), part_place(p / grid.x, grid.y));
    add_light(sum, 0.25, at.points[size_of(p)], glm::normalize(at.picture->eye - point.position), 1.0);
  }
  if (!lobes_pay) return made;
  glm::dvec4 sum(0.0);
  for (const glm::dvec4& lobe : all) sum += lobe;
  for (std::size_t j = 0; j < count; ++j)
    if (all[j].w > 1e-6)
      add_light(all[j], all[j].w / sum.w, at.middle, view, colours.factors.empty() ? 1.0 : colours.factors[j]);
  return made;
}

LitErrors FormMeter::lit_lobes(const LobeLevels& lobes, const NormalForm& form) const {
  return lit_errors([&](const Measured& at) { return shade_lobes(at, lobes, form, {textures_.colour, {}}); });
}

FormError FormMeter::lobes(const LobeLevels& lobes, const NormalForm& form) const {
  return lit_lobes(lobes, form).suns;
}

FormMeter::PixelColours FormMeter::colours_of(const ModelPixel& pixel, const LobeLevels& lobes) {
  constexpr double kTintMax = 4.0;  // MULTUM_TINT_MAX of lobe_shading.js
  constexpr int kPlaces = kPointsPerSide * kPointsPerSide;
  const auto count = size_of(lobes.count());
  const glm::ivec2 grid = lobes.grid(kPlaces, pixel.along_x.place, pixel.along_y.place);
  const double level = lobes.level_of(pixel.along_x.place / static_cast<double>(grid.x),
                                      pixel.along_y.place / static_cast<double>(grid.y), kLobeBias);
  std::vector<double> luminances(count, 0.0), amplitudes(count, 0.0);
  for (int p = 0; p < kPlaces; ++p) {
    const glm::dvec2 place = moved(pixel, part_place(p % grid.x, grid.x), part_place(p / grid.x, grid.y)).place;
    const std::vector<double> read = lobes.luminances(place, level);
    const std::vector<glm::dvec4> own = lobes.at(place, level);
    for (std::size_t j = 0; j < count; ++j) luminances[j] += read[j] / kPlaces, amplitudes[j] += own[j].w / kPlaces;
  }
  PixelColours made{0.0, {}};
  for (const double luminance : luminances) made.mean += luminance;
  for (std::size_t j = 0; j < count; ++j)
    made.factors.push_back(std::clamp(luminances[j] / std::max(amplitudes[j] * made.mean, 1e-6), 0.0, kTintMax));
  return made;
}

FormMeter::Coloured FormMeter::coloured_lobes(const LobeLevels& lobes, const NormalForm& form) const {
  struct Lights {
    FormLight reference, mean, own;
  };
  std::vector<Lights> lights(pixels_.size());
  for_each_row_band(static_cast<int>(pixels_.size()), kPixelsAtOnce, threads_, [&](int, int begin, int end) {
    for (std::size_t i = size_of(begin); i < size_of(end); ++i) {
      const Measured& at = pixels_[i];
      const PixelColours own = colours_of(*at.pixel, lobes);
      lights[i].reference = reference_of(*at.picture, *at.pixel, &lobes, at.scene).light;
      lights[i].mean = shade_lobes(at, lobes, form, {own.mean, {}});
      lights[i].own = shade_lobes(at, lobes, form, own);
    }
  });
  std::vector<FormLight> wholes(views_.size());
  for (std::size_t i = 0; i < lights.size(); ++i)
    for (std::size_t l = 0; l < kFormLights; ++l) wholes[pixels_[i].view][l] += lights[i].reference[l];
  const auto error = [&](FormLight Lights::*light) {
    std::vector<double> found(lights.size(), 0.0);
    for (std::size_t i = 0; i < lights.size(); ++i)
      for (std::size_t l = 0; l < kFormSuns; ++l)
        found[i] += kPictureShare / std::max(wholes[pixels_[i].view][l], 1e-12) *
                    std::abs((lights[i].*light)[l] - lights[i].reference[l]);
    return errors_of(found);
  };
  return {error(&Lights::mean), error(&Lights::own)};
}

void FormMeter::improve(NormalForm& form, const std::vector<double>& limits) const {
  constexpr double kShares[] = {0.0, 0.25, 0.5, 0.75, 1.0};
  constexpr int kSweeps = 2;
  std::vector<double> current = contributions([&](const Measured& at) { return middle_light(at, form); });
  std::vector<double> errors = errors_of(current).by_view;
  const int last = last_seen_level();
  const auto set = [&](int level, const LevelForm& to) {
    const auto at = form.levels.begin() + level;
    std::fill(at, level == last ? form.levels.end() : at + 1, to);
  };
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (int level = 1; level <= last; ++level) {
      const std::vector<std::size_t> touched = pixels_of_levels(level, level == last ? level_count() - 1 : level);
      if (touched.empty()) continue;
      const LevelForm before = form.levels[size_of(level)];
      LevelForm best = before;
      double best_gain = 0.0;
      std::vector<double> best_values, best_errors;
      for (const bool has_fitted_normals : {false, true})
        for (const double share : kShares) {
          const LevelForm tried{has_fitted_normals, share};
          if (tried == before) continue;
          set(level, tried);
          std::vector<double> values(touched.size());
          for_each_row_band(static_cast<int>(touched.size()), kPixelsAtOnce, threads_, [&](int, int begin, int end) {
            for (std::size_t i = size_of(begin); i < size_of(end); ++i)
              values[i] = contribution(pixels_[touched[i]], middle_light(pixels_[touched[i]], form), kSunLights);
          });
          std::vector<double> changed = errors;
          double gain = 0.0;
          for (std::size_t i = 0; i < touched.size(); ++i) {
            const double less = current[touched[i]] - values[i];
            changed[pixels_[touched[i]].view] -= less;
            gain += less / static_cast<double>(views_.size());
          }
          bool is_within = gain > best_gain;
          for (std::size_t d = 0; d < changed.size(); ++d)
            is_within = is_within && changed[d] <= std::max(limits[d], errors[d]);
          if (!is_within) continue;
          best = tried;
          best_gain = gain;
          best_values = std::move(values);
          best_errors = std::move(changed);
        }
      set(level, best);
      if (best_values.empty()) continue;
      for (std::size_t i = 0; i < touched.size(); ++i) current[touched[i]] = best_values[i];
      errors = std::move(best_errors);
    }
}

int FormMeter::last_seen_level() const {
  constexpr double kPixelsMin = 16.0;
  std::vector<double> pixels(size_of(level_count()), 0.0);
  for (const Measured& at : pixels_) {
    pixels[size_of(at.middle.levels[0])] += 1.0 - at.middle.coarser_share;
    pixels[size_of(at.middle.levels[1])] += at.middle.coarser_share;
  }
  int last = level_count() - 1;
  while (last > 0 && pixels[size_of(last)] < kPixelsMin) --last;
  return last;
}

std::vector<std::size_t> FormMeter::pixels_of_levels(int first, int last) const {
  const auto is_within = [&](int level) { return level >= first && level <= last; };
  std::vector<std::size_t> made;
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    const Looked& looked = pixels_[i].middle;
    if ((is_within(looked.levels[0]) && looked.coarser_share < 1.0) ||
        (is_within(looked.levels[1]) && looked.coarser_share > 0.0))
      made.push_back(i);
  }
  return made;
}

ChosenNormalForm choose_normal_form(const FormMeter& meter, const NormalForm& kept) {
  ChosenNormalForm made;
  made.form = kept;
  made.plain = meter.normals(NormalForm::of(meter.level_count(), {}));
  made.fitted = meter.normals(NormalForm::of(meter.level_count(), {true, 1.0}));
  made.chosen = meter.normals(kept);
  std::vector<double> limits = made.chosen.by_view;
  for (double& limit : limits) limit += kFormTolerance;
  NormalForm improved = kept;
  meter.improve(improved, limits);
  const FormError error = meter.normals(improved);
  if (error.mean > made.chosen.mean - std::max(kFormGain, kFormGainShare * made.chosen.mean)) return made;
  made.form = improved;
  made.chosen = error;
  return made;
}

double mixed_roughness(double plain, double fitted, double share) {
  const double own = pow4(plain);
  return std::pow(own + share * std::max(0.0, pow4(fitted) - own), 0.25);
}

bool NormalForm::is_plain() const {
  return std::all_of(levels.begin(), levels.end(), [](const LevelForm& level) { return level.is_plain(); });
}
bool NormalForm::has_fitted_normals() const {
  return std::any_of(levels.begin(), levels.end(), [](const LevelForm& level) { return level.has_fitted_normals; });
}

}  // namespace multum
