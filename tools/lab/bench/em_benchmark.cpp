// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/em_benchmark.h"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/bakes/movmf/mip_schedule.h"
#include "host/bakes/movmf/movmf_bake.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/opencl/device.h"
#include "host/formats/opencl/launch_shape.h"
#include "host/formats/testmap/four_quarter_map.h"
#include "host/foundation/base/files/content_hash.h"
#include "kernels/shared/vmf_lobe.h"
#include "tools/lab/bench/documents/markdown_table.h"
#include "tools/lab/bench/measuring/elapsed.h"
#include "tools/lab/bench/measuring/machine.h"
#include "tools/lab/bench/measuring/statistics.h"
#include "tools/lab/bench/yardsticks/em_yardstick.h"

namespace multum::bench {
namespace {

// Contains the inputs of one level for both programs, with all texels in one launch.
class LevelBench {
 public:
  LevelBench(Device& device, const NormalMap& map, const LevelSchedule& level, const std::vector<MultumVmfLobe>& parent,
             const EmBenchmarkOptions& options)
      : device_(device), level_(level), fit_(level.fit), lobes_(static_cast<std::size_t>(options.lobes)) {
    const auto texels = static_cast<std::size_t>(fit_.width * fit_.height);
    std::vector<int> list(texels);
    for (std::size_t i = 0; i < texels; ++i) list[i] = static_cast<int>(i);
    while (list.size() % MULTUM_GROUP != 0) list.push_back(-1);
    slots_ = list.size();
    fit_.slot_count = static_cast<int>(slots_);
    fit_.iteration_count = options.iterations;
    fit_.convergence_tolerance_squared = 0.0f;  // both programs run every iteration
    for (const std::vector<float>* plane : {&map.x, &map.y, &map.z}) {
      planes_.push_back(*plane);
      planes_.back().resize(plane->size() + MULTUM_GROUP, 0.0f);
    }
    for (const std::vector<float>& plane : planes_)
      plane_buffers_.push_back(device.wrap_buffer(plane.data(), plane.size() * sizeof(float), "plane"));
    const KernelVariant scalar{options.lobes, 1, false};
    KernelVariant fast = scalar;
    fast.vector_width = width_ = device.shape().vector_width;
    by_teams_ = device.shape().fits_by_teams(slots_, fit_.sample_columns * fit_.sample_rows);
    texels_kernel_ = by_teams_ ? device.kernel("movmf_em_texels", "movmf_em_team", scalar)
                               : device.kernel("movmf_em_texels", "movmf_em_texels", fast);
    partial_kernel_ = device.kernel("movmf_em_chunks", "movmf_em_partial", fast);
    mstep_kernel_ = device.kernel("movmf_em_mstep", "movmf_em_mstep", scalar);
    list_buffer_ = device.make_buffer(list.size() * sizeof(int), "list");
    device.write(list_buffer_, list.data(), list.size() * sizeof(int));
    result_.resize(lobes_ * texels);
    result_buffer_ = device.make_buffer(result_.size() * sizeof(MultumVmfLobe), "lobes");
    device.write(result_buffer_, result_.data(), result_.size() * sizeof(MultumVmfLobe));
    DeviceBuffer parent_buffer = device.make_buffer(parent.size() * sizeof(MultumVmfLobe), "parent");
    device.write(parent_buffer, parent.data(), parent.size() * sizeof(MultumVmfLobe));
    start_.resize(slots_ * lobes_ * MULTUM_START_PLANES);
    start_buffer_ = device.make_buffer(start_.size() * sizeof(float), "start");
    alignment_buffer_ = device.make_buffer(result_.size() * sizeof(MultumVmfLobe), "directions");
    device.fill_zero(alignment_buffer_);
    device.kernel("movmf_start", "movmf_start", scalar)
        .launch({slots_}, parent_buffer, result_buffer_, alignment_buffer_, list_buffer_, start_buffer_, fit_);
    device.read(start_buffer_, start_.data(), start_.size() * sizeof(float));
    if (level.method == FitMethod::kChunks) {
      partial_buffer_ =
          device.make_buffer(texels * static_cast<std::size_t>(fit_.chunk_count) * lobes_ * 5 * sizeof(float), "sums");
    } else {
      samples_.resize(slots_ * static_cast<std::size_t>(fit_.sample_columns * fit_.sample_rows) * 3);
      sample_count_buffer_ = device.make_buffer(slots_ / MULTUM_GROUP * sizeof(int), "sample counts");
      sample_buffer_ = device.make_buffer(samples_.size() * sizeof(float), "samples");
      device.kernel("movmf_pack", "movmf_pack", scalar)
          .launch({slots_ / MULTUM_GROUP * static_cast<std::size_t>(fit_.sample_rows)}, plane_buffers_[0],
                  plane_buffers_[1], plane_buffers_[2], list_buffer_, sample_buffer_, sample_count_buffer_, fit_);
      device.read(sample_buffer_, samples_.data(), samples_.size() * sizeof(float));
    }
  }

