// SPDX-License-Identifier: Apache-2.0
#include "tools/multum/share_plan_mode.h"

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "host/bakes/bake/job_parameters.h"
#include "host/bakes/bake/output_state.h"
#include "host/bakes/scene/share_cost.h"
#include "host/formats/asset/representation.h"
#include "host/formats/image/files/image_file.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/shown_text.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

constexpr std::int64_t kTexelsMax = std::int64_t{1} << 30;

// Reads the size from the first bytes of the file if the format allows it, otherwise with a library in a child process.
std::pair<int, int> map_size(const std::string& path) {
  const ImageContainer container = inspect_image_container(path, kTexelsMax);
  if (container.width > 0) return {static_cast<int>(container.width), static_cast<int>(container.height)};
  const auto file = open_image_file(path, {kTexelsMax, 1, false});
  return {file->part().width, file->part().height};
}

BakeShape shape_of(const BakeJob& job) {
  BakeShape shape;
  std::tie(shape.width, shape.height) = map_size(job.input);
  shape.representation = job.representation;
  shape.lobe_count = job.fitting.lobe_count;
  shape.sh_order = job.sh_order;
  shape.encoding = job.encoding;
  shape.first_level = job.fitting.first_level;
  shape.has_colours = !job.albedo.empty();
  shape.weight_count = job.weights.empty() ? 0 : 4;  // the maximum number in a file
  shape.exponent_count = job.measure ? static_cast<int>(job.measured_exponents.size()) : 0;
  return shape;
}

std::string seconds_text(double seconds) { return fmt::format("{:.{}f} s", seconds, seconds < 10.0 ? 1 : 0); }

std::string plan_text(const BakeJob& job, const BakeShape& shape, double whole, const ShareCost& cost) {
  std::string text = fmt::format("{}: {} x {}, {}{}\nprocessor time, predicted:\n", job.input, shape.width,
                                 shape.height, representation_info(shape.representation).option,
                                 holds_lobes(shape.representation) ? fmt::format(", {} lobes", shape.lobe_count) : "");
  const auto line = [&](const std::string& part, double seconds, const std::string& what) {
    text += fmt::format("  {:<14} {:>8}  {}\n", part, seconds_text(seconds), what);
  };
  line("one process", whole, "");
  const std::size_t count = cost.band_seconds.size();
  if (count == 0) return text + "not divided\n";
  line(fmt::format("--shard 0/{}", count), cost.coarse_seconds,
       fmt::format("reads the map, and fits level {} and all coarser levels", cost.coarse_from));
  for (std::size_t i = 0; i < count; ++i)
    line(fmt::format("--shard {}/{}", i + 1, count), cost.band_seconds[i],
         i == 0 ? fmt::format("each fits a band of the finer levels, after share 0/{}", count) : "");
  line(fmt::format("--merge {}", count), cost.merge_seconds,
       "measures the error and writes the file, after all shares");
  line("all", cost.total_seconds(), fmt::format("{:.2f} of one process", cost.total_seconds() / whole));
  return text;
}

}  // namespace

int run_share_plan(const SharePlanOptions& o) {
  check_scopes(o.values);
  BakeJob job;
  job.input = o.input;
  apply(o.values, job);
  const BakeShape shape = shape_of(job);
  const MovmfSettings settings = fitting_settings(job, job.reading.wrap_s, job.reading.wrap_t);
  validate(settings);
  const bool is_divided = holds_lobes(job.representation) && job.fitting.lobe_count > 1 && !job.fitting.refine &&
                          !o.values.has("target_error") && !o.values.has("budget_ms") && job.onto.empty();
  if (o.count > 0 && !is_divided)
    throw Error(ErrorCode::kUsage,
                "--shards needs a bake of at least two lobes per texel without --refine, --onto, --target-error or "
                "--budget-ms");
  const double whole = bake_processor_seconds(shape);
  const int count = o.count > 0 ? o.count : is_divided ? share_count_of(shape, settings, o.share_seconds) : 0;
  const ShareCost cost = count > 0 ? share_cost(shape, settings, count) : ShareCost{};
  if (!o.json) {
    write_shown(stdout, plan_text(job, shape, whole, cost));
    return 0;
  }
  OrderedJson json = {{"input", path_json(job.input)},
                      {"width", shape.width},
                      {"height", shape.height},
                      {"processor_seconds", whole},
                      {"shares", count}};
  if (count > 0)
    json.update({{"coarse_from_level", cost.coarse_from},
                 {"coarse_seconds", cost.coarse_seconds},
                 {"band_seconds", cost.band_seconds},
                 {"merge_seconds", cost.merge_seconds}});
  print_json(json);
  return 0;
}

}  // namespace multum
