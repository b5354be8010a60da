// SPDX-License-Identifier: Apache-2.0
// Provides the filter matrices of an animation, one per pose and object. A separate process, multum-view, measures them
// and stores them as files. An existing matrix for the same geometry, pose, mapping and sampler is reused.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/fields/inference/pipeline/parameterized_scene.h"
#include "host/fields/inferred/filter_matrix.h"
#include "host/foundation/base/progress.h"

namespace multum {

using ObjectMappings = std::vector<std::vector<TextureMapping>>;  // [object of the job][block]; width 0 means not
                                                                  // visible

struct ProbeSettings {
  std::string viewer;            // path of multum-view
  std::string context = "auto";  // OpenGL context of multum-view
  std::string folder;            // folder of the matrices
  int threads = 0;
  bool has_mips = true;     // if false, bilinear filtering of level 0 only
  int supersampling = 0;    // 0 means as in the job
  double anisotropy = 0.0;  // anisotropy of all objects; 0 means the job's value for each object
};

class AnimationProbe {
 public:
  AnimationProbe(const ParameterizedScene& field, ObjectMappings mappings, ProbeSettings settings);

  /// Measures the missing matrices. Throws Error(kEnvironment) with the program's output if the program cannot be
  /// started or crashes.
  void run(Progress* progress);
  /// Returns the matrix of one pose. `object` is an index into the job's objects.
  FilterMatrix matrix(int pose, std::size_t object) const;
  /// Returns the key that identifies the matrix.
  std::string key(int pose, std::size_t object) const;

  const std::string& geometry_hash() const { return geometry_hash_; }  // SHA-256
  const TextureMapping& mapping(std::size_t object, int block) const {
    return mappings_[object][static_cast<std::size_t>(block)];
  }
  bool is_seen(std::size_t object, int block) const { return mapping(object, block).width > 0; }
  /// Returns the units of progress that run() counts.
  std::uint64_t unit_count() const;

  int measured = 0;  // number of matrices that run() measured

 private:
  std::uint64_t unit_count(int pose) const;
  std::string path(int pose, std::size_t object) const;
  const TextureMapping& mapping_at(int pose, std::size_t object) const;
  int supersampling() const;
  double anisotropy(std::size_t object) const;
  bool is_there(int pose, std::size_t object) const;
  void measure(int pose, const std::vector<std::size_t>& objects, Progress* progress) const;

  const ParameterizedScene& field_;
  ObjectMappings mappings_;
  ProbeSettings settings_;
  std::string geometry_hash_;
};

}  // namespace multum
