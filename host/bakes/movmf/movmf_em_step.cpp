// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/movmf_em_step.h"

#include <algorithm>

#include "host/formats/asset/lobes/lobe_family.h"
#include "host/formats/opencl/launch_shape.h"
#include "host/foundation/base/error.h"
#include "kernels/shared/movmf_fit.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {
namespace {

constexpr std::size_t kPartialSums = 5;  // sums per lobe in movmf_em_chunks.cl
constexpr std::size_t kWeightedPlanes = 4;
// A window is fitted in four steps. All four can be queued, so that the device starts one after the other without
// waiting for the host.
constexpr std::size_t kStepsQueuedMax = 4;

std::size_t group_count(std::size_t texels) { return (texels + MULTUM_GROUP - 1) / MULTUM_GROUP; }

// Buffers grow to the size of the largest step.
void ensure(Device& device, DeviceBuffer& buffer, std::size_t byte_count, const char* what) {
  if (buffer.byte_count() >= byte_count) return;
  buffer = DeviceBuffer();  // frees the buffer before the next allocation
  buffer = device.make_buffer(byte_count, what);
}

std::size_t sample_bytes(const MultumMovmfFit& fit, std::size_t slots, std::size_t planes) {
  return slots * static_cast<std::size_t>(fit.sample_capacity) * planes * sizeof(float);
}

std::size_t partial_bytes(const MultumMovmfFit& fit, std::size_t texels, std::size_t lobes) {
  return texels * static_cast<std::size_t>(fit.chunk_count) * lobes * kPartialSums * sizeof(float);
}

void restart_at(MapWindow& window, int first_row, int row_count) {
  if (first_row < window.first_row()) window.move_to(first_row, 0);  // windows can only slide down
  window.move_to(first_row, row_count);
}

// Calls body() for each band of the map in which chunks begin. The windows hold the band's rows and the following rows
// into which the chunks extend.
template <typename Body>
void for_each_chunk_band(MultumMovmfFit& fit, MapWindow& normals, MapWindow* features, const Body& body) {
  const bool whole = normals.capacity_rows() >= fit.map_height;
  const int band_rows = whole ? fit.map_height : std::max(1, normals.capacity_rows() - fit.chunk_rows);
  for (int row = 0; row < fit.map_height; row += band_rows) {
    fit.map_first_row = row;
    fit.map_window_rows = std::min(band_rows, fit.map_height - row);
    const int rows = std::min(fit.map_window_rows + fit.chunk_rows, fit.map_height - row);
    restart_at(normals, row, rows);
    if (features != nullptr) restart_at(*features, row, rows);
    body();
  }
}

}  // namespace

MovmfEmStep::MovmfEmStep(Device& device, const MovmfSettings& settings, bool weighted)
    : device_(device),
      settings_(settings),
      scalar_{settings.lobe_count, 1, weighted, lobe_family(settings.representation).is_planar},
      fast_(scalar_),
      binned_(scalar_),
      starting_(scalar_),
      packing_(scalar_) {
  fast_.vector_width = binned_.vector_width = starting_.vector_width = device.shape().vector_width;
  binned_.weighted = true;  // weights are the numbers of normals in cells
  starting_.weighted = false;
  packing_.lobes = 1;
}

MovmfEmStep::~MovmfEmStep() {
  if (lists_.empty()) return;  // the list still has entries if a fit was cancelled or failed
  try {
    device_.finish();
  } catch (const Error&) {
    // The failure has already been thrown.
  }
}

std::vector<ProgramChoice> MovmfEmStep::programs(const MipSchedule& schedule, bool has_features) const {
  const bool uses_binned = schedule.uses(FitMethod::kBinned), uses_texels = schedule.uses(FitMethod::kTexels);
  const bool uses_em = uses_binned || uses_texels || schedule.uses(FitMethod::kChunks);
  std::vector<ProgramChoice> programs;
  if (uses_texels) programs.push_back({"movmf_em_texels", fast_});
  if (schedule.uses(FitMethod::kChoice)) programs.push_back({"movmf_choose", starting_});
  if (uses_em) programs.push_back({"movmf_start", starting_});
  if (uses_binned || uses_texels) programs.push_back({"movmf_pack", packing_});
  // If the map's sides are not powers of two, this program is the same as the first one, and it is prepared only once.
  if (uses_binned) programs.push_back({"movmf_em_texels", binned_});
  if (settings_.refine) {
    if (uses_texels) programs.push_back({"movmf_refine", fast_});
    if (uses_binned) programs.push_back({"movmf_refine", binned_});
  }
  if (schedule.uses(FitMethod::kChunks)) {
    programs.push_back({"movmf_em_chunks", fast_});
    programs.push_back({"movmf_em_mstep", scalar_});
  }
  if (has_features && uses_em) programs.push_back({"movmf_features", scalar_});
  return programs;
}

