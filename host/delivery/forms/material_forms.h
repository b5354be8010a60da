// SPDX-License-Identifier: Apache-2.0
// Compares the possible forms of a material's normals. Draws the model with each form in the same way as an engine, and
// measures the errors of the pictures. Chooses the cheapest form whose error exceeds the lowest error by at most 0.2
// percentage points.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <string>
#include <vector>

#include "host/delivery/forms/engine_filter.h"
#include "host/delivery/forms/form_shading.h"
#include "host/delivery/forms/lobe_lookups.h"
#include "host/delivery/forms/model_pictures.h"
#include "host/delivery/forms/texture_lookups.h"

namespace multum {

/// The textures of a material, whose levels have the same sizes. Every material has `normals`. All values are shares
/// from 0 to 1.
struct FormTextures {
  const SharesTexture* averages = nullptr;  // mean normals, rounded like a mip of the map; alpha holds the mean
                                            // roughness
  const SharesTexture* normals = nullptr;   // normals of fitted lobes
  const SharesTexture* surface = nullptr;   // green: roughness of fitted lobes; blue: metalness; if null, both are 1
  double metallic_factor = 1.0;
  double colour = 0.5;            // base colour, grey
  bool has_metalness_map = true;  // false if `surface` has the same metalness everywhere in level 0
};

/// One normal and roughness per texel. The normal is averaged or fitted. The roughness includes a share of the
/// roughness that the fit adds.
struct LevelForm {
  bool has_fitted_normals = false;
  double fitted_share = 0.0;  // see mixed_roughness()

  bool is_plain() const { return !has_fitted_normals && fitted_share == 0.0; }
  bool operator==(const LevelForm&) const = default;
};

/// Returns perceptual roughness with a share of the increase of alpha squared that a fit makes.
double mixed_roughness(double plain, double fitted, double share);

/// The forms by level. Level 0 is plain.
struct NormalForm {
  std::vector<LevelForm> levels;

  static NormalForm of(int level_count, const LevelForm& from_level_1) {
    NormalForm made{std::vector<LevelForm>(static_cast<std::size_t>(level_count), from_level_1)};
    made.levels.front() = {};
    return made;
  }
  bool is_plain() const;
  bool has_fitted_normals() const;
};

/// A set of pictures for which one error is stated. They show the material from one distance and, if there is no model,
/// on one simple shape.
struct FormView {
  double distance = 0.0;
  std::string shape;  // ModelPicture::shape

  auto operator<=>(const FormView&) const = default;
};

/// Relative L1 error in percent, by view.
struct FormError {
  std::vector<double> by_view;
  double mean = 0.0;
};

/// The errors of the pictures with directional lights, which choose forms, and of those with bright surroundings.
struct LitErrors {
  FormError suns, surroundings;
};

struct FormMeterSettings {
  Engine engine = Engine::kThree;  // engine of normals() and improve()
  bool has_points = true;          // true if points() and lobes() are needed
  int threads = 1;
  FormSurroundings surroundings = FormSurroundings::kRoom;
};

class FormMeter {
 public:
  /// All arguments must outlive this object.
  FormMeter(const FormTextures& textures, const std::vector<ModelPicture>& pictures, const FormMeterSettings& settings);

  const std::vector<FormView>& views() const { return views_; }  // in ascending order; empty if nothing is visible

  int level_count() const { return textures_.averages->frame().level_count; }

  /// Returns the error if the material is drawn with one evaluation per pixel, as in the engine.
  FormError normals(const NormalForm& form) const;
  LitErrors lit_normals(const NormalForm& form) const;
  /// Changes one level after the other. Each level takes the form that reduces the mean error most while the error of
  /// each view stays below `limits`. Levels coarser than last_seen_level() take the form of that level.
  void improve(NormalForm& form, const std::vector<double>& limits) const;
  /// Returns the error that is due to the sampling of the references. It is estimated from two halves of the samples.
  FormError noise() const;
  LitErrors lit_noise() const;
  /// Returns the error with 2 x 2 points per pixel and the variance of slopes, as in addPoints() of @multum/three.
  FormError points(const NormalForm& form) const;
  /// Returns the error of lobes that addLobes() of @multum/three draws with 4 evaluations and with textures of this
  /// form.
  FormError lobes(const LobeLevels& lobes, const NormalForm& form) const;
  LitErrors lit_lobes(const LobeLevels& lobes, const NormalForm& form) const;
  /// The errors in colour for lobes that have colours, with the texel's mean colour and with each lobe's own colour.
  struct Coloured {
    FormError mean, own;
  };
  Coloured coloured_lobes(const LobeLevels& lobes, const NormalForm& form) const;

