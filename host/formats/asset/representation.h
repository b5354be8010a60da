// SPDX-License-Identifier: Apache-2.0
// Lists the representations of the normals under a texel that a baked file may hold. A new one is a row here, one in
// the table of files (baked_file.cpp) and one in that of the bakes (host/bakes/bake/ndf_bake.cpp).
#pragma once

#include <string>
#include <vector>

namespace multum {

enum class Representation {
  kMovmf,    // mixtures of von Mises-Fisher lobes (host/formats/asset/lobes/movmf_mipmap.h)
  kGmm,      // mixtures of planar Gaussians, lobes too (the same file, host/formats/asset/lobes/gmm_quantize.h)
  kMoments,  // first and second moments of slopes, and the mean normal (host/formats/asset/averages/moment_mipmap.h)
  kSh,       // spherical harmonics of the normals, to an order (host/formats/asset/averages/sh_mipmap.h)
};

/// Rounding of stored channel values; docs/FORMAT.md states what each loses.
enum class StorageEncoding {
  kSnorm16,  // multiples of 1/32767 in a float channel: RGBA16_SNORM on the GPU
  kHalf,     // 16-bit floats: RGBA16F on the GPU
  kFloat,    // 32-bit floats: RGBA32F on the GPU
};

/// Is a texel a mixture of lobes?
inline bool holds_lobes(Representation representation) {
  return representation == Representation::kMovmf || representation == Representation::kGmm;
}

const char* storage_encoding_name(StorageEncoding encoding);

struct RepresentationInfo {
  Representation representation;
  const char* option;                      // of --ndf
  const char* name;                        // attribute multum:representation
  int version;                             // attribute multum:formatVersion; of files with materials one higher
  std::vector<StorageEncoding> encodings;  // that suit it, the default first
  const char* help;                        // what it is, in a line
};

/// All representations, the default first.
const std::vector<RepresentationInfo>& representations();
const RepresentationInfo& representation_info(Representation representation);

/// Throws Error(kUsage) for an encoding that does not suit the representation.
void check_encoding(Representation representation, StorageEncoding encoding);

}  // namespace multum
