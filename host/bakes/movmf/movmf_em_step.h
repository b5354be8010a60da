// SPDX-License-Identifier: Apache-2.0
// Runs one step of a fit on the device. Fits some mutually independent texels of one level, beginning with their
// initial lobes (Han et al. 2007, section 7). movmf_level_fit.h chooses the texels and their order.
#pragma once

#include <vector>

#include "host/bakes/movmf/bake_settings.h"
#include "host/bakes/movmf/mip_schedule.h"
#include "host/bakes/pyramid/row_window.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// The inputs and outputs of a step, which are rows of a level on the device at the positions that MultumMovmfFit
/// states. A window that the method does not need is empty.
struct StepWindows {
  RowWindow parent;                      // lobes of the next coarser level; empty if fit.parent_width is 0
  RowWindow lobes;                       // lobes of the level
  RowWindow refined;                     // refined lobes; empty if the level is not refined
  RowWindow alignment_vectors;           // vectors of the level that neighbours read for alignment
  RowWindow features;                    // features of the level, [rgb_plane][lobe]
  MapWindows* map = nullptr;             // for kTexels and kChunks: normals and features that the level covers
  RowWindow binned, binned_counts;       // for kBinned: samples and their numbers
  std::vector<RowWindow> binned_planes;  // features of the samples, in triples
  bool wants_features = false;           // true if this step writes features
};

class MovmfEmStep {
 public:
  MovmfEmStep(Device& device, const MovmfSettings& settings, bool weighted);
  ~MovmfEmStep();
  MovmfEmStep(const MovmfEmStep&) = delete;
  MovmfEmStep& operator=(const MovmfEmStep&) = delete;

  /// Programs that run() needs for the levels of `schedule`. Programs for the finest levels come first.
  std::vector<ProgramChoice> programs(const MipSchedule& schedule, bool has_features) const;
  /// Queues the fit of the texels (positions in the window, from step_texels()). kChunks reads the map once per
  /// iteration, in bands that fit into `normals`. Throws Cancelled.
  void run(FitMethod method, MultumMovmfFit fit, std::vector<int> texels, StepWindows& windows, Progress* progress);
  /// Queues the refinement of texels that are fitted, and whose neighbours are fitted, into the window of refined lobes
  /// (movmf_refine.cl). The fitted lobes do not change, so the order of texels does not matter. Applies to kTexels and
  /// kBinned. Throws Cancelled.
  void refine(FitMethod method, MultumMovmfFit fit, std::vector<int> texels, StepWindows& windows, Progress* progress);
  /// Waits until all queued work is done. Throws Cancelled.
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
  // EM on packed samples, by one work-item or by a team per texel.
  void fit_packed(FitMethod method, const MultumMovmfFit& fit, StepWindows& windows);
  void run_chunks(MultumMovmfFit fit, std::size_t texel_count, StepWindows& windows, Progress* progress);
  void fit_features(FitMethod method, const MultumMovmfFit& fit, std::size_t texel_count, StepWindows& windows);
  void fit_rgb_plane(FitMethod method, MultumMovmfFit fit, std::size_t texel_count, StepWindows& windows,
                     std::size_t rgb_plane);

  Device& device_;
  const MovmfSettings settings_;
  KernelVariant scalar_, fast_, binned_;
  KernelVariant starting_, packing_;  // only with the options that these kernels use, so that fewer programs are built
  Kernel choose_kernel_, feature_chosen_kernel_;
  Kernel start_kernel_, pack_kernel_, em_texels_kernel_, em_team_kernel_;
  Kernel refine_kernel_, refine_binned_kernel_;
  Kernel binned_pack_kernel_, em_binned_kernel_, em_binned_team_kernel_;
  Kernel em_partial_kernel_, cap_kernel_, mstep_kernel_;
  Kernel feature_partial_kernel_, feature_sum_kernel_, feature_binned_kernel_;
  std::vector<std::vector<int>> lists_;  // texels of queued steps, which the device still reads
  DeviceBuffer list_, chosen_, start_, samples_, sample_counts_, feature_samples_, partial_;
};

/// Returns the approximate number of bytes in the buffers that run() needs for this number of texels.
std::uint64_t em_step_bytes(const LevelSchedule& level, const MovmfSettings& settings, bool has_features,
                            std::uint64_t texel_count);

}  // namespace multum
