// SPDX-License-Identifier: Apache-2.0
// Keeps what errors of an object's coefficients weigh in each of its poses. Where something moves before an object, it
// has as many poses as the field has samples, most of which differ in what is hidden alone: those are not measured, but
// have what measured poses like them have, by how much of each cell of texels they see.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/fields/codec/drawn_weights.h"

namespace multum {

/// Some of several poses that see an object from the same place, such that every cell of texels is seen by one of them
/// nearly as well as by any. `cell_masses`: [pose][cell], cell_sums of texel_masses. Indices into it, ascending.
std::vector<std::size_t> poses_to_measure(const std::vector<std::vector<float>>& cell_masses);

class PoseEnergies {
 public:
  PoseEnergies() = default;
  explicit PoseEnergies(std::size_t pose_count) : poses_(pose_count) {}

  /// `energies`: of coefficient_energies, of textures of the layout's size; `masses`: texel_masses.
  void set_measured(std::size_t pose, const CoefficientLayout& layout, std::vector<float> energies,
                    const std::vector<float>& masses);

  /// Energies of those of the `measured` poses that see most of each cell, times what the cell weighs in this pose over
  /// what it weighs in that one, and grown by what this one hides of each block. All have textures of the same size and
  /// coordinates.
  void set_like(std::size_t pose, const CoefficientLayout& layout, std::vector<std::size_t> measured,
                const std::vector<float>& masses);

  /// Of each coefficient of a pose that was set, as those are that it is like; `cells`: of the layout's coefficients.
  std::vector<float> of(std::size_t pose, const std::vector<std::uint32_t>& cells) const;

  /// What is kept.
  std::uint64_t bytes() const;

 private:
  struct Pose {
    std::vector<float> energies;        // of a measured pose; else
    std::vector<std::size_t> measured;  // poses that it is like
    std::vector<float> cell_masses;
    std::vector<float> block_factors;  // partly_seen_factors; of wavelets none
  };

  std::vector<Pose> poses_;
};

}  // namespace multum
