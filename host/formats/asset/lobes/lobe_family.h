// SPDX-License-Identifier: Apache-2.0
// Table of what families of lobes differ in, as files have them: a family is a row. All have four channels a lobe, the
// last of them its amplitude, all linear in the normals; what the first three are of a normal is the family's to say.
#pragma once

#include <cstddef>

#include <glm/vec3.hpp>

#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

struct LobeFamily {
  // Of normals as points (x, y) of the disc, with a variance, in place of vectors of the sphere: the third channel is
  // E[x^2 + y^2] instead of E[z]. Says which kernels run.
  bool is_planar;
  bool one_lobe_is_mean;  // its normals' average is the best fit of one lobe: it takes no EM
  const char* plural;
  // Names and descriptions in the file (docs/reference/file_format.md).
  const char* layer;
  const char* lobe_text;
  const char* finest_text;
  const char* finest_rough_text;  // with a BRDF's width in
  const char* finest_rough_channel;
  const char* finest_third_name;  // what messages call the third value

  // Rounds rows of a level >= 1 to what is stored.
  void (*quantize)(MovmfLevel& rows, StorageEncoding encoding, int threads);
  // Largest kappa (1/variance) that a lobe of amplitude 1 keeps, and the lobes that are sharper.
  float (*kappa_max)(StorageEncoding encoding);
  SharpLobes (*count_sharp)(const MovmfLevel& level, StorageEncoding encoding, int threads);

  // Level 0, whose texels are single directions. What a normal is there; `is_shortened`: by a BRDF's width.
  glm::vec3 (*finest_of_normal)(const glm::vec3& normal, bool is_shortened);
  // The other way round, of stored values.
  glm::vec3 (*normal_of_finest)(const glm::vec3& stored, bool is_shortened);
  // Rounds unit normals' x and y, and derives the third as readers do.
  void (*quantize_finest)(glm::vec3* normals, std::size_t count, StorageEncoding encoding);
  // The third value of a normal whose x and y have been rounded.
  float (*finest_third)(float x, float y, StorageEncoding encoding);
  bool (*is_single_direction)(const glm::vec3& normal, bool has_roughness);
};

extern const LobeFamily kSphericalLobes;  // von Mises-Fisher (movmf_finest.h, movmf_mipmap.h)
extern const LobeFamily kPlanarLobes;     // Gaussians (gmm_quantize.h)

/// That of a representation of lobes (MULTUM_CHECK).
const LobeFamily& lobe_family(Representation representation);

}  // namespace multum
