// SPDX-License-Identifier: Apache-2.0
// Tabulates the light that a lobe of normals reflects under uniform light (the "split sum" of Karis 2013, with the lobe
// as one more dimension). For each sample, a normal n ~ vMF(mu, d) is drawn from the lobe, and a facet h ~ vMF(n, term)
// is drawn around it. Then l = reflect(v, h). The weight of a sample is 4 (v.h) F(v.h) V max(n.l, 0).
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/brdf/brdf.h"

namespace multum {

constexpr int kReflectionCosineCount = 32;  // number of values of mu.v, evenly spaced from -1 to 1
constexpr int kReflectionSpreadCount = 24;  // number of values of d = 1 - |r|: (i / (count - 1))^3

struct ReflectionEntry {
  glm::dvec3 weight;  // integral of the weights
  double plain;       // integral of only 4 (v.h) (v.h)
  double fresnel;     // mean of (1 - v.h)^5 over cosine-weighted light, for the factor 1 - F of the diffuse part
};

/// Returns one table for each term of vmf_terms(brdf). The entries of a table are [spread][cosine], row by row.
std::vector<std::vector<ReflectionEntry>> reflection_tables(const Brdf& brdf);

}  // namespace multum
