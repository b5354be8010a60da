// SPDX-License-Identifier: Apache-2.0
#include "host/bake/movmf_em_step.h"

#include <algorithm>

#include "kernels/shared/movmf_fit.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {
namespace {

constexpr std::size_t kPartialSums = 5;      // of movmf_em_chunks.cl
constexpr std::size_t kCondensedPlanes = 4;  // of movmf_condense.cl: three values and a weight

std::size_t product(int a, int b) { return static_cast<std::size_t>(a) * static_cast<std::size_t>(b); }

std::size_t group_count(const FitStep& step) {
  return (static_cast<std::size_t>(step.texel_count) + MULTUM_GROUP - 1) / MULTUM_GROUP;
}

}  // namespace

DevicePlanes::DevicePlanes(Device& device, const std::vector<float>& a, const std::vector<float>& b,
                           const std::vector<float>& c, const char* what) {
  const std::vector<float>* sources[3] = {&a, &b, &c};
  for (int i = 0; i < 3; ++i) {
    host[i].reserve(sources[i]->size() + MULTUM_GROUP);
    host[i] = *sources[i];
    host[i].resize(sources[i]->size() + MULTUM_GROUP, 0.0f);
    buffer[i] = device.wrap_buffer(host[i].data(), host[i].size() * sizeof(float), what);
  }
}

MovmfEmStep::MovmfEmStep(Device& device, const NormalMap& map, const ColourMap* albedo, const MovmfSettings& settings,
                         const MipSchedule& schedule)
    : device_(device),
      settings_(settings),
      schedule_(schedule),
      normals_(device, map.x, map.y, map.z, "the normal map") {
  if (albedo != nullptr) albedo_.emplace(device, albedo->r, albedo->g, albedo->b, "the albedo map");
  make_kernels();
  make_buffers();
}

void MovmfEmStep::make_kernels() {
  KernelVariant scalar{settings_.lobe_count, 1, schedule_.weighted};
  KernelVariant fast = scalar;
  fast.vector_width = vector_width_ = settings_.force_scalar ? 1 : device_.vector_width();
  start_kernel_ = device_.kernel("movmf_start", "movmf_start", fast);
  const auto uses = [&](FitMethod method) {
    return std::any_of(schedule_.levels.begin(), schedule_.levels.end(),
                       [&](const LevelSchedule& level) { return level.method == method; });
  };
  if (uses(FitMethod::kTexels)) {
    pack_kernel_ = device_.kernel("movmf_start", "movmf_pack", scalar);
    em_texels_kernel_ = device_.kernel("movmf_em_texels", "movmf_em_texels", fast);
  }
  if (uses(FitMethod::kCondensed)) {
    KernelVariant fast_weighted = fast;
    fast_weighted.weighted = true;  // by the number of normals in a cell
    em_condensed_kernel_ = device_.kernel("movmf_em_texels", "movmf_em_texels", fast_weighted);
    axes_kernel_ = device_.kernel("movmf_condense", "movmf_condense_axes", scalar);
    cells_kernel_ = device_.kernel("movmf_condense", "movmf_condense_cells", scalar);
    condense_pack_kernel_ = device_.kernel("movmf_condense", "movmf_condense_pack", scalar);
  }
  if (uses(FitMethod::kChunks)) {
    em_partial_kernel_ = device_.kernel("movmf_em_chunks", "movmf_em_partial", fast);
    mstep_kernel_ = device_.kernel("movmf_em_mstep", "movmf_em_mstep", scalar);
  }
  if (albedo_) {
    feature_partial_kernel_ = device_.kernel("movmf_features", "movmf_feature_partial", scalar);
    feature_sum_kernel_ = device_.kernel("movmf_features", "movmf_feature_sum", scalar);
    feature_condensed_kernel_ = device_.kernel("movmf_features", "movmf_feature_condensed", scalar);
  }
}

// Large enough for the largest step of any level.
void MovmfEmStep::make_buffers() {
  std::size_t list = MULTUM_GROUP, groups_most = 1, samples = 1, partial = 1, axes = 1, cells = 1, condensed = 1;
  const std::size_t sample_planes = schedule_.weighted ? 4 : 3;
  for (const LevelSchedule& level : schedule_.levels) {
    list = std::max(list, level.texel_list.size());
    const auto capacity = static_cast<std::size_t>(level.fit.sample_capacity);
    if (level.method == FitMethod::kCondensed)
      condensed = std::max(condensed, level.texel_list.size() * capacity * kCondensedPlanes);
    for (const FitStep& step : level.steps) {
      const std::size_t slots = group_count(step) * MULTUM_GROUP;
      groups_most = std::max(groups_most, group_count(step));
      const std::size_t chunks = product(step.texel_count, level.fit.chunk_count);
      if (level.method == FitMethod::kCondensed) {
        cells = std::max(cells, chunks * MULTUM_CELL_COUNT * MULTUM_CELL_FLOATS);
        axes = std::max(axes, slots * 2 * MULTUM_AXIS_FLOATS);
      } else {
        samples = std::max(samples, slots * capacity * sample_planes);  // a capacity of 0 in chunks
        partial = std::max(partial, chunks * lobe_count() * kPartialSums);
      }
    }
  }
  list_buffer_ = device_.make_buffer(list * sizeof(int), "texel list");
  start_buffer_ = device_.make_buffer(groups_most * lobe_count() * MULTUM_START_PLANES * MULTUM_GROUP * sizeof(float),
                                      "EM parameters");
  sample_buffer_ = device_.make_buffer(std::max(samples, condensed) * sizeof(float), "packed normals");
  sample_count_buffer_ = device_.make_buffer(list / MULTUM_GROUP * sizeof(int), "sample counts");
  partial_buffer_ = device_.make_buffer(partial * sizeof(float), "partial sums");
  axis_buffer_ = device_.make_buffer(axes * sizeof(float), "axes of cells");
  cell_buffer_ = device_.make_buffer(cells * sizeof(float), "cells of normals");
  if (albedo_) colour_sample_buffer_ = device_.make_buffer(condensed * sizeof(float), "condensed colours");
}

