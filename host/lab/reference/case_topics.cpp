// SPDX-License-Identifier: Apache-2.0
#include "host/lab/reference/case_topics.h"

namespace multum {
namespace {

std::vector<CaseTopic> fit_topics() {
  return {
      {"kappa is at its upper limit or near 0",
       {"kappa-to-the-cap", "kappa-of-sharp-lobes", "kappa-of-mean-length-12-decades", "log-peak-to-the-cap",
        "shading-kappa-12-decades", "vmf-normaliser-12-decades", "vmf-spread-12-decades", "glsl-kappa-12-decades",
        "glsl-vmf-normaliser-12-decades", "glsl-eighth-zonal-of-every-kappa"}},
      {"all normals are equal, or all starting lobes are equal",
       {"all-normals-equal-and-all-lobes", "planar-one-two-three-points", "planar-scatter-of-equal-normals",
        "choice-of-equal-normals", "mirrors-of-one-normal", "HardCaseTest.AllNormalsEqual"}},
      {"the normals of a texel form two opposite tilts with equal shares",
       {"opposite-normals-of-one-lobe", "slopes-along-a-line", "glsl-slopes-along-a-line",
        "harmonics-of-opposite-tilts", "glsl-harmonics-of-opposite-tilts", "slopes-along-one-line",
        "HardCaseTest.TwoOppositeTilts"}},
      {"normals are on the equator or below it",
       {"the-equator-and-below", "planar-variance-at-the-rim", "slopes-at-the-horizon", "facets-behind-the-mean-normal",
        "glsl-normals-straight-away", "glsl-planar-means-beyond-the-rim", "HardCaseTest.NormalsOverTheWholeSphere"}},
      {"lobes contain no normals, or have amplitudes near 0 after filtering",
       {"lobes-that-die", "planar-lobes-that-die", "a-dead-lobe-takes-nothing", "planar-caps-of-narrow-texels",
        "amplitude-to-0", "planar-amplitude-to-0", "moments-of-no-share", "glsl-amplitude-to-0",
        "glsl-planar-amplitude-to-0", "HardCaseTest.ALobeOfOneNormalInThousands"}},
      {"a texel has fewer normals than lobes, for example one, two or three normals",
       {"one-two-three-normals", "planar-one-two-three-points", "choice-without-normals",
        "HardCaseTest.MapsOfOneTwoAndThreeTexels"}},
      {"normals are not unit vectors, and can have any length or be zero, infinite or NaN",
       {"normals-of-any-length", "a-bad-texel-stays-alone", "any-normal-gets-a-lobe", "starts-from-degenerate-lobes",
        "shortened-normals-to-0", "shortened-normals-as-points", "mean-normals-of-every-length",
        "harmonics-of-vectors-not-unit", "harmonics-of-no-direction", "normals-of-nothing-in-a-lobe",
        "glsl-mean-normals-of-every-length", "glsl-longer-than-its-amplitude"}},
      {"maps are one texel wide or have odd sizes, texel borders cut finest texels, or texels have no samples",
       {"strips-and-odd-sizes", "texels-keep-their-bits", "features-keep-their-bits", "colours-of-uneven-chunks",
        "uneven-cells-side-by-side", "axes-of-no-extent", "odd-pyramids-of-great-contrast", "parts-without-texels",
        "blocks-beyond-borders", "lines-shorter-than-filters"}},
      {"sums run over very many texels, up to 2^28 and more",
       {"texels-2-to-28-by-chunks", "sums-of-65536-partial-sums", "colours-of-65536-partial-sums",
        "texels-2-to-28-into-cells", "means-of-sums-to-2-to-58", "blocks-of-32768-texels", "average-of-2-30-texels",
        "thousands-of-normals-a-texel", "parts-beyond-2-to-31"}},
      {"every density is 0 in float, so the shares of the lobes are 0 divided by 0",
       {"far-from-every-lobe", "planar-far-from-every-lobe", "colours-far-from-every-lobe",
        "colours-of-uneven-chunks"}},
      {"inputs contain denormal numbers, signed zeros, and very large or very small weights",
       {"denormals-and-signed-zeros", "weights-from-tiny-to-huge", "texels-keep-their-bits", "blocks-of-32768-texels",
        "steps-along-the-old-direction", "denormal-diagonals", "exp2-far-below-its-range"}},
      {"rounding or filtering makes variances negative",
       {"planar-variance-never-negative", "planar-filtered-variance-below-0", "slope-variance-below-0",
        "steep-slopes-under-sharp-highlights", "glsl-planar-filtered-variance-below-0", "glsl-slope-variance-below-0",
        "glsl-steep-slopes-under-sharp-highlights"}},
  };
}

std::vector<CaseTopic> shading_topics() {
  return {
      {"16-bit files store lobes with limited accuracy: 16-bit floats represent kappa only up to 1000, and the lobes "
       "of a texel share one range of 16-bit integers",
       {"half-single-directions", "half-sharpest-spreads", "snorm16-single-directions", "snorm16-sharpest-spreads",
        "planar-variance-in-half", "planar-variance-in-snorm16"}},
      {"exponents up to 1e5",
       {"exponents-to-1e5", "log-of-one-minus-e", "highlights-narrower-than-texels", "glsl-exponents-to-1e5",
        "glsl-log-of-one-minus-e"}},
      {"harmonics have orders up to 20, are evaluated at the poles, or form a truncated series",
       {"harmonics-to-order-20", "harmonics-at-the-poles", "harmonics-ring-below-0", "glsl-harmonics-ring-below-0",
        "glsl-environment-harmonics-of-no-light"}},
      {"light and view directions are at, below or along the horizon",
       {"the-horizon-and-below", "half-vectors-at-the-horizon", "light-from-behind", "glsl-the-horizon-and-below",
        "glsl-half-vectors-at-the-horizon", "glsl-smith-at-grazing-angles", "glsl-grooves-at-grazing-angles",
        "glsl-irradiance-behind-the-light"}},
      {"the light is exactly opposite to the view, or lies on the surface itself",
       {"glsl-light-straight-behind", "glsl-a-sample-straight-behind", "glsl-a-light-on-the-surface",
        "glsl-single-normals-as-lobes"}},
      {"directions are undefined, for example the mean of opposite normals, a view along a lobe, a tangent along the "
       "normal, or the poles of an environment",
       {"no-direction", "highlight-cosines-of-every-width", "a-lobe-of-no-direction", "a-lobe-of-opposite-normals",
        "axes-of-round-lobes", "directions-of-short-means", "glsl-no-direction", "glsl-environment-seen-along-the-lobe",
        "glsl-tangents-along-the-normal", "glsl-environment-at-its-poles", "glsl-visibility-of-opposite-half-vectors",
        "HardCaseTest.OppositeNormalsOnTheEquatorWithOneLobe"}},
      {"coordinates are at or beyond the ends of tables, levels and maps",
       {"glsl-measured-tables-at-their-ends", "glsl-reflection-table-at-its-ends",
        "glsl-environment-levels-at-their-ends", "glsl-schlick-beyond-its-ends", "glsl-level-of-no-extent",
        "glsl-texels-far-outside", "glsl-footprints-of-one-place"}},
      {"materials have no lobes or no mean normal",
       {"glsl-single-normals-as-gaussians", "glsl-single-normals-as-means", "glsl-lobes-in-an-environment",
        "glsl-means-in-an-environment", "glsl-harmonics-in-an-environment"}},
      {"texture inference gets singular systems, empty rows, texels that no pixel reads, regularisation near 0, or a "
       "contrast of 1e6",
       {"singular-systems", "empty-and-uneven-rows", "unseen-texels", "regularisation-to-0", "contrast-of-1e6"}},
      {"block compression gets values at the limits, blocks of one value, or indices whose highest bit is not stored",
       {"values-at-the-limits", "one-value-in-all-texels", "one-colour-in-all-texels",
        "indices-without-their-highest-bit"}},
      {"a driver relaxes floating-point rules or uses a different struct layout",
       {"driver-keeps-nan", "driver-lays-structs-out-alike"}},
  };
}

}  // namespace

const std::vector<CaseTopic>& case_topics() {
  static const std::vector<CaseTopic> topics = [] {
    std::vector<CaseTopic> all = fit_topics();
    for (CaseTopic& topic : shading_topics()) all.push_back(std::move(topic));
    return all;
  }();
  return topics;
}

}  // namespace multum
