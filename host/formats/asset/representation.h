// SPDX-License-Identifier: Apache-2.0
// Lists the representations of the normals under a texel that a baked file may hold. A new one is a name
// (host/foundation/parameters/parameter_choices.h), a row here, and one in each table that a district keeps by
// representation: of bakes (host/bakes/bake/ndf_bake.cpp), of scenes' estimates (host/bakes/scene/map_planner.cpp), of
// what `multum info` says (tools/multum/file_commands.cpp) and of what the viewer reads
// (tools/multum_view/baked_map.cpp). Code asks the row what it has to know, never which representation it is.
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

/// How many lobes a texel has, or to which order harmonics go: of other representations neither is looked at.
struct TexelCounts {
  int lobes = 1;
  int sh_order = 0;
};

struct RepresentationInfo {
  Representation representation;
  const char* option;                      // of --ndf
  const char* name;                        // attribute multum:representation
  int version;                             // attribute multum:formatVersion; of files with materials one higher
  std::vector<StorageEncoding> encodings;  // that suit it, the default first
  const char* help;                        // what it is, in a line
  const char* contents;                    // what a texel holds: "planar Gaussians"
  const LobeFamily* lobes;                 // that a texel is a mixture of (lobes/lobe_family.h); null: it is none
  bool has_kappa;   // of each lobe, by its mean vector's length: GGX over lobes, sharper lobes and exports take it
  bool has_order;   // how many values a texel has is an order's to say (--sh-order)
  bool has_slopes;  // moments of slopes, which several models shade (--moments)
  bool takes_every_brdf;  // else one highlight of one width alone (Tan's), from lights that come from somewhere
  // Textures of four channels that a texel takes, those of colours and weights left out.
  int (*value_textures)(const TexelCounts& counts);
  int (*mean_count)(const TexelCounts& counts);  // numbers that one pass over the map averages, features left out
  // Of a file of it: its header, its findings, and what it takes on a GPU. All throw Error(kInput) for a broken one.
  BakedHeader (*read_header)(const std::string& path);
  std::vector<VerifyFinding> (*verify)(const std::string& path, int threads);
  std::uint64_t (*gpu_bytes)(const std::string& path);
};

/// All representations, the default first.
const std::vector<RepresentationInfo>& representations();
const RepresentationInfo& representation_info(Representation representation);
/// What is baked where nobody says which.
inline Representation default_representation() { return representations().front().representation; }

/// Is a texel a mixture of lobes?
bool holds_lobes(Representation representation);

/// Textures of four channels that a texel takes. `features`: how many of colours and weights it has; of lobes, each has
/// its own.
int texture_count(Representation representation, const TexelCounts& counts, int features);

/// Throws Error(kUsage) for an encoding that does not suit the representation.
void check_encoding(Representation representation, StorageEncoding encoding);

}  // namespace multum
