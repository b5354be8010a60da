// SPDX-License-Identifier: Apache-2.0
// Lists the representations of normals that a baked file can hold. Code should use this table instead of testing for
// particular representations. A new representation needs a name (host/foundation/parameters/parameter_choices.h), a row
// here, and a row in each of the other tables. These are the tables of bakes (host/bakes/bake/ndf_bake.cpp), estimates
// (host/bakes/scene/map_planner.cpp), `multum info` (tools/multum/file_commands.cpp) and the viewer
// (tools/multum_view/baked_map.cpp).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

const char* storage_encoding_name(StorageEncoding encoding);

struct BakedHeader;
struct LobeFamily;
struct VerifyFinding;

/// The number of lobes per texel, and the order of harmonics. Representations without lobes or harmonics ignore both.
struct TexelCounts {
  int lobes = 1;
  int sh_order = 0;
};

struct RepresentationInfo {
  Representation representation;
  const char* option;                      // value of --ndf
  const char* name;                        // value of attribute multum:representation
  int version;                             // value of attribute multum:formatVersion; one higher for files with
                                           // materials
  std::vector<StorageEncoding> encodings;  // allowed encodings, the default first
  const char* help;                        // description in one line
  const char* contents;                    // contents of a texel, such as "planar Gaussians"
  const LobeFamily* lobes;                 // the family of lobes (lobes/lobe_family.h); null if there are no lobes
  bool has_kappa;                          // true if the length of a mean vector gives the kappa of its lobe, which GGX
                                           // and exports need
  bool has_order;                          // true if an order sets the number of values per texel (--sh-order)
  bool has_slopes;                         // true for moments of slopes, which several models shade (--moments)
  bool takes_every_brdf;                   // false if it can be shaded only with Tan's highlight of one width, under
                                           // directional light
  // Returns the number of four-channel textures, not counting textures for colours and weights.
  int (*value_textures)(const TexelCounts& counts);
  int (*mean_count)(const TexelCounts& counts);  // returns the number of values that a pass over the map averages,
                                                 // without features
  // Return the header, the findings and the GPU bytes of a file. All three throw Error(kInput) for a broken file.
  BakedHeader (*read_header)(const std::string& path);
  std::vector<VerifyFinding> (*verify)(const std::string& path, int threads);
  std::uint64_t (*gpu_bytes)(const std::string& path);
};

/// Returns all representations, the default first.
const std::vector<RepresentationInfo>& representations();
const RepresentationInfo& representation_info(Representation representation);
/// The representation that bakes use if none is given.
inline Representation default_representation() { return representations().front().representation; }

/// Returns whether texels are mixtures of lobes.
bool holds_lobes(Representation representation);

/// Returns the number of four-channel textures. `features` is the number of features (colours, weights). Each lobe has
/// its own features.
int texture_count(Representation representation, const TexelCounts& counts, int features);

/// Throws Error(kUsage) if the representation does not allow the encoding.
void check_encoding(Representation representation, StorageEncoding encoding);

}  // namespace multum
