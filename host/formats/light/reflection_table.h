// SPDX-License-Identifier: Apache-2.0
// Tabulates how much light a lobe of normals reflects where it is the same from everywhere (the "split sum" of Karis
// 2013, with the lobe as one more dimension): a lobe n ~ vMF(mu, d), facets h ~ vMF(n, term), l = reflect(v, h), each
// with the weight 4 (v.h) F(v.h) V max(n.l, 0).
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/brdf/brdf.h"

namespace multum {

constexpr int kReflectionCosineCount = 32;  // mu.v, evenly from -1 to 1
constexpr int kReflectionSpreadCount = 24;  // d = 1 - |r|: (i / (count - 1))^3

struct ReflectionEntry {
  glm::dvec3 weight;  // the integral
  double plain;       // the integral of 4 (v.h) (v.h) alone
  double fresnel;     // the mean over cosine-weighted light of (1 - v.h)^5: for the 1 - F of the diffuse part
};

/// One table a term of vmf_terms(brdf): entry [spread][cosine], row by row.
std::vector<std::vector<ReflectionEntry>> reflection_tables(const Brdf& brdf);

}  // namespace multum
