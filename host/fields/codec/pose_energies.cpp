// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/pose_energies.h"

#include <algorithm>

namespace multum {
namespace {

std::vector<float> factors_of_blocks(const CoefficientLayout& layout, const std::vector<float>& masses) {
  return layout.coder == ImageCoder::kDct ? partly_seen_factors(layout, masses) : std::vector<float>();
}

}  // namespace

std::vector<std::size_t> poses_to_measure(const std::vector<std::vector<float>>& cell_masses) {
  constexpr float kNearly = 0.5f;
  std::vector<float> most(cell_masses.at(0).size());
  for (const std::vector<float>& masses : cell_masses)
    for (std::size_t c = 0; c < most.size(); ++c) most[c] = std::max(most[c], masses[c]);
  std::vector<bool> is_served(most.size());
  std::vector<std::size_t> chosen;
  while (true) {  // finds the pose that shows the most of the cells that no chosen pose shows well; chooses this pose
    std::size_t best = 0;
    float gain = 0.0f;
    for (std::size_t p = 0; p < cell_masses.size(); ++p) {
      float sum = 0.0f;
      for (std::size_t c = 0; c < most.size(); ++c)
        if (!is_served[c] && cell_masses[p][c] >= kNearly * most[c]) sum += cell_masses[p][c];
      if (sum <= gain) continue;
      gain = sum;
      best = p;
    }
    if (gain <= 0.0f) break;
    chosen.push_back(best);
    for (std::size_t c = 0; c < most.size(); ++c)
      if (cell_masses[best][c] >= kNearly * most[c]) is_served[c] = true;
  }
  if (chosen.empty()) chosen.push_back(0);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

void PoseEnergies::set_measured(std::size_t pose, const CoefficientLayout& layout, std::vector<float> energies,
                                const std::vector<float>& masses) {
  poses_[pose] = {std::move(energies), {}, cell_sums(layout.width, masses), factors_of_blocks(layout, masses)};
}

void PoseEnergies::set_like(std::size_t pose, const CoefficientLayout& layout, std::vector<std::size_t> measured,
                            const std::vector<float>& masses) {
  poses_[pose] = {{}, std::move(measured), cell_sums(layout.width, masses), factors_of_blocks(layout, masses)};
}

std::vector<float> PoseEnergies::of(std::size_t pose, const std::vector<std::uint32_t>& cells) const {
  const Pose& own = poses_[pose];
  if (own.measured.empty()) return own.energies;
  struct Source {
    const Pose* pose = nullptr;
    float factor = 0.0f;
  };
  std::vector<Source> of_cell(own.cell_masses.size());
  for (std::size_t c = 0; c < of_cell.size(); ++c) {
    float most = 0.0f;
    for (const std::size_t m : own.measured)
      if (poses_[m].cell_masses[c] > most) {
        most = poses_[m].cell_masses[c];
        of_cell[c] = {&poses_[m], own.cell_masses[c] / most};
      }
  }
  const std::size_t blocks = own.block_factors.size(), size = blocks > 0 ? cells.size() / blocks : 1;
  std::vector<float> energies(cells.size());
  for (std::size_t j = 0; j < energies.size(); ++j) {
    const Source& source = of_cell[cells[j]];
    if (source.pose == nullptr) continue;
    energies[j] = source.factor * source.pose->energies[j];
    if (blocks > 0) energies[j] *= own.block_factors[j / size] / source.pose->block_factors[j / size];
  }
  return energies;
}

std::uint64_t PoseEnergies::bytes() const {
  std::uint64_t values = 0;
  for (const Pose& pose : poses_) values += pose.energies.size() + pose.cell_masses.size() + pose.block_factors.size();
  return values * sizeof(float);
}

}  // namespace multum
