// SPDX-License-Identifier: Apache-2.0
// What this device and driver make of the building blocks: for the tests, and for anyone who doubts a driver.

#include "device/vmf_shading.clh"
#include "shared/mip_pyramid.h"
#include "shared/moments.h"
#include "shared/movmf_fit.h"
#include "shared/vmf_lobe.h"

#if MULTUM_VECTOR_WIDTH != 1
#error "probe_numerics has only a scalar variant"
#endif

#define PROBE_EXP2 0
#define PROBE_LOG2 1
#define PROBE_KAPPA 2          // of a mean length given as spread
#define PROBE_ISNAN 3          // 1 where isnan() sees a NaN: relaxed mathematics would answer 0
#define PROBE_LOG_PEAK 4       // of amplitude 1, at kappa
#define PROBE_ONE_MINUS_LOG 5  // log2(1 - e)
#define PROBE_SHADING_KAPPA 6  // of q = 1 - A
#define PROBE_VMF_PEAK 7       // vMF density at its mean, at kappa

static float probed(float x, int function) {
  switch (function) {
    case PROBE_EXP2: return exp2_v(x);
    case PROBE_LOG2: return log2_v(x);
    case PROBE_KAPPA: return kappa_of_mean_length(1.0f - x, x);
    case PROBE_ISNAN: return isnan(x) ? 1.0f : 0.0f;
    case PROBE_LOG_PEAK: return log_peak(1.0f, x);
    case PROBE_ONE_MINUS_LOG: return log2_one_minus(x);
    case PROBE_SHADING_KAPPA: return shading_kappa(x);
    default: return vmf_shape(x).peak;
  }
}

// One work-item = one input; global size count. values[i] = function(inputs[i]).
__kernel void probe_functions(__global const float* inputs, __global float* values, int count, int function) {
  const int i = (int)get_global_id(0);
  if (i >= count) return;
  values[i] = probed(inputs[i], function);
}

// One work-item in all. sizes: the device's idea of the structs that it shares with the host.
__kernel void probe_layout(__global int* sizes) {
  if (get_global_id(0) != 0) return;
  MultumMovmfFit fit;
  MultumVmfLobe lobe;
  sizes[0] = (int)sizeof(MultumVmfLobe);
  sizes[1] = (int)((char*)&lobe.amplitude - (char*)&lobe);
  sizes[2] = (int)sizeof(MultumMovmfFit);
  sizes[3] = (int)((char*)&fit.kappa_cap_slope - (char*)&fit);
  sizes[4] = (int)((char*)&fit.total_weight_inverse - (char*)&fit);
  MultumMipLevel level;
  MultumTap tap;
  sizes[5] = (int)sizeof(MultumMipLevel);
  sizes[6] = (int)((char*)&level.gathers_y - (char*)&level);
  sizes[7] = (int)sizeof(MultumTap);
  sizes[8] = (int)((char*)&tap.fraction - (char*)&tap);
  sizes[9] = (int)sizeof(MultumGather);
  sizes[10] = (int)sizeof(MultumGatherEntry);
  sizes[11] = (int)sizeof(MultumStrip);
  sizes[12] = (int)sizeof(MultumMomentBand);
  MultumMomentBand band;
  sizes[13] = (int)((char*)&band.slope_z_min - (char*)&band);
  sizes[14] = (int)sizeof(MultumMomentLevel);
  sizes[15] = (int)sizeof(MultumMomentTap);
  sizes[16] = (int)sizeof(MultumFilteredMoments);
  MultumFilteredMoments moments;
  sizes[17] = (int)((char*)&moments.map_share - (char*)&moments);
}