void MovmfEmStep::begin_level(const LevelSchedule& level) {
  device_.write(list_buffer_, level.texel_list.data(), level.texel_list.size() * sizeof(int));
  if (level.method != FitMethod::kCondensed) return;
  for (const FitStep& step : level.steps) condense(level.fit, step, normals_, sample_buffer_);
}

void MovmfEmStep::run(FitMethod method, MultumMovmfFit fit, const FitStep& step, const DeviceBuffer& parent,
                      DeviceBuffer& lobes, DeviceBuffer& colours, Progress* progress) {
  const std::size_t groups = group_count(step), slots = groups * MULTUM_GROUP;
  fit.list_offset = step.list_offset;
  fit.slot_count = static_cast<int>(slots);
  const Kernel::WorkSize em_size{slots / static_cast<std::size_t>(vector_width_)};
  start_kernel_.launch(em_size, parent, lobes, list_buffer_, start_buffer_, fit, settings_.start_kappa_factor,
                       settings_.start_amplitude_min);
  switch (method) {
    case FitMethod::kTexels:
      pack_kernel_.launch({groups * static_cast<std::size_t>(fit.sample_rows)}, normals_.buffer[0], normals_.buffer[1],
                          normals_.buffer[2], list_buffer_, sample_buffer_, sample_count_buffer_, fit);
      em_texels_kernel_.launch(em_size, sample_buffer_, sample_count_buffer_, start_buffer_, list_buffer_, lobes, fit);
      break;
    case FitMethod::kCondensed:
      fit.sample_group_offset = step.list_offset / MULTUM_GROUP;
      em_condensed_kernel_.launch(em_size, sample_buffer_, sample_count_buffer_, start_buffer_, list_buffer_, lobes,
                                  fit);
      break;
    case FitMethod::kChunks: run_chunks(fit, step, lobes, progress); break;
  }
  if (colours.byte_count() > 0) fit_colours(method, fit, step, colours);
  device_.finish();
  progress_advance(progress, 0);
}

void MovmfEmStep::condense(MultumMovmfFit fit, const FitStep& step, const DevicePlanes& values, DeviceBuffer& samples) {
  const std::size_t slots = group_count(step) * MULTUM_GROUP;
  fit.list_offset = step.list_offset;
  fit.slot_count = static_cast<int>(slots);
  fit.sample_group_offset = step.list_offset / MULTUM_GROUP;
  axes_kernel_.launch({slots}, normals_.buffer[0], normals_.buffer[1], normals_.buffer[2], list_buffer_, axis_buffer_,
                      fit);
  cells_kernel_.launch({product(step.texel_count, fit.chunk_count)}, normals_.buffer[0], normals_.buffer[1],
                       normals_.buffer[2], values.buffer[0], values.buffer[1], values.buffer[2], list_buffer_,
                       axis_buffer_, cell_buffer_, fit);
  condense_pack_kernel_.launch({group_count(step)}, cell_buffer_, list_buffer_, samples, sample_count_buffer_, fit);
}

void MovmfEmStep::run_chunks(const MultumMovmfFit& fit, const FitStep& step, DeviceBuffer& lobes, Progress* progress) {
  const std::size_t chunks = product(step.texel_count, fit.chunk_count);
  const Kernel::WorkSize partial_size =
      vector_width_ == 1 ? Kernel::WorkSize{chunks * MULTUM_GROUP, MULTUM_GROUP} : Kernel::WorkSize{chunks, 1};
  for (int i = 0; i < fit.iteration_count; ++i) {
    em_partial_kernel_.launch(partial_size, normals_.buffer[0], normals_.buffer[1], normals_.buffer[2], start_buffer_,
                              list_buffer_, partial_buffer_, fit);
    mstep_kernel_.launch({static_cast<std::size_t>(step.texel_count) * lobe_count()}, partial_buffer_, start_buffer_,
                         list_buffer_, lobes, fit, i);
    // An iteration reads every normal of its texels, seconds on the largest maps: a chance to cancel after each.
    device_.finish();
    progress_advance(progress, 0);
  }
}

void MovmfEmStep::fit_colours(FitMethod method, MultumMovmfFit fit, const FitStep& step, DeviceBuffer& colours) {
  if (method == FitMethod::kCondensed) {
    condense(fit, step, *albedo_, colour_sample_buffer_);
    fit.sample_group_offset = step.list_offset / MULTUM_GROUP;
    feature_condensed_kernel_.launch({group_count(step) * MULTUM_GROUP}, sample_buffer_, colour_sample_buffer_,
                                     sample_count_buffer_, start_buffer_, list_buffer_, colours, fit);
    return;
  }
  if (method == FitMethod::kTexels) {
    fit.chunk_rows = fit.sample_rows;
    fit.chunk_count = 1;
  }
  feature_partial_kernel_.launch({product(step.texel_count, fit.chunk_count)}, normals_.buffer[0], normals_.buffer[1],
                                 normals_.buffer[2], albedo_->buffer[0], albedo_->buffer[1], albedo_->buffer[2],
                                 start_buffer_, list_buffer_, partial_buffer_, fit);
  feature_sum_kernel_.launch({static_cast<std::size_t>(step.texel_count) * lobe_count()}, partial_buffer_, list_buffer_,
                             colours, fit);
}

}  // namespace multum
