// SPDX-License-Identifier: Apache-2.0
#include "host/lab/selftest/struct_layout.h"

#include <cstddef>

#include "kernels/shared/filtered_sh.h"
#include "kernels/shared/mip_box.h"
#include "kernels/shared/mip_pyramid.h"
#include "kernels/shared/moments.h"
#include "kernels/shared/movmf_fit.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {

StructLayout struct_layout(Device& device) {
  StructLayout layout;
  layout.host = {sizeof(MultumVmfLobe),
                 offsetof(MultumVmfLobe, amplitude),
                 sizeof(MultumMovmfFit),
                 offsetof(MultumMovmfFit, kappa_cap_slope),
                 offsetof(MultumMovmfFit, total_weight_inverse),
                 sizeof(MultumMipLevel),
                 offsetof(MultumMipLevel, gathers_y),
                 sizeof(MultumTap),
                 offsetof(MultumTap, fraction),
                 sizeof(MultumGather),
                 sizeof(MultumGatherEntry),
                 sizeof(MultumStrip),
                 sizeof(MultumBoxBand),
                 offsetof(MultumBoxBand, column_count),
                 sizeof(MultumBoxLevel),
                 sizeof(MultumBoxTap),
                 sizeof(MultumFilteredMoments),
                 offsetof(MultumFilteredMoments, map_share),
                 sizeof(MultumFilteredSh),
                 offsetof(MultumFilteredSh, share)};
  layout.device.assign(layout.host.size(), -1);
  const DeviceBuffer sizes = device.make_buffer(layout.host.size() * sizeof(int), "sizes");
  device.kernel("probe_numerics", "probe_layout", {4, 1, false})
      .launch({1}, sizes, static_cast<int>(layout.host.size()));
  device.read(sizes, layout.device.data(), layout.device.size() * sizeof(int));
  return layout;
}

}  // namespace multum
