// SPDX-License-Identifier: Apache-2.0
// The forms that a material's normals can have in a model, and their errors in pictures of the model as engines draw
// them. The cheapest form whose error is within a fifth of a point of the least is chosen.
#pragma once

#include <array>
#include <compare>
#include <string>
#include <vector>

#include "host/delivery/forms/engine_filter.h"
#include "host/delivery/forms/form_shading.h"
#include "host/delivery/forms/lobe_lookups.h"
#include "host/delivery/forms/model_pictures.h"
#include "host/delivery/forms/texture_lookups.h"

namespace multum {

/// Levels of one size. All have `normals` + roughness or the surface's channels as shares.
struct FormTextures {
  const SharesTexture* averages = nullptr;  // mean normals, rounded as a mip of the map has them; alpha: mean roughness
  const SharesTexture* normals = nullptr;   // of fitted lobes
  const SharesTexture* surface = nullptr;   // green: their roughness; blue: metalness. Null: both are 1
  double metallic_factor = 1.0;
  double colour = 0.5;  // of the base, grey
};

/// One normal and roughness a texel: the normal averaged or fitted, roughness by a share of what normals add.
struct LevelForm {
  bool has_fitted_normals = false;
  double fitted_share = 0.0;  // mixed_roughness()

  bool is_plain() const { return !has_fitted_normals && fitted_share == 0.0; }
  bool operator==(const LevelForm&) const = default;
};

/// Perceptual roughness with a share of what a fit adds to the square of alpha.
double mixed_roughness(double plain, double fitted, double share);

/// By level; level 0 is plain.
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

/// Pictures whose error is one number: of one distance, and of one of the simple shapes where there is no model.
struct FormView {
  double distance = 0.0;
  std::string shape;  // ModelPicture::shape

  auto operator<=>(const FormView&) const = default;
};

/// Relative L1 error, in per cent, by view.
struct FormError {
  std::vector<double> by_view;
  double mean = 0.0;
};

struct FormMeterSettings {
  Engine engine = Engine::kThree;  // of normals() and improve()
  bool has_points = true;          // points() and lobes() are asked for
  int threads = 1;
};

class FormMeter {
 public:
  /// All that it is given must outlive it.
  FormMeter(const FormTextures& textures, const std::vector<ModelPicture>& pictures, const FormMeterSettings& settings);

  const std::vector<FormView>& views() const { return views_; }  // ascending; empty: nothing is seen

  int level_count() const { return textures_.averages->frame().level_count; }

  /// As the engine draws it, once a pixel.
  FormError normals(const NormalForm& form) const;
  /// Changes one level after the other to what lowers the mean of errors most, as long as no view's error is above
  /// `limits`. Levels that are too coarse for all but a few pixels are one with the last before them.
  void improve(NormalForm& form, const std::vector<double>& limits) const;
  /// The share of the errors that comes from the references' own samples, by their halves.
  FormError noise() const;
  /// At 2 x 2 points of each pixel, with the variance of slopes: addPoints() of @multum/three.
  FormError points(const NormalForm& form) const;
  /// As addLobes() of @multum/three draws them with 4 evaluations, beside textures of this form.
  FormError lobes(const LobeLevels& lobes, const NormalForm& form) const;
  /// The same in colour, of lobes that have colours: all have their texel's, or each its own.
  struct Coloured {
    FormError mean, own;
  };
  Coloured coloured_lobes(const LobeLevels& lobes, const NormalForm& form) const;

 private:
  struct LookedLevel {  // values of all textures in one level
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
    std::size_t view;  // in views_
    FormLight reference, noise;
    FormLight weights;           // of differences from it in the error, per cent
    Looked middle;               // as the engine sees it
    std::vector<Looked> beside;  // a pixel to the right, and one below, where its roughness depends on them
    std::vector<Looked> points;  // at 2 x 2 points
  };
  // Base colours of a pixel, grey.
  struct PixelColours {
    double mean = 0.5;
    std::vector<double> factors = {};  // of lobes; empty: 1
  };
  static PixelColours colours_of(const ModelPixel& pixel, const LobeLevels& lobes);
  struct Bent {  // a normal of a form, in world space
    glm::dvec3 normal{0.0, 0.0, 1.0};
    double roughness = 1.0;
  };
  void prepare(Measured& at) const;
  Looked look(const SurfacePoint& point, const ModelPixel& pixel, int anisotropy_max, double bias) const;
  // `lobes`: has the colours; null: they are all one.
  struct Reference {
    FormLight light, noise;  // how far its samples' halves are from it
  };
  Reference reference_of(const ModelPicture& picture, const ModelPixel& pixel, const LobeLevels* lobes) const;
  static Bent bent(const SurfacePoint& point, const Looked& looked, const NormalForm& form, const EngineFilter& filter);
  FormLight point_light(const Measured& at, const NormalForm& form, double colour) const;
  FormLight shade_lobes(const Measured& at, const LobeLevels& lobes, const NormalForm& form,
                        const PixelColours& colours) const;
  FormLight middle_light(const Measured& at, const NormalForm& form) const;
  static double contribution(const Measured& at, const FormLight& light);
  template <typename Shade>
  std::vector<double> contributions(const Shade& shade) const;
  FormError errors_of(const std::vector<double>& contributions) const;
  int last_seen_level() const;  // the coarsest that some pixels are of; those beyond are one with it
  std::vector<std::size_t> pixels_of_levels(int first, int last) const;

  const FormTextures textures_;
  const EngineFilter& filter_;
  const bool has_points_;
  const int threads_;
  std::vector<FormView> views_;
  std::vector<Measured> pixels_;
};

/// The form of least mean error that is found, among those that are in no view more than kFormTolerance worse than
/// `kept`; that one where none is better by kFormGain.
struct ChosenNormalForm {
  NormalForm form;
  FormError plain, fitted, chosen;  // fitted: all levels from 1 on, with all of the roughness
};
ChosenNormalForm choose_normal_form(const FormMeter& meter, const NormalForm& kept);

constexpr double kFormGain = 0.2;        // points, or
constexpr double kFormGainShare = 0.05;  // of the error, whichever is more: pictures are that much unlike an engine's
constexpr double kFormTolerance = 0.1;   // points, of any view

}  // namespace multum
