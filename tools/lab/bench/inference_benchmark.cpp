// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/inference_benchmark.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "host/fields/inference/solver/texture_inference.h"
#include "host/fields/inference/solver/texture_system.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "tools/lab/bench/measuring/elapsed.h"
#include "tools/lab/bench/measuring/plane_views.h"
#include "tools/lab/bench/measuring/statistics.h"
#include "tools/lab/bench/yardsticks/inference_yardstick.h"

namespace multum::bench {
namespace {

using Json = nlohmann::ordered_json;

// Stacks of pictures that differ in one ratio: the number of entries of A^T A, divided by the number of entries of A.
// Rows with few entries share texels with many rows of other pictures in the stack. Averaged rows have many entries,
// and A^T A combines each entry with all other entries.
struct StackShape {
  int views, sub_pixels;
};
constexpr StackShape kStacks[] = {{1, 1}, {2, 1}, {4, 1}, {8, 1}, {1, 2}, {2, 2},
                                  {4, 2}, {8, 2}, {1, 3}, {2, 3}, {1, 4}};
// Contrast of the textures for timed solves, and for counting iterations. At the low contrast, rarely seen texels stay
// within the bounds even though conjugate gradient overshoots many times, so both solvers do the same work.
constexpr double kTimedContrast = 0.02, kCountedContrast = 0.3;
constexpr int kLaunchesATime = 4;  // number of launches per timed product, which is so large that the final wait hardly
                                   // matters

// Pictures of one texture. Their matrices are stacked.
struct Stack {
  std::vector<FilterMatrix> matrices;
  std::vector<InferenceView> views;
  SparseRows rows, columns;
  std::vector<float> colours, contrasted_colours;  // textures with low and with high contrast

  Stack(int texture_side, int view_count, int sub_pixels, int threads) {
    for (int v = 0; v < view_count; ++v)
      matrices.push_back(plane_filter_matrix({texture_side, v, sub_pixels}, threads));
    for (const FilterMatrix& matrix : matrices) {
      views.push_back({&matrix, std::vector<float>(matrix.row_count(), 1.0f)});
      append_weighted_rows(views.back(), rows);
    }
    const MipLayout layout = matrices.front().layout();
    columns = transposed(rows, static_cast<std::size_t>(layout.texel_count));
    colours = picture(plane_texels(layout, kTimedContrast));
    contrasted_colours = picture(plane_texels(layout, kCountedContrast));
  }
  Stack(const Stack&) = delete;

  std::size_t texel_count() const { return columns.row_count(); }

  std::vector<float> picture(const std::vector<float>& texels) const {
    std::vector<float> result(3 * rows.row_count(), 0.0f);
    for (std::size_t r = 0; r < rows.row_count(); ++r)
      for (std::uint32_t i = rows.begin[r]; i < rows.begin[r + 1]; ++i)
        for (std::size_t c = 0; c < 3; ++c) result[3 * r + c] += rows.weights[i] * texels[3 * rows.columns[i] + c];
    return result;
  }

  // Returns |A x - b| / |b|.
  double residual(const std::vector<float>& texels) const {
    const std::vector<float> found = picture(texels);
    double above = 0.0, below = 0.0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const double b = static_cast<double>(colours[i]), difference = static_cast<double>(found[i]) - b;
      above += difference * difference;
      below += b * b;
    }
    return std::sqrt(above / below);
  }
};

double largest_difference(const std::vector<float>& a, const std::vector<float>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(static_cast<double>(a[i] - b[i])));
  return largest;
}

std::size_t count_at_bounds(const std::vector<float>& texels) {
  return static_cast<std::size_t>(
      std::count_if(texels.begin(), texels.end(), [](float x) { return x <= 0.0f || x >= 1.0f; }));
}

// Returns settings for this many iterations of the conjugate gradient method. As in the yardstick, there are no
// regularisers and there is only one step.
InferenceSettings plain_settings(int iterations, InferenceForm form) {
  InferenceSettings settings;
  settings.pyramid_weight = 0.0;
  settings.gradient_tolerance = 0.0;
  settings.step_tolerance = 0.0;
  settings.iteration_max = iterations;
  settings.form = form;
  return settings;
}

// Solves twice with each variant, using a few iterations, and chooses the variant with the shortest time.
YardstickWay fastest_way(const Stack& stack, const std::vector<YardstickWay>& ways, const std::vector<float>& start) {
  YardstickWay fastest = ways.front();
  double least = std::numeric_limits<double>::infinity();
  for (const YardstickWay& way : ways) {
    const auto yardstick = make_inference_yardstick(stack.rows, stack.texel_count(), way);
    double ms = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 2; ++i) ms = std::min(ms, milliseconds_of([&] { yardstick->solve(stack.colours, start, 3); }));
    fmt::print(stderr, "  {}: {} ms\n", yardstick_name(way), rounded_text(ms));
    if (ms < least) fastest = way;
    least = std::min(least, ms);
  }
  return fastest;
}

// Times of whole solves and of single iterations.
struct SolveTimes {
  std::vector<double> solve, iteration;

