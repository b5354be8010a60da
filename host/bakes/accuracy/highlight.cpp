// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/highlight.h"

#include "host/formats/brdf/facet_distribution.h"
#include "host/formats/brdf/vmf_terms.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

static_assert(MULTUM_HIGHLIGHT_TERMS == kBrdfTermCountMax);

}  // namespace

Highlight blinn_phong_highlight(double exponent) {
  Brdf brdf;
  brdf.exponent = static_cast<float>(exponent);
  return make_highlight(AccuracyBrdf::blinn_phong(exponent), brdf);
}

Highlight make_highlight(const AccuracyBrdf& id, const Brdf& brdf) { return {id, brdf, shaded_highlight(brdf)}; }

double grey_density(const Brdf& brdf, double e) { return mean_channel(facet_density(brdf, e)); }

MultumHighlight shaded_highlight(double exponent) {
  MultumHighlight shaded{};
  shaded.exponent = static_cast<float>(exponent);
  shaded.total = 1.0f;
  return shaded;
}

MultumHighlight shaded_highlight(const Brdf& brdf) {
  MULTUM_CHECK(brdf.kind != BrdfKind::kLambert);
  MultumHighlight shaded = shaded_highlight(equivalent_exponent(brdf));
  if (brdf.kind == BrdfKind::kBlinnPhong) return shaded;
  shaded.total = static_cast<float>(mean_channel(facet_total(brdf)));
  for (const VmfTerm& term : vmf_terms(brdf)) {
    shaded.weights[shaded.term_count] = static_cast<float>(mean_channel(term.weight));
    shaded.spreads[shaded.term_count++] = static_cast<float>(term.spread);
  }
  return shaded;
}

}  // namespace multum
