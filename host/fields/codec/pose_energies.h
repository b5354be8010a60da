// SPDX-License-Identifier: Apache-2.0
// Holds the error weights of an object's coefficients in each of its poses. If something moves in front of an object,
// the object has as many poses as the field has samples, and most of these poses differ only in occlusion. Such poses
// are not measured. Instead, they get the energies of similar measured poses, scaled by the visible part of each cell
// of texels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/fields/codec/drawn_weights.h"

namespace multum {

/// Chooses some of the poses in which an object is seen from the same place. At least one chosen pose shows each cell
/// of texels nearly as well as the best of all poses. `cell_masses`, [pose][cell], are the cell_sums() of
/// texel_masses(). Returns the indices of the chosen poses in ascending order.
std::vector<std::size_t> poses_to_measure(const std::vector<std::vector<float>>& cell_masses);

class PoseEnergies {
 public:
  PoseEnergies() = default;
  explicit PoseEnergies(std::size_t pose_count) : poses_(pose_count) {}

  /// `energies` come from coefficient_energies() for textures of the layout's size, and `masses` come from
  /// texel_masses().
  void set_measured(std::size_t pose, const CoefficientLayout& layout, std::vector<float> energies,
                    const std::vector<float>& masses);

  /// Sets the energies of a pose from similar `measured` poses. Each cell uses the energies of the measured pose that
  /// shows most of the cell. These energies are scaled by the ratio of the cell's weights in both poses, and raised for
  /// the hidden part of each block. All poses have textures of the same size and coordinates.
  void set_like(std::size_t pose, const CoefficientLayout& layout, std::vector<std::size_t> measured,
                const std::vector<float>& masses);

  /// Returns the energies of the coefficients in a pose that was set. `cells` has the cell of each coefficient of the
  /// layout.
  std::vector<float> of(std::size_t pose, const std::vector<std::uint32_t>& cells) const;

  /// Returns the memory in bytes.
  std::uint64_t bytes() const;

 private:
  struct Pose {
    std::vector<float> energies;        // empty unless the pose is measured
    std::vector<std::size_t> measured;  // the similar measured poses, if the pose is not measured
    std::vector<float> cell_masses;
    std::vector<float> block_factors;  // result of partly_seen_factors(); empty for wavelets
  };

  std::vector<Pose> poses_;
};

}  // namespace multum
