// SPDX-License-Identifier: Apache-2.0
// Reads a baked file for an export. The finest level of the file contains the normal map. The highlights of the file's
// lobes are compared with the highlights of the exported lobes.
#pragma once

#include <string>
#include <vector>

#include <glm/vec4.hpp>

#include "host/delivery/export/accuracy/cell_reference.h"
#include "host/delivery/export/accuracy/lobe_shading.h"
#include "host/formats/asset/baked_file.h"
#include "host/formats/asset/lobes/movmf_reader.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/foundation/base/files/spill_policy.h"
#include "host/foundation/base/progress.h"
#include "host/foundation/base/size_of.h"

namespace multum {

/// Returns whether the file name marks a baked file: NAME.ndf.exr.
bool is_baked_name(const std::string& path);

/// Returns the normals in level 0 of a baked file. They equal the map's normals to 16 bits, or exactly if the file
/// stores floats. Throws Error(kInput) if the file has no lobes or no level 0, or if the lengths of its normals include
/// roughness.
NormalMapRows read_baked_normals(const std::string& path, const SpillPolicy& spill, Progress* progress);

/// Reads the lobes of single texels.
class BakedLobes {
 public:
  /// Throws Error(kInput) if the file has no vMF lobes, if its lobes include roughness, or if one of `levels` is
  /// missing.
  BakedLobes(const std::string& path, const std::vector<int>& levels);

  int width() const { return reader_.header().width(); }
  int height() const { return reader_.header().height(); }
  std::string surface() const { return baked_surface(reader_.header().header); }
  /// Returns the SHA-256 hash of the map file that was baked.
  const std::string& source_hash() const { return reader_.header().header.provenance.file_hash(); }
  int count() const { return reader_.header().lobe_count(); }
  /// Returns a name such as "4 baked lobes".
  std::string name() const;
  /// Returns all texels of a stored level.
  MovmfLevel level(int level) { return reader_.read_level(level, 0, reader_.header().levels[size_of(level)].height); }
  /// Returns (a r, a) of each lobe. Call this function from one thread at a time.
  std::vector<glm::dvec4> texel(int level, int x, int y);

 private:
  MovmfReader reader_;
};

/// Computes D V (n . l) of a texel's lobes for each light, as renderers draw them
/// (host/formats/brdf/ggx_lobe_specular.h).
void lobe_highlights(const LightSet& lights, const std::vector<glm::dvec4>& lobes, double alpha,
                     std::vector<double>& values);

}  // namespace multum
