// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/forms/material_forms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr int kAnisotropyMax = 16;  // what three.js's add-on asks for, and GPUs have
constexpr int kPointsPerSide = 2;
// As @multum/three has them (runtime_gl/web/three/lobe_material.js).
constexpr double kPointsBias = -0.25 - 1.0, kLobeBias = -0.5, kLobesFrom = 0.002;
constexpr double kLobeRoughnessMin = 0.045;
constexpr int kPixelsAtOnce = 64;

double pow4(double v) { return v * v * (v * v); }

glm::dvec3 turned_by(const SurfacePoint& frame, const glm::dvec3& n) {
  return n.x * frame.tangent + n.y * frame.bitangent + n.z * frame.normal;
}

// A sum of normals or lobes keeps its length where a frame's tangents are not at right angles.
glm::dvec4 turned_lobe(const SurfacePoint& frame, const glm::dvec4& lobe) {
  const glm::dvec3 turned = turned_by(frame, glm::dvec3(lobe));
  const double length = glm::length(turned);
  return {turned * (length > 1e-12 ? glm::length(glm::dvec3(lobe)) / length : 0.0), lobe.w};
}

// A point of a pixel, `x` and `y` pixels from its middle, as interpolators give it.
SurfacePoint moved(const ModelPixel& pixel, double x, double y) {
  SurfacePoint made = pixel.middle + pixel.along_x * x + pixel.along_y * y;
  made.normal = glm::normalize(made.normal);
  return made;
}

double part_place(int i, int count) { return (i + 0.5) / count - 0.5; }

}  // namespace

FormMeter::FormMeter(const FormTextures& textures, const std::vector<ModelPicture>& pictures, int threads)
    : textures_(textures), threads_(threads) {
  for (const ModelPicture& picture : pictures) distances_.push_back(picture.distance);
  std::sort(distances_.begin(), distances_.end());
  distances_.erase(std::unique(distances_.begin(), distances_.end()), distances_.end());
  for (const ModelPicture& picture : pictures) {
    const auto at = std::lower_bound(distances_.begin(), distances_.end(), picture.distance);
    for (const ModelPixel& pixel : picture.pixels)
      pixels_.push_back({&picture, &pixel, static_cast<std::size_t>(at - distances_.begin()), {}, {}, {}});
  }
  for_each_row_band(static_cast<int>(pixels_.size()), kPixelsAtOnce, threads, [&](int, int begin, int end) {
    for (int i = begin; i < end; ++i) {
      Measured& at = pixels_[size_of(i)];
      at.reference = reference_of(*at.picture, *at.pixel, nullptr);
      at.looked.push_back(look(at.pixel->middle, *at.pixel, 0.0));
      for (int p = 0; p < kPointsPerSide * kPointsPerSide; ++p)
        at.looked.push_back(look(moved(*at.pixel, part_place(p % kPointsPerSide, kPointsPerSide),
                                       part_place(p / kPointsPerSide, kPointsPerSide)),
                                 *at.pixel, kPointsBias));
    }
  });
  // Relative L1: of all pixels of a distance the differences over the references, the mean of lights.
  std::vector<FormLight> wholes(distances_.size());
  for (const Measured& at : pixels_)
    for (std::size_t l = 0; l < kFormLights; ++l) wholes[at.distance][l] += at.reference[l];
  for (Measured& at : pixels_)
    for (std::size_t l = 0; l < kFormLights; ++l)
      at.weights[l] = 100.0 / kFormLights / std::max(wholes[at.distance][l], 1e-12);
}

double FormMeter::LookedLevel::roughness(const LevelForm& form) const {
  return mixed_roughness(rough, fitted_rough, form.fitted_share);
}

