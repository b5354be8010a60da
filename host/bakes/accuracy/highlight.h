// SPDX-License-Identifier: Apache-2.0
// Describes a BRDF whose highlights errors are measured for: f of n . h alone, without what depends on other angles
// (Fresnel, shadowing), as the reference takes it and as the shading kernels do. Coloured f are taken grey, by their
// mean.
#pragma once

#include "host/bakes/accuracy/accuracy_brdf.h"
#include "host/formats/brdf/brdf.h"
#include "kernels/shared/highlight.h"

namespace multum {

struct Highlight {
  AccuracyBrdf id;  // what errors of it are stated as; not kLambert
  Brdf brdf;        // the same, as it is shaded
  MultumHighlight shaded;
};
/// Takes 10 to 100 ms for GGX and measurements, which are fitted: made once, and handed on.
Highlight make_highlight(const AccuracyBrdf& id, const Brdf& brdf);

Highlight blinn_phong_highlight(double exponent);

/// The mean of f's channels at e = 1 - n.h.
double grey_density(const Brdf& brdf, double e);

/// The highlight as the kernels shade it: Blinn-Phong exactly, others as the runtime does (runtime_gl/shaders/brdf).
MultumHighlight shaded_highlight(const Brdf& brdf);
MultumHighlight shaded_highlight(double exponent);

}  // namespace multum