  double time_kernels() {
    device_.write(start_buffer_, start_.data(), start_.size() * sizeof(float));
    device_.finish();
    return milliseconds_of([&] {
      const auto texels = static_cast<std::size_t>(fit_.width * fit_.height);
      if (level_.method == FitMethod::kChunks) {
        const std::size_t chunks = texels * static_cast<std::size_t>(fit_.chunk_count);
        for (int i = 0; i < fit_.iteration_count; ++i) {
          partial_kernel_.launch(
              width_ == 1 ? Kernel::WorkSize{chunks * MULTUM_GROUP, MULTUM_GROUP} : Kernel::WorkSize{chunks, 1},
              plane_buffers_[0], plane_buffers_[1], plane_buffers_[2], start_buffer_, list_buffer_, partial_buffer_,
              fit_);
          mstep_kernel_.launch({texels * lobes_}, partial_buffer_, start_buffer_, list_buffer_, result_buffer_,
                               alignment_buffer_, fit_, i);
        }
      } else {
        texels_kernel_.launch(by_teams_ ? Kernel::WorkSize{slots_ * MULTUM_TEAM, MULTUM_TEAM}
                                        : Kernel::WorkSize{slots_ / static_cast<std::size_t>(width_)},
                              sample_buffer_, sample_count_buffer_, start_buffer_, list_buffer_, result_buffer_,
                              alignment_buffer_, fit_);
      }
      device_.finish();
    });
  }

  double time_yardstick(Instructions instructions) {
    YardstickLevel y{static_cast<int>(lobes_),
                     fit_.iteration_count,
                     static_cast<int>(slots_ / MULTUM_GROUP),
                     fit_.sample_columns * fit_.sample_rows,
                     level_.method == FitMethod::kChunks ? nullptr : samples_.data(),
                     start_.data(),
                     fit_.kappa_cap,
                     fit_.kappa_cap_slope};
    y.plane_x = planes_[0].data();
    y.plane_y = planes_[1].data();
    y.plane_z = planes_[2].data();
    y.map_width = fit_.map_width;
    y.level_width = fit_.width;
    y.texel_count = fit_.width * fit_.height;
    y.texel_side = fit_.sample_columns;
    return milliseconds_of([&] { yardstick_result_ = fit_with_yardstick(y, instructions); });
  }

  const std::vector<MultumVmfLobe>& kernel_result() {
    device_.read(result_buffer_, result_.data(), result_.size() * sizeof(MultumVmfLobe));
    return result_;
  }

  // Returns the mean absolute difference of `a r` and `a` between the two programs. The difference shows whether both
  // programs did the same work.
  double mean_difference() {
    const std::vector<MultumVmfLobe>& found = kernel_result();
    const std::size_t texels = found.size() / lobes_;
    double sum = 0.0;
    for (std::size_t j = 0; j < lobes_; ++j)
      for (std::size_t i = 0; i < texels; ++i) {
        const float* other = &yardstick_result_[(j * slots_ + i) * 4];
        const MultumVmfLobe& lobe = found[j * texels + i];
        sum += static_cast<double>(std::abs(lobe.amplitude - other[3]) +
                                   std::abs(lobe.amplitude * lobe.mean_z - other[3] * other[2]));
      }
    return sum / static_cast<double>(2 * found.size());
  }

