// SPDX-License-Identifier: Apache-2.0
// Probes the arithmetic of a device and its driver, for tests and for users who suspect an error in the driver.

#include "device/vmf_shading.clh"
#include "shared/filtered_sh.h"
#include "shared/mip_box.h"
#include "shared/mip_pyramid.h"
#include "shared/moments.h"
#include "shared/movmf_fit.h"
#include "shared/vmf_lobe.h"

#if MULTUM_VECTOR_WIDTH != 1
#error "probe_numerics has only a scalar variant"
#endif

#define PROBE_EXP2 0
#define PROBE_LOG2 1
#define PROBE_KAPPA 2          // kappa for a mean vector of length 1 - x
#define PROBE_ISNAN 3          // 1 if isnan() detects a NaN; 0 under relaxed mathematics
#define PROBE_LOG_PEAK 4       // log2 of the peak of a lobe with kappa x
#define PROBE_ONE_MINUS_LOG 5  // log2(1 - e)
#define PROBE_SHADING_KAPPA 6  // kappa for q = 1 - A, by shading's formula
#define PROBE_VMF_PEAK 7       // peak of the vMF density with kappa x
#define PROBE_VMF_SPREAD 8     // 1 - A(kappa)

static float probed(float x, int function) {
  switch (function) {
    case PROBE_EXP2: return exp2_v(x);
    case PROBE_LOG2: return log2_v(x);
    case PROBE_KAPPA: return kappa_of_mean_length(1.0f - x, x);
    case PROBE_ISNAN: return isnan(x) ? 1.0f : 0.0f;
    case PROBE_LOG_PEAK: return log_peak(1.0f, x);
    case PROBE_ONE_MINUS_LOG: return log2_one_minus(x);
    case PROBE_SHADING_KAPPA: return shading_kappa(x);
    case PROBE_VMF_PEAK: return vmf_shape(x).peak;
    default: return vmf_spread(x);
  }
}

// One work-item handles one input. The global size is count. values[i] = function(inputs[i]).
__kernel void probe_functions(__global const float* inputs, __global float* values, int count, int function) {
  const int i = (int)get_global_id(0);
  if (i >= count) return;
  values[i] = probed(inputs[i], function);
}

// One work-item handles one highlight. The global size is count.
//   lobes [count]         (a r, a)
//   half_vectors [count]  unit; w: the kappa of the facets
//   lights [count]        unit, towards the light
//   values [count]        written: highlight_cosine()
// The kernel is compute bound.
__kernel void probe_highlight_cosine(__global const float4* lobes, __global const float4* half_vectors,
                                     __global const float4* lights, __global float* values, int count) {
  const int i = (int)get_global_id(0);
  if (i >= count) return;
  values[i] = highlight_cosine(lobes[i], half_vectors[i].xyz, lights[i].xyz, half_vectors[i].w);
}

// Writes the sizes that the device gives to the structs that it shares with the host. There is only one work-item.
__kernel void probe_layout(__global int* sizes, int count) {
  if (get_global_id(0) != 0) return;
  MultumMovmfFit fit;
  MultumVmfLobe lobe;
  MultumMipLevel level;
  MultumTap tap;
  MultumBoxBand band;
  MultumFilteredMoments moments;
  MultumFilteredSh harmonics;
  const int layout[] = {(int)sizeof(MultumVmfLobe),
                        (int)((char*)&lobe.amplitude - (char*)&lobe),
                        (int)sizeof(MultumMovmfFit),
                        (int)((char*)&fit.kappa_cap_slope - (char*)&fit),
                        (int)((char*)&fit.total_weight_inverse - (char*)&fit),
                        (int)sizeof(MultumMipLevel),
                        (int)((char*)&level.gathers_y - (char*)&level),
                        (int)sizeof(MultumTap),
                        (int)((char*)&tap.fraction - (char*)&tap),
                        (int)sizeof(MultumGather),
                        (int)sizeof(MultumGatherEntry),
                        (int)sizeof(MultumStrip),
                        (int)sizeof(MultumBoxBand),
                        (int)((char*)&band.column_count - (char*)&band),
                        (int)sizeof(MultumBoxLevel),
                        (int)sizeof(MultumBoxTap),
                        (int)sizeof(MultumFilteredMoments),
                        (int)((char*)&moments.map_share - (char*)&moments),
                        (int)sizeof(MultumFilteredSh),
                        (int)((char*)&harmonics.share - (char*)&harmonics)};
  const int known = (int)(sizeof(layout) / sizeof(layout[0]));
  for (int i = 0; i < count; ++i) sizes[i] = i < known ? layout[i] : -1;
}
