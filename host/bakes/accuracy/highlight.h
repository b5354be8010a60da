// SPDX-License-Identifier: Apache-2.0
// Describes a BRDF whose highlights are measured. The measurement includes only the factor f, which depends on n . h,
// and excludes factors that depend on other angles (Fresnel, shadowing). The reference and the shading kernels evaluate
// the same f. A coloured f is replaced by the mean of its channels.
#pragma once

#include "host/bakes/accuracy/accuracy_brdf.h"
#include "host/formats/brdf/brdf.h"
#include "kernels/shared/highlight.h"

namespace multum {

struct Highlight {
  AccuracyBrdf id;  // name of the BRDF in stated errors; must not be kLambert
  Brdf brdf;        // the BRDF that is shaded
  MultumHighlight shaded;
};
/// Makes a highlight. Callers should make it once and share it, because fitting GGX or a measured BRDF takes 10 to 100
/// ms.
Highlight make_highlight(const AccuracyBrdf& id, const Brdf& brdf);

Highlight blinn_phong_highlight(double exponent);

/// Returns the mean of f's channels at e = 1 - n.h.
double grey_density(const Brdf& brdf, double e);

/// Converts the highlight to the form that kernels shade: exactly for Blinn-Phong, and as in the runtime for other
/// BRDFs (runtime_gl/shaders/brdf).
MultumHighlight shaded_highlight(const Brdf& brdf);
MultumHighlight shaded_highlight(double exponent);

}  // namespace multum