  template <typename Solve>
  void add(int few, int many, const Solve& solve_with) {
    const double short_ms = milliseconds_of([&] { solve_with(few); });
    solve.push_back(milliseconds_of([&] { solve_with(many); }));
    iteration.push_back((solve.back() - short_ms) / (many - few));
  }
};

std::vector<double> ratios_of(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < a.size(); ++i) ratios.push_back(a[i] / b[i]);
  return ratios;
}

Json run_solver(Device& device, const Stack& stack, InferenceForm form, const InferenceBenchmarkOptions& options,
                ContentHash& hash, Progress* progress) {
  const int many = options.iterations, few = many / 4;
  TextureInference whole(device, stack.views, plain_settings(many, form), options.threads);
  TextureInference part(device, stack.views, plain_settings(few, form), options.threads);
  const std::vector<float> start(3 * stack.texel_count(), 0.5f);
  std::vector<YardstickWay> ways = {{YardstickForm::kRowMajor, options.threads},
                                    {YardstickForm::kColumnMajor, options.threads}};
  if (options.threads > 1) ways.insert(ways.end(), {{YardstickForm::kRowMajor, 1}, {YardstickForm::kColumnMajor, 1}});
  const YardstickWay eigens = fastest_way(stack, ways, start);
  const YardstickWay three{YardstickForm::kThreeColumns, options.threads};
  const auto eigen = make_inference_yardstick(stack.rows, stack.texel_count(), eigens);
  const auto three_columns = make_inference_yardstick(stack.rows, stack.texel_count(), three);
  InferenceSettings regularised = plain_settings(many, form);
  regularised.pyramid_weight = InferenceSettings().pyramid_weight;
  TextureInference regularised_whole(device, stack.views, regularised, options.threads);
  regularised.iteration_max = few;
  TextureInference regularised_part(device, stack.views, regularised, options.threads);
  InferenceResult found;
  std::vector<float> expected;
  SolveTimes ours, theirs, threes, pyramids;
  for (int i = -1; i < options.repetitions; ++i) {
    if (i == 0) ours = theirs = threes = pyramids = SolveTimes();  // the first round only warms up caches
    ours.add(few, many, [&](int count) { found = (count == many ? whole : part).solve(stack.colours, start); });
    theirs.add(few, many, [&](int count) { expected = eigen->solve(stack.colours, start, count); });
    threes.add(few, many, [&](int count) { three_columns->solve(stack.colours, start, count); });
    pyramids.add(few, many, [&](int count) {
      (count == many ? regularised_whole : regularised_part).solve(stack.colours, start);
    });
    progress_advance(progress, 0);
  }
  MULTUM_CHECK(found.iterations == many);
  hash.update(found.texels.data(), found.texels.size() * sizeof(float));
  return {{"form", whole.uses_normal_form() ? "A^T A" : "A, A^T"},
          {"iteration_ms", spread_json(spread_of(ours.iteration))},
          {"solve_ms", spread_json(spread_of(ours.solve))},
          {"yardstick", yardstick_name(eigens)},
          {"yardstick_iteration_ms", spread_json(spread_of(theirs.iteration))},
          {"yardstick_solve_ms", spread_json(spread_of(theirs.solve))},
          {"iteration_ratio", spread_json(spread_of(ratios_of(ours.iteration, theirs.iteration)))},
          {"solve_ratio", spread_json(spread_of(ratios_of(ours.solve, theirs.solve)))},
          {"three_columns_iteration_ms", spread_json(spread_of(threes.iteration))},
          {"three_columns_ratio", spread_json(spread_of(ratios_of(ours.iteration, threes.iteration)))},
          {"regularised_iteration_ms", spread_json(spread_of(pyramids.iteration))},
          {"largest_difference", largest_difference(found.texels, expected)},
          {"at_bounds", count_at_bounds(found.texels)},
          {"residual", stack.residual(found.texels)},
          {"yardstick_residual", stack.residual(expected)}};
}

struct Product {
  const char* name;
  DeviceRows rows;
  DeviceBuffer from, to;
  std::vector<double> ms = {};
};

// Times the three products alternately.
Json run_products(Device& device, const Stack& stack, const SparseRows& normal, int repetitions) {
  std::vector<Product> products;
  const auto add = [&](const char* name, const SparseRows& rows, std::size_t column_count) {
    const std::vector<Colour4> values(column_count, Colour4{0.5f, 0.5f, 0.5f, 0.0f});
    Product product{name, DeviceRows(device, rows, name), device.make_buffer(column_count * sizeof(Colour4), name),
                    device.make_buffer(rows.row_count() * sizeof(Colour4), name)};
    device.write(product.from, values.data(), product.from.byte_count());
    products.push_back(std::move(product));
  };
  add("A", stack.rows, stack.texel_count());
  add("A^T", stack.columns, stack.rows.row_count());
  add("A^T A", normal, stack.texel_count());
  Kernel kernel = device.kernel("filter_matrix_spmv", "filter_matrix_spmv", {1, 1, false});
  for (int i = -1; i < repetitions; ++i)
    for (Product& product : products) {
      const double ms = milliseconds_of([&] {
        for (int k = 0; k < kLaunchesATime; ++k) product.rows.multiply(kernel, product.from, product.to);
        device.finish();
      });
      if (i >= 0) product.ms.push_back(ms / kLaunchesATime);
    }
  Json result = Json::array();
  for (const Product& product : products) {
    const Spread ms = spread_of(product.ms);
    const auto bytes =
        static_cast<double>(product.rows.byte_count() + product.from.byte_count() + product.to.byte_count());
    result.push_back(
        {{"product", product.name}, {"ms", spread_json(ms)}, {"bytes", bytes}, {"gb_per_s", bytes / ms.median / 1e6}});
  }
  return result;
}