FormMeter::Looked FormMeter::look(const SurfacePoint& point, const ModelPixel& pixel, double bias) const {
  const PixelTaps taps = PixelTaps::of(point.place, pixel.along_x.place, pixel.along_y.place,
                                       textures_.averages->frame(), kAnisotropyMax, bias);
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

FormLight FormMeter::reference_of(const ModelPicture& picture, const ModelPixel& pixel, const LobeLevels* lobes) const {
  FormLight sum{};
  for (const SurfacePoint& sample : pixel.samples) {
    const glm::dvec4 texel = linear_lookup(*textures_.averages, 0, sample.place);
    const glm::dvec3 normal = glm::normalize(2.0 * glm::dvec3(texel) - 1.0), turned = turned_by(sample, normal);
    FormSurface surface{texel.w, textures_.metallic_factor,
                        lobes == nullptr ? textures_.colour : lobes->finest_luminance(sample.place, normal)};
    if (textures_.surface != nullptr) surface.metalness *= linear_lookup(*textures_.surface, 0, sample.place).z;
    const FormLight light =
        shaded_normal(glm::normalize(turned), surface, glm::normalize(picture.eye - sample.position));
    for (std::size_t l = 0; l < kFormLights; ++l) sum[l] += light[l] / static_cast<double>(pixel.samples.size());
  }
  return sum;
}

FormLight FormMeter::shade(const Measured& at, const SurfacePoint& point, const Looked& looked, const NormalForm& form,
                           bool has_variance, double part, double colour) const {
  const LevelForm &finer = form.levels[size_of(looked.levels[0])], &coarser = form.levels[size_of(looked.levels[1])];
  const auto mixed = [&](const auto& one, const auto& other) {
    return (1.0 - looked.coarser_share) * one + looked.coarser_share * other;
  };
  const glm::dvec3 turned = turned_by(point, mixed(looked.values[0].normal(finer), looked.values[1].normal(coarser)));
  const double length = glm::length(turned);
  const glm::dvec3 normal = length > 1e-9 ? turned / length : point.normal;
  const double rough = mixed(looked.values[0].roughness(finer), looked.values[1].roughness(coarser));
  const glm::dvec3 along_x = part * (at.picture->to_view * at.pixel->along_x.normal),
                   along_y = part * (at.picture->to_view * at.pixel->along_y.normal);
  const FormSurface surface{
      has_variance ? roughness_of_variance(rough, along_x, along_y) : roughness_of_three(rough, along_x, along_y),
      looked.metal, colour};
  return shaded_normal(normal, surface, glm::normalize(at.picture->eye - point.position));
}

double FormMeter::contribution(const Measured& at, const FormLight& light) {
  double sum = 0.0;
  for (std::size_t l = 0; l < kFormLights; ++l) sum += at.weights[l] * std::abs(light[l] - at.reference[l]);
  return sum;
}

template <typename Shade>
std::vector<double> FormMeter::contributions(const Shade& shade) const {
  std::vector<double> made(pixels_.size());
  for_each_row_band(static_cast<int>(pixels_.size()), kPixelsAtOnce, threads_, [&](int, int begin, int end) {
    for (std::size_t i = size_of(begin); i < size_of(end); ++i) made[i] = contribution(pixels_[i], shade(pixels_[i]));
  });
  return made;
}

FormError FormMeter::errors_of(const std::vector<double>& contributions) const {
  FormError made;
  made.by_distance.resize(distances_.size());
  for (std::size_t i = 0; i < pixels_.size(); ++i) made.by_distance[pixels_[i].distance] += contributions[i];
  for (const double error : made.by_distance) made.mean += error / static_cast<double>(distances_.size());
  return made;
}

FormLight FormMeter::middle_light(const Measured& at, const NormalForm& form) const {
  return shade(at, at.pixel->middle, at.looked[0], form, false, 1.0, textures_.colour);
}

FormError FormMeter::normals(const NormalForm& form) const {
  return errors_of(contributions([&](const Measured& at) { return middle_light(at, form); }));
}

FormLight FormMeter::point_light(const Measured& at, const NormalForm& form, double colour) const {
  constexpr int kPoints = kPointsPerSide * kPointsPerSide;
  FormLight sum{};
  for (int p = 0; p < kPoints; ++p) {
    const SurfacePoint point = moved(*at.pixel, part_place(p % kPointsPerSide, kPointsPerSide),
                                     part_place(p / kPointsPerSide, kPointsPerSide));
    const FormLight light = shade(at, point, at.looked[size_of(1 + p)], form, true, 1.0 / kPointsPerSide, colour);
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
  // Lobes of a part of the pixel, in world space, the map's share in the first.
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
    const glm::dvec3 mean = 2.0 * glm::dvec3(linear_lookup(*textures_.normals, 0, point.place)) - 1.0;
    // multum_movmf_magnified(); level 0 of the map is one finer than the lobes' own.
    const double length = std::max(glm::length(mean), 1e-9);
    const double seen = std::exp2(2.0 * std::min(level + 1.0, 0.5) - 1.0);
    sums[0] += map_share * turned_lobe(point, {mean * ((1.0 - seen + seen * std::min(length, 1.0)) / length), 1.0});
  };
  const double level = lobes.level_of(pixel.along_x.place, pixel.along_y.place, kLobeBias);
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
    const FormSurface surface{std::max(rough, kLobeRoughnessMin), looked.metal, factor * colours.mean};
    const FormLight light = shaded_lobe(lobe / std::max(lobe.w, 1e-6), surface, from);
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
    add_light(sum, 0.25, at.looked[size_of(1 + p)], glm::normalize(at.picture->eye - point.position), 1.0);
  }
  if (!lobes_pay) return made;
  glm::dvec4 sum(0.0);
  for (const glm::dvec4& lobe : all) sum += lobe;
  for (std::size_t j = 0; j < count; ++j)
    if (all[j].w > 1e-6)
      add_light(all[j], all[j].w / sum.w, at.looked[0], view, colours.factors.empty() ? 1.0 : colours.factors[j]);
  return made;
}

