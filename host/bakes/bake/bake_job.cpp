// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/bake/bake_job.h"

#include "host/foundation/base/error.h"

namespace multum {

ChannelFile roughness_file(const BakeJob& job) {
  MULTUM_CHECK(!job.roughness.empty());
  ChannelFile file = parse_channel_file(job.roughness);
  file.is_gloss = job.roughness_is_gloss;
  return file;
}

int first_measured_level(const BakeJob& job) {
  return job.stored_only || job.surface == MapSurface::kInterpolated ? job.fitting.first_level : 0;
}

std::vector<std::string> input_files(const BakeJob& job) {
  std::vector<std::string> files = {job.input};
  for (std::string BakeJob::*map : kMaterialMaps)
    if (!(job.*map).empty()) files.push_back(map == &BakeJob::roughness ? roughness_file(job).path : job.*map);
  return files;
}

}  // namespace multum