 private:
  struct LookedLevel {  // values that a lookup returns, of all textures in one level
    glm::dvec3 averaged{0.0, 0.0, 1.0}, fitted{0.0, 0.0, 1.0};
    double rough = 1.0, fitted_rough = 1.0;

    glm::dvec3 normal(const LevelForm& form) const { return form.has_fitted_normals ? fitted : averaged; }
    double roughness(const LevelForm& form) const;
  };
  struct Looked {
    std::array<int, 2> levels{};
    std::array<LookedLevel, 2> values;
    double coarser_share = 0.0, metal = 1.0;
  };
  struct Measured {
    const ModelPicture* picture;
    const ModelPixel* pixel;
    std::size_t view;  // index into views_
    FormLight reference, noise;
    FormLight weights;  // weights of differences in the error, percent
    FormScene scene;
    std::array<double, kFormSuns> sun_weights{1.0, 1.0, 1.0};
    Looked middle;               // the values at the pixel's middle as the engine reads them
    std::vector<Looked> beside;  // the pixels to the right and below, if this pixel's roughness uses them
    std::vector<Looked> points;  // the values at 2 x 2 points
  };
  // The grey base colours of a pixel.
  struct PixelColours {
    double mean = 0.5;
    std::vector<double> factors = {};  // factors of lobes; 1 if empty
  };
  static PixelColours colours_of(const ModelPixel& pixel, const LobeLevels& lobes);
  struct Bent {  // a normal of some form, in world space
    glm::dvec3 normal{0.0, 0.0, 1.0};
    double roughness = 1.0;
  };
  void prepare(Measured& at, std::size_t number) const;
  Looked look(const SurfacePoint& point, const ModelPixel& pixel, int anisotropy_max, double bias) const;
  // Returns the reference of a pixel. `lobes` contains the colours. If `lobes` is null, all colours are equal.
  struct Reference {
    FormLight light, noise;  // noise: distance of both sample halves from the reference
  };
  Reference reference_of(const ModelPicture& picture, const ModelPixel& pixel, const LobeLevels* lobes,
                         const FormScene& scene) const;
  void light(Measured& at, std::uint64_t seed) const;
  static Bent bent(const SurfacePoint& point, const Looked& looked, const NormalForm& form, const EngineFilter& filter);
  FormLight point_light(const Measured& at, const NormalForm& form, double colour) const;
  FormLight shade_lobes(const Measured& at, const LobeLevels& lobes, const NormalForm& form,
                        const PixelColours& colours) const;
  FormLight middle_light(const Measured& at, const NormalForm& form) const;
  struct LightRange {
    std::size_t begin, end;
  };
  static constexpr LightRange kSunLights{0, kFormSuns}, kSurroundingLights{kFormSuns, kFormLights};
  static double contribution(const Measured& at, const FormLight& light, const LightRange& range);
  template <typename Shade>
  std::vector<double> contributions(const Shade& shade) const;  // under directional lights
  template <typename Shade>
  LitErrors lit_errors(const Shade& shade) const;
  FormError errors_of(const std::vector<double>& contributions) const;
  int last_seen_level() const;  // the coarsest level that several pixels show; coarser levels have the same form
  std::vector<std::size_t> pixels_of_levels(int first, int last) const;

  const FormTextures textures_;
  const EngineFilter& filter_;
  const bool has_points_;
  const int threads_;
  const FormSurroundings surroundings_;
  std::vector<FormView> views_;
  std::vector<Measured> pixels_;
};

/// Returns the form with the lowest mean error that the search finds. In each view, the error of this form exceeds the
/// error of `kept` by at most kFormTolerance. If no form reduces the mean error by at least kFormGain, returns `kept`.
struct ChosenNormalForm {
  NormalForm form;
  FormError plain, fitted, chosen;  // `fitted` has levels 1 and coarser fitted, with the full roughness
};
ChosenNormalForm choose_normal_form(const FormMeter& meter, const NormalForm& kept);

constexpr double kFormGain = 0.2;  // percentage points, or
// The minimum gain as a share of the error. The larger of the two minimum gains applies. These pictures differ from an
// engine's pictures by about this share.
constexpr double kFormGainShare = 0.05;
constexpr double kFormTolerance = 0.1;  // percentage points, for each view

}  // namespace multum
