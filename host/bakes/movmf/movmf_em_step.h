// SPDX-License-Identifier: Apache-2.0
// Runs one step of a fit on the device: fits some texels of one level, independent of one another, from their starts to
// their lobes (Han et al. 2007, section 7). movmf_level_fit.h says which texels and in which order.
#pragma once

#include <vector>

#include "host/bakes/movmf/bake_settings.h"
#include "host/bakes/movmf/mip_schedule.h"
#include "host/bakes/pyramid/row_window.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// The rows of a level that are on the device, as MultumMovmfFit says: where a step finds and leaves things. Windows
/// that a method does not need are empty.
struct StepWindows {
  RowWindow parent;                      // lobes of the next coarser level; empty where fit.parent_width is 0
  RowWindow lobes;                       // of the level
  RowWindow refined;                     // the same, refined; empty where they are not
  RowWindow alignment_vectors;           // of the level: what its lobes tell their neighbours
  RowWindow features;                    // of the level, [rgb_plane][lobe]
  MapWindows* map = nullptr;             // normals and features that the level covers: kTexels, kChunks
  RowWindow binned, binned_counts;       // kBinned: samples, and their numbers
  std::vector<RowWindow> binned_planes;  // the samples' features, by threes
  bool wants_features = false;           // of this step
};

class MovmfEmStep {
 public:
  MovmfEmStep(Device& device, const MovmfSettings& settings, bool weighted);
  ~MovmfEmStep();
  MovmfEmStep(const MovmfEmStep&) = delete;
  MovmfEmStep& operator=(const MovmfEmStep&) = delete;

  /// Programs that run() needs for the levels of `schedule`, finest levels first.
  std::vector<ProgramChoice> programs(const MipSchedule& schedule, bool has_features) const;
  /// Queues the fit of the texels (places in the window, as step_texels() gives them). kChunks passes over the map once
  /// an iteration, in bands of what `normals` holds at most. Throws Cancelled.
  void run(FitMethod method, MultumMovmfFit fit, std::vector<int> texels, StepWindows& windows, Progress* progress);
  /// Queues the refinement of the lobes of texels that are fitted, as are those beside them, into the window of refined
  /// ones (movmf_refine.cl); lobes stay as they are, so that it does not matter which of them are. kTexels and kBinned.
  /// Throws Cancelled.
  void refine(FitMethod method, MultumMovmfFit fit, std::vector<int> texels, StepWindows& windows, Progress* progress);
  /// Waits until all that is queued is done. Throws Cancelled.
  void finish(Progress* progress);

 private:
  std::size_t lobe_count() const { return static_cast<std::size_t>(settings_.lobe_count); }
  Kernel& lazy_kernel(Kernel& kernel, const char* file, const char* name, const KernelVariant& variant);
  void upload_texels(MultumMovmfFit& fit, std::vector<int> texels, Progress* progress);
  void choose(const MultumMovmfFit& fit, StepWindows& windows);
  void start_em(const MultumMovmfFit& fit, StepWindows& windows);
  void pack(FitMethod method, const MultumMovmfFit& fit, const StepWindows& windows);
  void pack_texels(const MultumMovmfFit& fit, const StepWindows& windows);
  void pack_binned(const MultumMovmfFit& fit, const StepWindows& windows);
  // EM of samples that are packed first: by a work-item a texel, or by a team.
  void fit_packed(FitMethod method, const MultumMovmfFit& fit, StepWindows& windows);
  void run_chunks(MultumMovmfFit fit, std::size_t texel_count, StepWindows& windows, Progress* progress);
  void fit_features(FitMethod method, const MultumMovmfFit& fit, std::size_t texel_count, StepWindows& windows);
  void fit_rgb_plane(FitMethod method, MultumMovmfFit fit, std::size_t texel_count, StepWindows& windows,
                     std::size_t rgb_plane);

  Device& device_;
  const MovmfSettings settings_;
  KernelVariant scalar_, fast_, binned_;
  KernelVariant starting_, packing_;  // no more than these kernels depend on: fewer programs
  Kernel choose_kernel_, feature_chosen_kernel_;
  Kernel start_kernel_, pack_kernel_, em_texels_kernel_, em_team_kernel_;
  Kernel refine_kernel_, refine_binned_kernel_;
  Kernel binned_pack_kernel_, em_binned_kernel_, em_binned_team_kernel_;
  Kernel em_partial_kernel_, cap_kernel_, mstep_kernel_;
  Kernel feature_partial_kernel_, feature_sum_kernel_, feature_binned_kernel_;
  std::vector<std::vector<int>> lists_;  // of queued steps, from which the device still reads
  DeviceBuffer list_, chosen_, start_, samples_, sample_counts_, feature_samples_, partial_;
};

/// Bytes of the buffers that run() needs for so many texels, about.
std::uint64_t em_step_bytes(const LevelSchedule& level, const MovmfSettings& settings, bool has_features,
                            std::uint64_t texel_count);

}  // namespace multum