 private:
  Device& device_;
  const LevelSchedule& level_;
  MultumMovmfFit fit_;
  std::size_t lobes_, slots_ = 0;
  int width_ = 1;
  bool by_teams_ = false;
  std::vector<std::vector<float>> planes_;
  std::vector<float> samples_, start_, yardstick_result_;
  std::vector<MultumVmfLobe> result_;
  std::vector<DeviceBuffer> plane_buffers_;
  DeviceBuffer list_buffer_, start_buffer_, sample_buffer_, sample_count_buffer_, partial_buffer_, result_buffer_,
      alignment_buffer_;
  Kernel texels_kernel_, partial_kernel_, mstep_kernel_;
};

using Json = nlohmann::ordered_json;

// Tries all cores, half of the cores and a quarter of the cores. With little work, waking a thread costs more time
// than the thread saves.
int fastest_threads(LevelBench& bench, Instructions instructions) {
  int best = core_count();
  double least = 0.0;
  for (const int share : {1, 2, 4}) {
    const int threads = std::max(1, core_count() / share);
    omp_set_num_threads(threads);
    const double time = bench.time_yardstick(instructions);
    if (share == 1 || time < least) {
      least = time;
      best = threads;
    }
  }
  return best;
}

Json run_kernels(LevelBench& bench, int level, int repetitions) {
  bench.time_kernels();  // this run is not timed; it compiles kernels and fills caches
  std::vector<double> times;
  for (int i = 0; i < repetitions; ++i) times.push_back(bench.time_kernels());
  return {{"level", level}, {"kernels_ms", spread_of(times).median}};
}

Json run_level(LevelBench& bench, int level, const EmBenchmarkOptions& options, Instructions instructions) {
  if (!options.yardstick) return run_kernels(bench, level, options.repetitions);
  const int repetitions = options.repetitions;
  bench.time_kernels();  // this run is not timed; it compiles kernels and fills caches
  const int threads = options.threads > 0 ? options.threads : fastest_threads(bench, instructions);
  omp_set_num_threads(threads);
  bench.time_yardstick(instructions);
  std::vector<double> ours, theirs, ratios;
  for (int i = 0; i < repetitions; ++i) {
    ours.push_back(bench.time_kernels());
    theirs.push_back(bench.time_yardstick(instructions));
    ratios.push_back(ours.back() / theirs.back());
  }
  const Spread ratio = spread_of(ratios);
  return {{"level", level},
          {"yardstick_threads", threads},
          {"kernels_ms", spread_of(ours).median},
          {"yardstick_ms", spread_of(theirs).median},
          {"ratio", ratio.median},
          {"ratio_quartiles", {ratio.low, ratio.high}},
          {"mean_difference", bench.mean_difference()}};
}

double sum_over_levels(const Json& levels, const char* key) {
  double sum = 0.0;
  for (const Json& level : levels) sum += level.at(key).get<double>();
  return sum;
}

}  // namespace

Json run_em_benchmark(const EmBenchmarkOptions& options, Progress* progress) {
  const Instructions instructions = choose_instructions(options.instructions);
  if (options.instructions) limit_opencl(instructions);
  Device device = Device::open(options.device);
  const NormalMap map = make_four_quarter_map(options.size, 7).normals;
  MovmfSettings settings;
  make_reference(settings);  // use every normal at every level
  settings.lobe_count = options.lobes;
  const MipSchedule schedule = make_mip_schedule(map.width, map.height, settings);
  std::vector<MultumVmfLobe> parent(static_cast<std::size_t>(options.lobes));
  for (int j = 0; j < options.lobes; ++j) {
    const float phi = 6.2831853f * static_cast<float>(j) / static_cast<float>(options.lobes);
    parent[static_cast<std::size_t>(j)] = {0.4f * std::cos(phi), 0.4f * std::sin(phi), 0.7f,
                                           1.0f / static_cast<float>(options.lobes)};
  }
  Json levels = Json::array();
  ContentHash hash;
  for (const LevelSchedule& level : schedule.levels) {
    if (level.fit.parent_width == 0) continue;  // without a parent, other kernels start the level
    progress_advance(progress, 0);              // lets the user cancel
    // Each level starts from the next coarser level, which the kernels have fitted.
    LevelBench bench(device, map, level, parent, options);
    levels.push_back(run_level(bench, level.level, options, instructions));
    parent = bench.kernel_result();
    hash.update(parent.data(), parent.size() * sizeof(MultumVmfLobe));
    fmt::print(stderr, "level {}: {} ms\n", level.level, rounded_text(levels.back()["kernels_ms"].get<double>()));
  }
  const double ours = sum_over_levels(levels, "kernels_ms");
  const double evaluations = static_cast<double>(options.size) * options.size * options.lobes * options.iterations *
                             static_cast<double>(levels.size());
  Json result = {{"device", device.info().name},
                 {"size", options.size},
                 {"lobes", options.lobes},
                 {"iterations", options.iterations},
                 {"repetitions", options.repetitions},
                 {"threads", options.threads},
                 {"kernels_ms", ours},
                 {"evaluations_per_s", evaluations / ours * 1e3},
                 {"result_hash", hash.finish()},
                 {"levels", levels}};
  if (options.yardstick) {
    const double theirs = sum_over_levels(levels, "yardstick_ms");
    result["yardstick_instructions"] = instructions_name(instructions);
    result["yardstick_ms"] = theirs;
    result["ratio"] = ours / theirs;
  }
  return result;
}

namespace {

std::string threads_text(const Json& result) {
  const int threads = result.at("threads").get<int>();
  return threads > 0 ? fmt::format("{} threads", threads) : "the fastest number of threads for each level";
}

ResultView view_kernels(const Json& result) {
  MarkdownTable table({"level", "kernels, ms"});
  for (const Json& level : result.at("levels"))
    table.add({std::to_string(level.at("level").get<int>()), rounded_text(level.at("kernels_ms").get<double>())});
  table.add({"all", rounded_text(result.at("kernels_ms").get<double>())});
  return {"EM kernels",
          fmt::format(
              "The benchmark fits the four-quarter map of {0} x {0} texels by EM, with {1} lobes and {2} "
              "iterations, on every level except for the coarsest level. Times are medians of {3} runs. The kernels "
              "computed {4} billion lobe evaluations per second.",
              result.at("size").get<int>(), result.at("lobes").get<int>(), result.at("iterations").get<int>(),
              result.at("repetitions").get<int>(), rounded_text(result.at("evaluations_per_s").get<double>() / 1e9)),
          table.text()};
}

}  // namespace

ResultView view_em(const Json& result) {
  if (!result.contains("yardstick_ms")) return view_kernels(result);
  MarkdownTable table({"level", "kernels, ms", "yardstick, ms", "ratio", "mean difference"});
  for (const Json& level : result.at("levels")) {
    const Json& quartiles = level.at("ratio_quartiles");
    table.add(
        {std::to_string(level.at("level").get<int>()), rounded_text(level.at("kernels_ms").get<double>()),
         rounded_text(level.at("yardstick_ms").get<double>()),
         spread_text({level.at("ratio").get<double>(), quartiles.at(0).get<double>(), quartiles.at(1).get<double>()}),
         fmt::format("{:.1e}", level.at("mean_difference").get<double>())});
  }
  table.add({"all", rounded_text(result.at("kernels_ms").get<double>()),
             rounded_text(result.at("yardstick_ms").get<double>()), rounded_text(result.at("ratio").get<double>()),
             "-"});
  return {"EM kernels compared with plain C++",
          fmt::format(
              "The benchmark fits the four-quarter map of {0} x {0} texels by EM, with {1} lobes and {2} iterations, "
              "on every level except for the coarsest level. The yardstick program "
              "(`tools/lab/bench/yardsticks/em_yardstick.cpp`) computes the same sums in C++ with {6} and OpenMP, on "
              "{3}. The benchmark ran the kernels and the yardstick alternately with the same starting values, in {4} "
              "pairs of runs per "
              "level. Each ratio compares the two runs of a pair. The last row compares the sums of the medians. *Mean "
              "difference* is the mean difference between the amplitudes and first moments of the kernels and "
              "of the yardstick. If a texel has more lobes than normals, several optima are equally good, and rounding "
              "selects "
              "one of them. The kernels computed {5} billion lobe evaluations per second.",
              result.at("size").get<int>(), result.at("lobes").get<int>(), result.at("iterations").get<int>(),
              threads_text(result), result.at("repetitions").get<int>(),
              rounded_text(result.at("evaluations_per_s").get<double>() / 1e9),
              result.value("yardstick_instructions", "16-wide vectors")),
          table.text()};
}

}  // namespace multum::bench