FormError FormMeter::lobes(const LobeLevels& lobes, const NormalForm& form) const {
  return errors_of(contributions([&](const Measured& at) {
    return shade_lobes(at, lobes, form, {textures_.colour, {}});
  }));
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
      lights[i].reference = reference_of(*at.picture, *at.pixel, &lobes);
      lights[i].mean = shade_lobes(at, lobes, form, {own.mean, {}});
      lights[i].own = shade_lobes(at, lobes, form, own);
    }
  });
  std::vector<FormLight> wholes(distances_.size());
  for (std::size_t i = 0; i < lights.size(); ++i)
    for (std::size_t l = 0; l < kFormLights; ++l) wholes[pixels_[i].distance][l] += lights[i].reference[l];
  const auto error = [&](FormLight Lights::*light) {
    std::vector<double> found(lights.size(), 0.0);
    for (std::size_t i = 0; i < lights.size(); ++i)
      for (std::size_t l = 0; l < kFormLights; ++l)
        found[i] += 100.0 / kFormLights / std::max(wholes[pixels_[i].distance][l], 1e-12) *
                    std::abs((lights[i].*light)[l] - lights[i].reference[l]);
    return errors_of(found);
  };
  return {error(&Lights::mean), error(&Lights::own)};
}

void FormMeter::improve(NormalForm& form, const std::vector<double>& limits) const {
  constexpr double kShares[] = {0.0, 0.25, 0.5, 0.75, 1.0};
  constexpr int kSweeps = 2;
  std::vector<double> current = contributions([&](const Measured& at) { return middle_light(at, form); });
  std::vector<double> errors = errors_of(current).by_distance;
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (int level = 1; level < level_count(); ++level) {
      const std::vector<std::size_t> touched = pixels_of_level(level);
      if (touched.empty()) continue;
      const LevelForm before = form.levels[size_of(level)];
      LevelForm best = before;
      double best_gain = 0.0;
      std::vector<double> best_values, best_errors;
      for (const bool has_fitted_normals : {false, true})
        for (const double share : kShares) {
          form.levels[size_of(level)] = {has_fitted_normals, share};
          if (form.levels[size_of(level)] == before) continue;
          std::vector<double> values(touched.size());
          for_each_row_band(static_cast<int>(touched.size()), kPixelsAtOnce, threads_, [&](int, int begin, int end) {
            for (std::size_t i = size_of(begin); i < size_of(end); ++i)
              values[i] = contribution(pixels_[touched[i]], middle_light(pixels_[touched[i]], form));
          });
          std::vector<double> changed = errors;
          double gain = 0.0;
          for (std::size_t i = 0; i < touched.size(); ++i) {
            const double less = current[touched[i]] - values[i];
            changed[pixels_[touched[i]].distance] -= less;
            gain += less / static_cast<double>(distances_.size());
          }
          bool is_within = gain > best_gain;
          for (std::size_t d = 0; d < changed.size(); ++d)
            is_within = is_within && changed[d] <= std::max(limits[d], errors[d]);
          if (!is_within) continue;
          best = form.levels[size_of(level)];
          best_gain = gain;
          best_values = std::move(values);
          best_errors = std::move(changed);
        }
      form.levels[size_of(level)] = best;
      if (best_values.empty()) continue;
      for (std::size_t i = 0; i < touched.size(); ++i) current[touched[i]] = best_values[i];
      errors = std::move(best_errors);
    }
}

std::vector<std::size_t> FormMeter::pixels_of_level(int level) const {
  std::vector<std::size_t> made;
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    const Looked& looked = pixels_[i].looked[0];
    if ((looked.levels[0] == level && looked.coarser_share < 1.0) ||
        (looked.levels[1] == level && looked.coarser_share > 0.0))
      made.push_back(i);
  }
  return made;
}

ChosenNormalForm choose_normal_form(const FormMeter& meter) {
  const auto of_all = [&](const LevelForm& form) { return NormalForm::of(meter.level_count(), form); };
  ChosenNormalForm made;
  made.form = of_all({});
  made.plain = made.chosen = meter.normals(made.form);
  made.fitted = meter.normals(of_all({true, 1.0}));
  std::vector<double> limits = made.plain.by_distance;
  for (double& limit : limits) limit += kFormTolerance;
  NormalForm improved = made.form;
  meter.improve(improved, limits);
  const FormError error = meter.normals(improved);
  if (error.mean > made.plain.mean - std::max(kFormGain, kFormGainShare * made.plain.mean)) return made;
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