// Creates a kernel when a step needs it for the first time, because levels use different methods.
Kernel& MovmfEmStep::lazy_kernel(Kernel& kernel, const char* file, const char* name, const KernelVariant& variant) {
  if (!kernel.is_built()) kernel = device_.kernel(file, name, variant);
  return kernel;
}

void MovmfEmStep::run(FitMethod method, MultumMovmfFit fit, std::vector<int> texels, StepWindows& windows,
                      Progress* progress) {
  if (texels.empty()) return;
  const std::size_t texel_count = texels.size();
  upload_texels(fit, std::move(texels), progress);
  if (method == FitMethod::kChoice) {
    choose(fit, windows);
  } else {
    start_em(fit, windows);
    if (method == FitMethod::kChunks) run_chunks(fit, texel_count, windows, progress);
    else fit_packed(method, fit, windows);
  }
  if (windows.wants_features) fit_features(method, fit, texel_count, windows);
}

void MovmfEmStep::finish(Progress* progress) {
  device_.finish();
  lists_.clear();
  progress_advance(progress, 0);
}

void MovmfEmStep::choose(const MultumMovmfFit& fit, StepWindows& windows) {
  const auto slots = static_cast<std::size_t>(fit.slot_count);
  ensure(device_, chosen_, slots * sizeof(int), "numbers of lobes");
  const MapWindow& normals = windows.map->normals;
  lazy_kernel(choose_kernel_, "movmf_choose", "movmf_choose", starting_)
      .launch({slots / static_cast<std::size_t>(starting_.vector_width)}, normals[0], normals[1], normals[2],
              windows.parent.buffer(), windows.lobes.buffer(), list_, chosen_, fit);
}

void MovmfEmStep::start_em(const MultumMovmfFit& fit, StepWindows& windows) {
  const auto slots = static_cast<std::size_t>(fit.slot_count);
  ensure(device_, start_, slots * lobe_count() * MULTUM_START_PLANES * sizeof(float), "EM parameters");
  const DeviceBuffer& parent = fit.parent_width > 0 ? windows.parent.buffer() : windows.lobes.buffer();
  lazy_kernel(start_kernel_, "movmf_start", "movmf_start", starting_)
      .launch({slots / static_cast<std::size_t>(starting_.vector_width)}, parent, windows.lobes.buffer(),
              windows.alignment_vectors.buffer(), list_, start_, fit);
}

void MovmfEmStep::refine(FitMethod method, MultumMovmfFit fit, std::vector<int> texels, StepWindows& windows,
                         Progress* progress) {
  MULTUM_CHECK(method != FitMethod::kChunks);
  if (texels.empty()) return;
  upload_texels(fit, std::move(texels), progress);
  pack(method, fit, windows);
  const KernelVariant& variant = method == FitMethod::kBinned ? binned_ : fast_;
  lazy_kernel(method == FitMethod::kBinned ? refine_binned_kernel_ : refine_kernel_, "movmf_refine", "movmf_refine",
              variant)
      .launch({static_cast<std::size_t>(fit.slot_count) / static_cast<std::size_t>(variant.vector_width)}, samples_,
              sample_counts_, list_, windows.lobes.buffer(), windows.refined.buffer(), fit);
}

void MovmfEmStep::upload_texels(MultumMovmfFit& fit, std::vector<int> texels, Progress* progress) {
  if (lists_.size() >= kStepsQueuedMax) finish(progress);
  const std::size_t slots = group_count(texels.size()) * MULTUM_GROUP;
  texels.resize(slots, -1);
  fit.slot_count = static_cast<int>(slots);
  ensure(device_, list_, slots * sizeof(int), "texel list");
  device_.queue_write(list_, lists_.emplace_back(std::move(texels)).data(), slots * sizeof(int));
}

