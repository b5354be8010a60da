// SPDX-License-Identifier: Apache-2.0
// The table of the families of lobes. Each family is one row. Every lobe has four channels, which are linear in the
// normals. The last channel is the amplitude, and the family defines the first three.
#pragma once

#include <cstddef>

#include <glm/vec3.hpp>

#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

struct LobeFamily {
  // True for Gaussians over points (x, y) of the disc instead of lobes on the sphere. The third channel is E[x^2 + y^2]
  // instead of E[z]. This flag selects the kernels.
  bool is_planar;
  bool one_lobe_is_mean;  // true if the average of the normals is the best fit of one lobe, so that EM is not needed
  const char* plural;
  // The names and descriptions that are stored in the file (docs/reference/file_format.md).
  const char* layer;
  const char* lobe_text;
  const char* finest_text;
  const char* finest_rough_text;  // text for files that include the width of a BRDF
  const char* finest_rough_channel;
  const char* finest_third_name;  // name of the third value, for messages

  // Rounds rows of a level >= 1 to stored values.
  void (*quantize)(MovmfLevel& rows, StorageEncoding encoding, int threads);
  // Return the largest kappa (1/variance) that a lobe of amplitude 1 keeps, and the number of lobes that are sharper.
  float (*kappa_max)(StorageEncoding encoding);
  SharpLobes (*count_sharp)(const MovmfLevel& level, StorageEncoding encoding, int threads);

  // Converts a normal to a stored value of level 0, where every texel is a single direction. `is_shortened` is true if
  // the length of the normal includes the width of a BRDF.
  glm::vec3 (*finest_of_normal)(const glm::vec3& normal, bool is_shortened);
  // Converts a stored value of level 0 to a normal.
  glm::vec3 (*normal_of_finest)(const glm::vec3& stored, bool is_shortened);
  // Rounds x and y of unit normals, and computes the third value from them, as readers do.
  void (*quantize_finest)(glm::vec3* normals, std::size_t count, StorageEncoding encoding);
  // Returns the third value of a normal whose x and y are already rounded.
  float (*finest_third)(float x, float y, StorageEncoding encoding);
  bool (*is_single_direction)(const glm::vec3& normal, bool has_roughness);
};

extern const LobeFamily kSphericalLobes;  // von Mises-Fisher (movmf_finest.h, movmf_mipmap.h)
extern const LobeFamily kPlanarLobes;     // Gaussians (gmm_quantize.h)

/// Returns the family of a representation of lobes. MULTUM_CHECKs that `representation` has lobes.
const LobeFamily& lobe_family(Representation representation);

}  // namespace multum
