// SPDX-License-Identifier: Apache-2.0
// Writes the text of a result of `multum-bench infer`.
#include <fmt/format.h>

#include "host/fields/inference/solver/texture_inference.h"
#include "tools/lab/bench/documents/markdown_table.h"
#include "tools/lab/bench/inference_benchmark.h"
#include "tools/lab/bench/measuring/statistics.h"

namespace multum::bench {
namespace {

using Json = nlohmann::ordered_json;

std::string solver_table(const Json& systems) {
  MarkdownTable table({"system", "form", "iteration, ms", "iteration by Eigen, ms", "ratio", "whole solve, ms",
                       "ratio of solves", "three columns at once, ms", "ratio to three columns", "regularised, ms",
                       "largest difference"});
  for (const Json& system : systems) {
    const Json& solver = system.at("solver");
    std::vector<std::string> row = {system.at("system"), solver.at("form")};
    for (const char* key : {"iteration_ms", "yardstick_iteration_ms", "iteration_ratio", "solve_ms", "solve_ratio",
                            "three_columns_iteration_ms", "three_columns_ratio", "regularised_iteration_ms"})
      row.push_back(spread_text(parse_spread(solver.at(key))));
    row.push_back(fmt::format("{:.1e}", solver.at("largest_difference").get<double>()));
    table.add(row);
  }
  return table.text();
}

std::string product_table(const Json& systems) {
  MarkdownTable table(
      {"system", "rows", "entries of A", "entries of A^T A", "product", "time, ms", "products per ms", "GB/s"});
  for (const Json& system : systems)
    for (const Json& product : system.at("products")) {
      const Spread ms = parse_spread(product.at("ms"));
      table.add({system.at("system"), std::to_string(system.at("rows").get<std::size_t>()),
                 std::to_string(system.at("entries").get<std::size_t>()),
                 std::to_string(system.at("normal_entries").get<std::size_t>()), product.at("product"), spread_text(ms),
                 rounded_text(1.0 / ms.median), rounded_text(product.at("gb_per_s").get<double>())});
    }
  return table.text();
}

std::string convergence_table(const Json& systems) {
  MarkdownTable table({"system", "pyramid_weight", "preconditioned, from start_texels()", "preconditioned, from 0",
                       "plain, from start_texels()", "plain, from 0"});
  for (const Json& system : systems) {
    const Json& counts = system.at("convergence");
    for (std::size_t i = 0; i + 3 < counts.size(); i += 4) {
      std::vector<std::string> row = {system.at("system"),
                                      fmt::format("{}", counts[i].at("pyramid_weight").get<double>())};
      for (std::size_t k = i; k < i + 4; ++k) {
        const Json& count = counts[k].at("iterations");
        row.push_back(count.is_null() ? fmt::format("> {}", InferenceSettings().iteration_max)
                                      : std::to_string(count.get<int>()));
      }
      table.add(row);
    }
  }
  return table.text();
}

std::string form_table(const Json& forms) {
  MarkdownTable table({"views", "sub-pixels", "entries of A", "entries of A^T A", "ratio of entries", "A and A^T, ms",
                       "A^T A, ms", "ratio of times", "making A^T A, ms"});
  for (const Json& form : forms)
    table.add({std::to_string(form.at("views").get<int>()), fmt::format("{0} x {0}", form.at("sub_pixels").get<int>()),
               std::to_string(form.at("entries").get<std::size_t>()),
               std::to_string(form.at("normal_entries").get<std::size_t>()),
               rounded_text(form.at("entry_ratio").get<double>()), rounded_text(form.at("matrix_ms").get<double>()),
               rounded_text(form.at("normal_ms").get<double>()), rounded_text(form.at("time_ratio").get<double>()),
               rounded_text(form.at("making_ms").get<double>())});
  return table.text();
}

}  // namespace

ResultView view_inference(const Json& result) {
  const Json& systems = result.at("systems");
  std::string yardsticks;
  for (const Json& system : systems)
    yardsticks += (yardsticks.empty() ? "" : "; ") + system.at("solver").at("yardstick").get<std::string>() + " (" +
                  system.at("system").get<std::string>() + ")";
  const int size = result.at("size").get<int>(), iterations = result.at("iterations").get<int>();
  return {
      "Texture inference against Eigen",
      fmt::format(
          "Pictures of {0} x {1} pixels show a plane with a texture of {2} x {2} texels. The system of equations has "
          "three colours and no regularisers. Both programs compute in single precision, and start with all texels at "
          "0.5. "
          "The pictures are computed from the texture itself and have little contrast, so no texel reaches the limits "
          "of its range. "
          "Both programs therefore compute the same steps of the preconditioned conjugate gradient method. *Eigen* is "
          "the fastest variant of Eigen's `LeastSquaresConjugateGradient`, with one solve per colour. (Eigen solves "
          "three columns in the same way.) Eigen was compiled for this machine. Its fastest variants were {3}. "
          "*Iteration* is the time per iteration. It is the time of {4} iterations minus the time of {5} iterations, "
          "divided "
          "by the difference in the number of iterations. *Whole solve* is the time of {4} iterations, including all "
          "preparation. *Three "
          "columns at once* is the time of an iteration that solves for all colours together. This column uses "
          "a solver written with Eigen's matrix products, because Eigen has no such solver. *Regularised* is the time "
          "of "
          "multum's iteration with the default pyramid_weight, which Eigen does not support. The programs ran "
          "alternately in {6} pairs on {7} threads, and each ratio compares the two runs of a pair. *Largest "
          "difference* is the largest difference between multum's and Eigen's texels (0 to 1) after {4} iterations.",
          size * 5 / 4, size * 15 / 16, size, yardsticks, iterations, iterations / 4,
          result.at("repetitions").get<int>(), result.at("threads").get<int>()),
      solver_table(systems) +
          "\nThe next table lists the times of matrix products for three colours. For the column *GB/s*, each "
          "vector counts once, and the matrix counts with its stored size, in blocks of 8 entries.\n\n" +
          product_table(systems) +
          "\n"
          "The next table lists the number of iterations until the gradient falls to 1e-3 of the gradient of a black "
          "texture. The textures have full contrast, and the solver chooses its steps as usual.\n\n" +
          convergence_table(systems) +
          "\n"
          "For stacked pictures, the next table compares two methods. One method multiplies by A and then by "
          "A^T, and the other method multiplies by the matrix A^T A. The solver uses A^T A if this matrix has fewer "
          "than twice as many entries as A "
          "(`kNormalEntriesMax`, `host/fields/inference/solver/texture_system.cpp`). Products with A^T A are "
          "still faster if A^T A has somewhat more entries than this, but computing A^T A takes time.\n\n" +
          form_table(result.at("forms"))};
}

}  // namespace multum::bench
