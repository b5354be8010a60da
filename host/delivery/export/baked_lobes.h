// SPDX-License-Identifier: Apache-2.0
// A baked file beside an export: the normal map that its finest level holds, and the highlight of its lobes, which one
// lobe a texel is compared with.
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

/// Is it a baked file by its name, NAME.ndf.exr?
bool is_baked_name(const std::string& path);

/// The normals of a baked file's level 0, which are the map's to 16 bits, or whole in files of floats. Throws
/// Error(kInput) for a file without lobes or without level 0, or with roughness in its normals' lengths.
NormalMapRows read_baked_normals(const std::string& path, const SpillPolicy& spill, Progress* progress);

/// Lobes of single texels.
class BakedLobes {
 public:
  /// Throws Error(kInput) for a file that has no vMF lobes, has roughness in them, or lacks a level of `levels`.
  BakedLobes(const std::string& path, const std::vector<int>& levels);

  int width() const { return reader_.header().width(); }
  int height() const { return reader_.header().height(); }
  std::string surface() const { return baked_surface(reader_.header().header); }
  /// SHA-256 of the map's file that was baked.
  const std::string& source_hash() const { return reader_.header().header.provenance.file_hash(); }
  int count() const { return reader_.header().lobe_count(); }
  /// "4 baked lobes".
  std::string name() const;
  /// All texels of a level that the file has.
  MovmfLevel level(int level) { return reader_.read_level(level, 0, reader_.header().levels[size_of(level)].height); }
  /// (a r, a), one a lobe. From one thread at a time.
  std::vector<glm::dvec4> texel(int level, int x, int y);

 private:
  MovmfReader reader_;
};

/// D V (n . l) of a texel's lobes as renderers draw them (host/formats/brdf/ggx_lobe_specular.h), light by light.
void lobe_highlights(const LightSet& lights, const std::vector<glm::dvec4>& lobes, double alpha,
                     std::vector<double>& values);

}  // namespace multum