void MovmfEmStep::pack(FitMethod method, const MultumMovmfFit& fit, const StepWindows& windows) {
  if (method == FitMethod::kBinned) pack_binned(fit, windows);
  else pack_texels(fit, windows);
}

void MovmfEmStep::pack_texels(const MultumMovmfFit& fit, const StepWindows& windows) {
  const auto slots = static_cast<std::size_t>(fit.slot_count), groups = slots / MULTUM_GROUP;
  ensure(device_, sample_counts_, groups * sizeof(int), "sample counts");
  ensure(device_, samples_, sample_bytes(fit, slots, fast_.weighted ? kWeightedPlanes : 3), "packed normals");
  const MapWindow& normals = windows.map->normals;
  lazy_kernel(pack_kernel_, "movmf_pack", "movmf_pack", packing_)
      .launch({groups * static_cast<std::size_t>(fit.sample_rows)}, normals[0], normals[1], normals[2], list_, samples_,
              sample_counts_, fit);
}

void MovmfEmStep::pack_binned(const MultumMovmfFit& fit, const StepWindows& windows) {
  const auto slots = static_cast<std::size_t>(fit.slot_count), groups = slots / MULTUM_GROUP;
  ensure(device_, sample_counts_, groups * sizeof(int), "sample counts");
  ensure(device_, samples_, sample_bytes(fit, slots, kWeightedPlanes), "packed normals");
  const int parts = device_.shape().pack_parts;
  lazy_kernel(binned_pack_kernel_, "movmf_pack", "movmf_binned_pack", packing_)
      .launch({groups * static_cast<std::size_t>(parts)}, windows.binned.buffer(), windows.binned_counts.buffer(),
              list_, samples_, sample_counts_, fit, parts);
}

void MovmfEmStep::fit_packed(FitMethod method, const MultumMovmfFit& fit, StepWindows& windows) {
  pack(method, fit, windows);
  const bool is_binned = method == FitMethod::kBinned;
  const auto slots = static_cast<std::size_t>(fit.slot_count);
  KernelVariant variant = is_binned ? binned_ : fast_;
  const bool by_teams = device_.shape().fits_by_teams(slots, fit.sample_capacity);
  const Kernel::WorkSize size = by_teams ? Kernel::WorkSize{slots * MULTUM_TEAM, MULTUM_TEAM}
                                         : Kernel::WorkSize{slots / static_cast<std::size_t>(variant.vector_width)};
  if (by_teams) variant.vector_width = 1;
  Kernel& kernel = by_teams    ? is_binned ? em_binned_team_kernel_ : em_team_kernel_
                   : is_binned ? em_binned_kernel_
                               : em_texels_kernel_;
  lazy_kernel(kernel, "movmf_em_texels", by_teams ? "movmf_em_team" : "movmf_em_texels", variant)
      .launch(size, samples_, sample_counts_, start_, list_, windows.lobes.buffer(), windows.alignment_vectors.buffer(),
              fit);
}

void MovmfEmStep::run_chunks(MultumMovmfFit fit, std::size_t texel_count, StepWindows& windows, Progress* progress) {
  ensure(device_, partial_, partial_bytes(fit, texel_count, lobe_count()), "partial sums");
  lazy_kernel(em_partial_kernel_, "movmf_em_chunks", "movmf_em_partial", fast_);
  lazy_kernel(mstep_kernel_, "movmf_em_mstep", "movmf_em_mstep", scalar_);
  const std::size_t chunks = texel_count * static_cast<std::size_t>(fit.chunk_count);
  const Kernel::WorkSize partial_size =
      fast_.vector_width == 1 ? Kernel::WorkSize{chunks * MULTUM_GROUP, MULTUM_GROUP} : Kernel::WorkSize{chunks, 1};
  for (int i = 0; i < fit.iteration_count; ++i) {
    for_each_chunk_band(fit, windows.map->normals, nullptr, [&] {
      const MapWindow& normals = windows.map->normals;
      em_partial_kernel_.launch(partial_size, normals[0], normals[1], normals[2], start_, list_, partial_, fit);
    });
    if (i == 0 && scalar_.planar)
      lazy_kernel(cap_kernel_, "movmf_em_mstep", "movmf_em_cap", scalar_)
          .launch({texel_count}, partial_, start_, list_, fit);
    mstep_kernel_.launch({texel_count * lobe_count()}, partial_, start_, list_, windows.lobes.buffer(),
                         windows.alignment_vectors.buffer(), fit, i);
    // An iteration reads every normal of its texels, which takes seconds on the largest maps. The caller can cancel
    // after each iteration.
    device_.finish();
    progress_advance(progress, 0);
  }
}

