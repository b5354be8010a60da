// SPDX-License-Identifier: Apache-2.0
// One step of a fit on the device: some texels of one level, independent of one another, from their starts to their
// lobes (Han et al. 2007, section 7). movmf_fit.h says in which order.
#pragma once

#include <optional>
#include <vector>

#include "host/bake/bake_settings.h"
#include "host/bake/mip_schedule.h"
#include "host/base/progress.h"
#include "host/image/colour_map.h"
#include "host/image/normal_map.h"
#include "host/opencl/device.h"

namespace multum {

/// Three planes of a map on the device, with MULTUM_GROUP zeros behind the last texel for reads past a row's end.
struct DevicePlanes {
  std::vector<float> host[3];
  DeviceBuffer buffer[3];

  DevicePlanes(Device& device, const std::vector<float>& a, const std::vector<float>& b, const std::vector<float>& c,
               const char* what);
};

class MovmfEmStep {
 public:
  /// Holds copies of the maps; `schedule` must outlive it.
  MovmfEmStep(Device& device, const NormalMap& map, const ColourMap* albedo, const MovmfSettings& settings,
              const MipSchedule& schedule);

  /// Before the steps of a level: uploads its texel list, condenses its normals where that is the method.
  void begin_level(const LevelSchedule& level);
  /// Fits one step's texels into `lobes` [lobe][texel]. `parent`: the next coarser level's; anything where
  /// fit.parent_width is 0. An empty `colours` buffer: none are wanted. Throws Cancelled.
  void run(FitMethod method, MultumMovmfFit fit, const FitStep& step, const DeviceBuffer& parent, DeviceBuffer& lobes,
           DeviceBuffer& colours, Progress* progress);

  const DevicePlanes& normals() const { return normals_; }

 private:
  std::size_t lobe_count() const { return static_cast<std::size_t>(settings_.lobe_count); }
  void make_kernels();
  void make_buffers();
  void condense(MultumMovmfFit fit, const FitStep& step, const DevicePlanes& values, DeviceBuffer& samples);
  void run_chunks(const MultumMovmfFit& fit, const FitStep& step, DeviceBuffer& lobes, Progress* progress);
  void fit_colours(FitMethod method, MultumMovmfFit fit, const FitStep& step, DeviceBuffer& colours);

  Device& device_;
  const MovmfSettings settings_;
  const MipSchedule& schedule_;
  DevicePlanes normals_;
  std::optional<DevicePlanes> albedo_;
  int vector_width_ = 1;
  Kernel start_kernel_, pack_kernel_, em_texels_kernel_, em_condensed_kernel_;
  Kernel axes_kernel_, cells_kernel_, condense_pack_kernel_;
  Kernel em_partial_kernel_, mstep_kernel_;
  Kernel feature_partial_kernel_, feature_sum_kernel_, feature_condensed_kernel_;
  DeviceBuffer list_buffer_, start_buffer_, sample_buffer_, sample_count_buffer_, partial_buffer_;
  DeviceBuffer axis_buffer_, cell_buffer_, colour_sample_buffer_;
};

}  // namespace multum
