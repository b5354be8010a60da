// SPDX-License-Identifier: Apache-2.0
#include "host/bake/highlight.h"

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/brdf/facet_distribution.h"
#include "host/brdf/vmf_terms.h"

namespace multum {
namespace {

static_assert(MULTUM_HIGHLIGHT_TERMS == kBrdfTermCountMax);

double mean_of(const glm::dvec3& channels) { return (channels.x + channels.y + channels.z) / 3.0; }

}  // namespace

std::string blinn_phong_name(double exponent) { return fmt::format("blinn-phong:{}", exponent); }

Highlight blinn_phong_highlight(double exponent) {
  Highlight highlight{blinn_phong_name(exponent), {}};
  highlight.brdf.exponent = static_cast<float>(exponent);
  return highlight;
}

double grey_density(const Brdf& brdf, double e) { return mean_of(facet_density(brdf, e)); }

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
  shaded.total = static_cast<float>(mean_of(facet_total(brdf)));
  for (const VmfTerm& term : vmf_terms(brdf)) {
    shaded.weights[shaded.term_count] = static_cast<float>(mean_of(term.weight));
    shaded.spreads[shaded.term_count++] = static_cast<float>(term.spread);
  }
  return shaded;
}

}  // namespace multum
