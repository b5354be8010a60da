// SPDX-License-Identifier: Apache-2.0
// Estimates the error of lobes before any bake: mixtures of 0, 1, 2, ... lobes fitted to the normals under the surveyed
// texels, each texel by itself, and shaded as the runtime does, against those normals shaded one by one. Alignment and
// filtering are not in it: an estimate for choosing, at texel centres.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "host/bakes/scene/map_survey.h"

namespace multum {

/// How texels are shaded: max(n . l, 0), or normalised facets of this exponent (Blinn-Phong's; other families by the
/// one that is as wide).
struct ShadedBy {
  std::optional<double> exponent;  // unset: Lambert; infinite: as wide as the normals are shortened
  int weight = -1;                 // times this one of the map's weights; -1: whole
};

/// Sharper highlights are estimated as if of this exponent, or of a lower one where a texel's normals are a sample that
/// is spread wide: a few half vectors and normals do not resolve them.
constexpr double kEstimatedExponentMax = 200.0;

enum class ColourModel {
  kNone,   // the map has none, or they are not looked at
  kLobes,  // each lobe its own
  kMean,   // the texel's mean, for all lobes
};

struct LobeErrorSettings {
  int first_level = 1;         // finer ones are not looked at
  bool has_roughness = false;  // normals are shortened by it, by `mean_cosine` in the mean: not of Lambert's light
  double mean_cosine = 1.0;
  int threads = 1;
};

/// max(n . l, 0) of a vMF lobe of mean vector r, as runtime_gl/shaders/common/movmf_shading.glsl has it.
double lobe_lambert(const glm::dvec3& r, const glm::dvec3& light);

/// Relative L1, sum |model - reference| / sum reference over texels and directions, of each level, all alike, of the
/// worst of `shadings`. `lobe_count` 0: the mean normal's direction, as if nothing were under the texel.
class LobeErrors {
 public:
  /// `survey` must outlive it.
  LobeErrors(const MapSurvey& survey, const LobeErrorSettings& settings);

  double error(int lobe_count, const std::vector<ShadedBy>& shadings, ColourModel colours);
  /// The same of planar Gaussians over (n_x, n_y), Tan's lobes, of as many.
  double gmm_error(int lobe_count, const std::vector<ShadedBy>& shadings, ColourModel colours);
  /// The same of spherical harmonics to an order, and of one Gaussian of slopes (LEAN, with the Jacobian).
  double sh_error(int order, const std::vector<ShadedBy>& shadings, ColourModel colours) const;
  double lean_error(const std::vector<ShadedBy>& shadings, ColourModel colours) const;
  /// What part of the colours' variance within texels lies between lobes, less what chance gives: 0..1.
  double colour_correlation(int lobe_count);
  /// What part of the lobes of surveyed texels is sharper than `kappa`, single directions left out.
  double share_sharper(int lobe_count, double kappa);

 private:
  struct TexelFit {
    std::vector<MixtureLobe> lobes;
    std::vector<glm::dvec3> colours;  // mean colour of each
    std::vector<glm::dvec4> weights;  // mean weights of each
    std::vector<glm::dvec3> planar;   // means of n_x, of n_y, and of the sum of their squares
    glm::dvec3 mean_colour{0.0};
    double colour_within = 0.0, colour_between = 0.0;  // parts of the colours' variance
  };
  // Of a texel, a shading and a direction: what a representation makes of it, colours in.
  using Model = std::function<glm::dvec3(std::size_t texel, const ShadedBy& by, const glm::dvec3& direction)>;
  double error_of(const Model& model, const std::vector<ShadedBy>& given, ColourModel colours) const;
  const std::vector<TexelFit>& fits(int lobe_count);
  // Means of a fit's lobes over the normals that they share.
  void add_means(const SurveyedTexel& texel, TexelFit& fit) const;
  double lobes_error(int lobe_count, bool planar, const std::vector<ShadedBy>& shadings, ColourModel colours);
  TexelFit fit(const SurveyedTexel& texel, int lobe_count, const std::vector<MixtureLobe>& top) const;
  // Of the coarsest texel, the best of many starts.
  std::vector<MixtureLobe> fit_top(int lobe_count) const;

  const MapSurvey& survey_;
  const LobeErrorSettings settings_;
  const double copies_;                      // of shortened normals, in EM
  std::vector<double> exponent_max_;         // [texel] the sharpest highlight that its normals resolve
  std::vector<std::vector<TexelFit>> fits_;  // [lobe_count][texel], where asked for
};

}  // namespace multum
