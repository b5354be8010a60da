// SPDX-License-Identifier: Apache-2.0
// Estimates the time of a bake by a model with few constants (docs/evidence/SCENE.md lists them and the machine on
// which they were measured). The model is meant for comparing ways to bake a map and does not predict exact times.
#pragma once

#include <cstdint>

#include "host/formats/asset/representation.h"

namespace multum {

/// Properties of one map's bake that determine its cost.
struct BakeShape {
  int width = 1, height = 1;
  Representation representation = Representation::kMovmf;
  int lobe_count = 4;  // number of lobes, for representations with lobes
  int sh_order = 4;    // order of spherical harmonics
  StorageEncoding encoding = StorageEncoding::kSnorm16;
  int first_level = 0;
  bool has_colours = false;   // true if the baked file has colours, per lobe or per texel
  bool mean_colours = false;  // true if the mean colours of all levels are in a separate file
  int weight_count = 0;
  int exponent_count = 3;  // number of highlights whose error is measured
};

struct BakeCost {
  double ms = 0.0;
  double bytes = 0.0;  // size of the textures

  BakeCost& operator+=(const BakeCost& other) {
    ms += other.ms;
    bytes += other.bytes;
    return *this;
  }
  BakeCost operator-(const BakeCost& other) const { return {ms - other.ms, bytes - other.bytes}; }
};

BakeCost bake_cost(const BakeShape& shape);

/// Returns the number of four-channel textures that are read per texel.
int texture_count(const BakeShape& shape);

}  // namespace multum
