// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/bake/bake_batch.h"

#include <map>

#include "host/formats/image/normals/tile_set.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/udim_set.h"

namespace multum {

std::vector<BakeJob> make_bake_jobs(const BakeJob& pattern, const std::vector<std::string>& inputs) {
  MULTUM_CHECK(!inputs.empty());
  std::vector<BakeJob> jobs;
  if (inputs.size() == 1 && !has_udim(inputs[0])) {
    jobs.push_back(pattern);
    jobs[0].input = inputs[0];
    return jobs;
  }
  std::map<std::string, std::string> taken;  // output -> input
  TileSets sets;
  for (const SetMap& map : maps_of_names(inputs)) {
    BakeJob job = pattern;
    job.input = map.path;
    sets.enter(map.set, map.tile, job.reading);
    for (std::string BakeJob::*material : kMaterialMaps)
      if (!map.tile.empty()) job.*material = with_tile(pattern.*material, map.tile);
    job.output = place_of_map(pattern.output, map, ".ndf.exr");
    job.report = place_of_map(pattern.report, map, ".json");
    const auto [other, is_new] = taken.emplace(job.output, map.path);
    if (!is_new)
      throw Error(ErrorCode::kUsage,
                  job.output + ": both " + other->second + " and " + map.path + " would be written there");
    jobs.push_back(std::move(job));
  }
  return jobs;
}

}  // namespace multum