void MovmfEmStep::fit_features(FitMethod method, const MultumMovmfFit& fit, std::size_t texel_count,
                               StepWindows& windows) {
  const std::size_t count =
      method == FitMethod::kBinned ? windows.binned_planes.size() : windows.map->rgb_planes.size();
  for (std::size_t rgb_plane = 0; rgb_plane < count; ++rgb_plane)
    fit_rgb_plane(method, fit, texel_count, windows, rgb_plane);
}

void MovmfEmStep::fit_rgb_plane(FitMethod method, MultumMovmfFit fit, std::size_t texel_count, StepWindows& windows,
                                std::size_t rgb_plane) {
  DeviceBuffer& features = windows.features.buffer();
  const int first_plane = static_cast<int>(rgb_plane) * settings_.lobe_count;
  if (method == FitMethod::kChoice) {
    const MapWindow& values = windows.map->rgb_planes[rgb_plane];
    lazy_kernel(feature_chosen_kernel_, "movmf_choose", "movmf_feature_chosen", starting_)
        .launch({static_cast<std::size_t>(fit.slot_count)}, values[0], values[1], values[2], list_, chosen_, features,
                fit, first_plane);
    return;
  }
  if (method == FitMethod::kBinned) {
    const std::size_t groups = group_count(texel_count);
    ensure(device_, feature_samples_, sample_bytes(fit, groups * MULTUM_GROUP, kWeightedPlanes), "packed features");
    const int parts = device_.shape().pack_parts;
    binned_pack_kernel_.launch({groups * static_cast<std::size_t>(parts)}, windows.binned_planes[rgb_plane].buffer(),
                               windows.binned_counts.buffer(), list_, feature_samples_, sample_counts_, fit, parts);
    lazy_kernel(feature_binned_kernel_, "movmf_features", "movmf_feature_binned", scalar_)
        .launch({groups * MULTUM_GROUP}, samples_, feature_samples_, sample_counts_, start_, list_, features, fit,
                first_plane);
    return;
  }
  ensure(device_, partial_, partial_bytes(fit, texel_count, lobe_count()), "partial sums");
  lazy_kernel(feature_partial_kernel_, "movmf_features", "movmf_feature_partial", scalar_);
  const auto add_band = [&] {
    const MapWindow &n = windows.map->normals, &c = windows.map->rgb_planes[rgb_plane];
    feature_partial_kernel_.launch({texel_count * static_cast<std::size_t>(fit.chunk_count)}, n[0], n[1], n[2], c[0],
                                   c[1], c[2], start_, list_, partial_, fit);
  };
  if (method == FitMethod::kChunks)
    for_each_chunk_band(fit, windows.map->normals, &windows.map->rgb_planes[rgb_plane], add_band);
  else add_band();
  lazy_kernel(feature_sum_kernel_, "movmf_features", "movmf_feature_sum", scalar_)
      .launch({texel_count * lobe_count()}, partial_, list_, features, fit, first_plane);
}

std::uint64_t em_step_bytes(const LevelSchedule& level, const MovmfSettings& settings, bool has_features,
                            std::uint64_t texel_count) {
  const auto lobes = static_cast<std::size_t>(settings.lobe_count);
  const std::size_t slots = group_count(texel_count) * MULTUM_GROUP;
  if (level.method == FitMethod::kChoice) return slots * 2 * sizeof(int);
  std::uint64_t bytes = slots * (sizeof(int) + lobes * MULTUM_START_PLANES * sizeof(float));
  if (level.method == FitMethod::kChunks || has_features) bytes += partial_bytes(level.fit, texel_count, lobes);
  if (level.method != FitMethod::kChunks)
    bytes +=
        sample_bytes(level.fit, slots, kWeightedPlanes) * (has_features && level.method == FitMethod::kBinned ? 2 : 1);
  return bytes;
}

}  // namespace multum