// Counts the iterations that the solver needs to reach its own tolerance. Returns null if the solver reaches the
// iteration limit first.
Json run_convergence(Device& device, const Stack& stack, InferenceForm form, int threads) {
  Json result = Json::array();
  const std::vector<float> zero(3 * stack.texel_count(), 0.0f);
  for (const double pyramid_weight : {0.0, InferenceSettings().pyramid_weight})
    for (const bool precondition : {true, false}) {
      InferenceSettings settings;
      settings.pyramid_weight = pyramid_weight;
      settings.precondition = precondition;
      settings.form = form;
      TextureInference inference(device, stack.views, settings, threads);
      for (const bool is_started : {true, false}) {
        const InferenceResult found =
            inference.solve(stack.contrasted_colours, is_started ? std::vector<float>() : zero);
        result.push_back({{"pyramid_weight", pyramid_weight},
                          {"precondition", precondition},
                          {"start_texels", is_started},
                          {"iterations", found.converged ? Json(found.iterations) : Json()}});
      }
    }
  return result;
}

double median_ms(const Json& products, std::size_t number) { return parse_spread(products[number].at("ms")).median; }

Json run_forms(Device& device, const InferenceBenchmarkOptions& options, Progress* progress) {
  Json forms = Json::array();
  for (const auto& [views, sub_pixels] : kStacks) {
    if (views > options.views) continue;
    const Stack stack(options.size, views, sub_pixels, options.threads);
    SparseRows normal;
    const double making = milliseconds_of([&] { normal = normal_rows(stack.rows, stack.columns, options.threads); });
    const Json products = run_products(device, stack, normal, options.repetitions);
    const double both = median_ms(products, 0) + median_ms(products, 1), one = median_ms(products, 2);
    const double entries = static_cast<double>(stack.rows.columns.size());
    forms.push_back({{"views", views},
                     {"sub_pixels", sub_pixels},
                     {"entries", stack.rows.columns.size()},
                     {"normal_entries", normal.columns.size()},
                     {"entry_ratio", static_cast<double>(normal.columns.size()) / entries},
                     {"matrix_ms", both},
                     {"normal_ms", one},
                     {"time_ratio", one / both},
                     {"making_ms", making}});
    fmt::print(stderr, "{} views, {} x {}: entries {}, time {}\n", views, sub_pixels, sub_pixels,
               rounded_text(forms.back()["entry_ratio"].get<double>()), rounded_text(one / both));
    progress_advance(progress, 0);
  }
  return forms;
}

Json run_system(Device& device, const std::string& name, const Stack& stack, InferenceForm form,
                const InferenceBenchmarkOptions& options, ContentHash& hash, Progress* progress) {
  const SparseRows normal = normal_rows(stack.rows, stack.columns, options.threads);
  Json result = {{"system", name},
                 {"rows", stack.rows.row_count()},
                 {"texels", stack.texel_count()},
                 {"entries", stack.rows.columns.size()},
                 {"normal_entries", normal.columns.size()}};
  result["products"] = run_products(device, stack, normal, options.repetitions);
  result["solver"] = run_solver(device, stack, form, options, hash, progress);
  result["convergence"] = run_convergence(device, stack, form, options.threads);
  fmt::print(stderr, "{}: {} times the yardstick's time per iteration\n", name,
             rounded_text(parse_spread(result["solver"]["iteration_ratio"]).median));
  return result;
}

}  // namespace

Json run_inference_benchmark(const InferenceBenchmarkOptions& options, Progress* progress) {
  Device device = Device::open(options.device);
  Json systems = Json::array();
  ContentHash hash;
  const auto add = [&](const std::string& name, const Stack& stack, InferenceForm form) {
    systems.push_back(run_system(device, name, stack, form, options, hash, progress));
  };
  add("one view", Stack(options.size, 1, 1, options.threads), InferenceForm::kAuto);
  add("one view, 4 x 4 sub-pixels", Stack(options.size, 1, 4, options.threads), InferenceForm::kAuto);
  add(fmt::format("{} views", options.views), Stack(options.size, options.views, 1, options.threads),
      InferenceForm::kNormal);
  return {{"device", device.info().name},
          {"size", options.size},
          {"iterations", options.iterations},
          {"repetitions", options.repetitions},
          {"threads", options.threads},
          {"systems", systems},
          {"forms", run_forms(device, options, progress)},
          {"result_hash", hash.finish()}};
}

}  // namespace multum::bench
