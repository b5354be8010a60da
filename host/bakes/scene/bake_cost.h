// SPDX-License-Identifier: Apache-2.0
// Estimates what a bake will take, by a model of few constants (docs/evidence/SCENE.md has them and the machine that
// they are of): for comparing ways to bake a map, not for promises.
#pragma once

#include <cstdint>

#include "host/formats/asset/representation.h"

namespace multum {

/// One map's bake, as far as it costs anything.
struct BakeShape {
  int width = 1, height = 1;
  Representation representation = Representation::kMovmf;
  int lobe_count = 4;  // of representations of lobes
  int sh_order = 4;    // of those with an order
  StorageEncoding encoding = StorageEncoding::kSnorm16;
  int first_level = 0;
  bool has_colours = false;   // in the baked file: of each lobe, or one a texel
  bool mean_colours = false;  // in a file of their own, all levels
  int weight_count = 0;
  int exponent_count = 3;  // of highlights whose error is measured
};

struct BakeCost {
  double ms = 0.0;
  double bytes = 0.0;  // of textures

  BakeCost& operator+=(const BakeCost& other) {
    ms += other.ms;
    bytes += other.bytes;
    return *this;
  }
  BakeCost operator-(const BakeCost& other) const { return {ms - other.ms, bytes - other.bytes}; }
};

BakeCost bake_cost(const BakeShape& shape);

/// Textures of four channels that a texel takes.
int texture_count(const BakeShape& shape);

}  // namespace multum
