// SPDX-License-Identifier: Apache-2.0
// Estimates the error of lobes before a bake. Fits mixtures of 0, 1, 2, ... lobes to the normals that each surveyed
// texel covers, and shades them in the same way as the runtime. The reference shades the same normals one by one. The
// estimate is used to choose settings. It ignores alignment and filtering, so it applies to texel centres.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "host/bakes/scene/map_survey.h"

namespace multum {

/// The shading of texels, which is max(n . l, 0), or normalised facets with this Blinn-Phong exponent. Other families
/// of BRDFs use the exponent of a Blinn-Phong of equal width.
struct ShadedBy {
  std::optional<double> exponent;  // nullopt means Lambert; infinity means that the width is given by the lengths of
                                   // the shortened normals
  int weight = -1;                 // index of the map's weight that multiplies the shading; -1 if there is none
};

/// The largest exponent that is used for estimates. Sharper highlights are estimated with this exponent. If the sampled
/// normals of a texel are widely spread, the exponent is even lower, because a few half vectors and normals do not
/// resolve sharp highlights.
constexpr double kEstimatedExponentMax = 200.0;

enum class ColourModel {
  kNone,   // the map has no colours, or they are ignored
  kLobes,  // one colour per lobe
  kMean,   // the texel's mean colour for all lobes
};

struct LobeErrorSettings {
  int first_level = 1;         // the finest level that is used
  bool has_roughness = false;  // true if roughness shortens normals, to a mean length of `mean_cosine`; Lambert ignores
                               // roughness
  double mean_cosine = 1.0;
  int threads = 1;
};

/// Returns the mean of max(n . l, 0) over a vMF lobe with mean vector r, as in
/// runtime_gl/shaders/common/movmf_shading.glsl.
double lobe_lambert(const glm::dvec3& r, const glm::dvec3& light);

/// Estimates the relative L1 error, sum |model - reference| / sum reference over texels and directions, for the worst
/// of `shadings`. Levels have equal weights. If `lobe_count` is 0, uses only the direction of the mean normal and no
/// spread.
class LobeErrors {
 public:
  /// `survey` must outlive the object.
  LobeErrors(const MapSurvey& survey, const LobeErrorSettings& settings);

  double error(int lobe_count, const std::vector<ShadedBy>& shadings, ColourModel colours);
  /// Estimates the error of planar Gaussians over (n_x, n_y), as in Tan et al. 2005.
  double gmm_error(int lobe_count, const std::vector<ShadedBy>& shadings, ColourModel colours);
  /// Estimates the errors of spherical harmonics up to an order, and of one Gaussian of slopes (LEAN, with the
  /// Jacobian).
  double sh_error(int order, const std::vector<ShadedBy>& shadings, ColourModel colours) const;
  double lean_error(const std::vector<ShadedBy>& shadings, ColourModel colours) const;
  /// Returns the share, 0..1, of the variance of colours within texels that differences between lobes explain. The
  /// share that is due to chance is subtracted.
  double colour_correlation(int lobe_count);
  /// Returns the share of the surveyed texels' lobes that are sharper than `kappa`. Lobes with a single direction are
  /// not counted.
  double share_sharper(int lobe_count, double kappa);

 private:
  struct TexelFit {
    std::vector<MixtureLobe> lobes;
    std::vector<glm::dvec3> colours;  // mean colour of each lobe
    std::vector<glm::dvec4> weights;  // mean weights of each lobe
    std::vector<glm::dvec3> planar;   // means of n_x, n_y and n_x^2 + n_y^2
    glm::dvec3 mean_colour{0.0};
    double colour_within = 0.0, colour_between = 0.0;  // parts of the colours' variance
  };
  // Returns the value of a representation for a texel, a shading and a direction, including colours.
  using Model = std::function<glm::dvec3(std::size_t texel, const ShadedBy& by, const glm::dvec3& direction)>;
  double error_of(const Model& model, const std::vector<ShadedBy>& given, ColourModel colours) const;
  const std::vector<TexelFit>& fits(int lobe_count);
  // Adds the means over the normals of each fitted lobe.
  void add_means(const SurveyedTexel& texel, TexelFit& fit) const;
  double lobes_error(int lobe_count, bool planar, const std::vector<ShadedBy>& shadings, ColourModel colours);
  TexelFit fit(const SurveyedTexel& texel, int lobe_count, const std::vector<MixtureLobe>& top) const;
  // Fits the coarsest texel from many starts and returns the best fit.
  std::vector<MixtureLobe> fit_top(int lobe_count) const;

  const MapSurvey& survey_;
  const LobeErrorSettings settings_;
  const double copies_;                      // number of copies of each shortened normal in EM
  std::vector<double> exponent_max_;         // [texel]: the sharpest highlight that its normals resolve
  std::vector<std::vector<TexelFit>> fits_;  // [lobe_count][texel], if requested
};

}  // namespace multum
