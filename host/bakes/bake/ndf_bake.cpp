// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/bake/ndf_bake.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/bakes/bake/output_state.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/machine.h"

namespace multum {

MapInputs map_inputs(const BakeJob& job, const BakeSource& source, std::uint64_t memory_bytes) {
  MapInputs inputs{&source.map.normals, source.features(), memory_bytes, job.threads};
  inputs.spill.scratch_folder = scratch_folder(job);
  return inputs;
}

std::uint64_t tile_row_bytes(const BakedHeader& header, int level, int tile_size, std::uint64_t value_count) {
  const auto texels = static_cast<std::uint64_t>(mip_level_size(header.width, level)) *
                      static_cast<std::uint64_t>(std::min(tile_size, mip_level_size(header.height, level)));
  constexpr std::uint64_t kChannelsOfAPart = 6;  // upper limit
  return texels * (value_count * sizeof(float) + kChannelsOfAPart * sizeof(std::uint16_t));
}

std::uint64_t tile_rows_bytes(const BakedHeader& header, int tile_size, std::uint64_t value_count) {
  std::uint64_t bytes = 0;
  for (int l = header.first_level; l < header.level_count(); ++l)
    bytes += tile_row_bytes(header, l, tile_size, value_count);
  return bytes;
}

std::uint64_t memory_beside_writer(const BakeRun& run, std::uint64_t waiting_bytes) {
  constexpr std::uint64_t kWaitingAllowed = std::uint64_t{32} << 20, kBesideLeast = std::uint64_t{8} << 20;
  const std::uint64_t more = waiting_bytes > kWaitingAllowed ? waiting_bytes - kWaitingAllowed : 0;
  if (run.memory_bytes < more + kBesideLeast) {
    const bool is_given = run.job.memory_bytes > 0;
    const std::uint64_t memory = is_given ? run.job.memory_bytes : machine_memory_bytes() / 4;
    throw Error(
        is_given ? ErrorCode::kUsage : ErrorCode::kEnvironment,
        fmt::format("{} {} MiB, expected at least {} MiB for a map {} texels wide, because the rows of tiles that wait "
                    "to be written need {} MiB",
                    is_given ? "--memory is" : "a bake can use a quarter of the memory of this process,", memory >> 20,
                    ((memory + more + kBesideLeast - run.memory_bytes) >> 20) + 1, run.header.width,
                    waiting_bytes >> 20));
  }
  return run.memory_bytes - more;
}

const NdfBake& ndf_bake(Representation representation) {
  for (const NdfBake* one : {&kMovmfBake, &kGmmBake, &kMomentBake, &kShBake})
    if (one->representation == representation) return *one;
  MULTUM_CHECK(false);
  return kMovmfBake;
}

std::unique_ptr<AccuracyMeter> try_levels(Device& device, BakeJob job, const BakeSource& source,
                                          AccuracySettings accuracy, BakeReport& report, Progress* progress) {
  const int coarsest = mip_level_count(source.map.normals.width(), source.map.normals.height()) - 1;
  job.fitting.first_level = std::min(std::max(job.fitting.first_level, accuracy.first_level), coarsest);
  accuracy.threads = job.threads;
  StageClock clock(report);
  const BakeRun run{map_inputs(job, source, machine_memory_bytes() / 4),
                    job,
                    device,
                    source,
                    baked_header_of(job, source),
                    fitting_settings(job, source.map.report.wrap_s, source.map.report.wrap_t),
                    clock};
  return ndf_bake(job.representation).try_bake(run, accuracy, report, progress);
}

}  // namespace multum
