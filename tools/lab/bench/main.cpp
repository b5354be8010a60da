// SPDX-License-Identifier: Apache-2.0
// multum-bench runs two programs alternately, and reports the ratios of their costs with the spread of these ratios. It
// also writes documents with such figures.
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <functional>

#include "host/formats/opencl/pocl_settings.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "tools/command_line/before_command.h"
#include "tools/command_line/choices.h"
#include "tools/command_line/usage_error.h"
#include "tools/lab/bench/bake_benchmark.h"
#include "tools/lab/bench/batch_benchmark.h"
#include "tools/lab/bench/build_info.h"
#include "tools/lab/bench/documents/accuracy_document.h"
#include "tools/lab/bench/documents/benchmarks_document.h"
#include "tools/lab/bench/documents/coverage_document.h"
#include "tools/lab/bench/documents/result_file.h"
#include "tools/lab/bench/em_benchmark.h"
#include "tools/lab/bench/filter_benchmark.h"
#include "tools/lab/bench/frames_benchmark.h"
#include "tools/lab/bench/inference_benchmark.h"
#include "tools/lab/bench/load_benchmark.h"
#include "tools/lab/bench/measuring/command_text.h"
#include "tools/lab/bench/measuring/gl_contexts.h"
#include "tools/lab/bench/measuring/instructions.h"
#include "tools/lab/bench/on_gpu.h"
#include "tools/lab/bench/scale_benchmark.h"

namespace multum::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kDeviceHelp =
    "OpenCL device: a number of `multum devices` or part of a name (default: a GPU first)";
constexpr int kSizeMin = 16, kSizeMax = 32768;  // limits of `multum testmap`

const Choices<Instructions> kInstructions = {{"avx2", Instructions::kAvx2}, {"avx512", Instructions::kAvx512}};

// Returns the command line without the result file, which does not affect the measurement.
std::string command_line(int argc, char** argv) {
  std::vector<std::string> command = {"multum-bench"};
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--json") ++i;
    else if (!argument.starts_with("--json=")) command.push_back(argument);
  }
  return command_text(command);
}

// Contains a subcommand, its result file (empty if there is none), and the function that runs the subcommand with its
// options.
struct Benchmark {
  CLI::App* command;
  std::string json;
  std::function<Json(Progress*)> run;
};

CLI::Option* add_side(CLI::App& command, const std::string& option, int& side, const std::string& help) {
  const auto refuse_odd = [](const std::string& text) {
    const bool odd = !text.empty() && std::string("13579").find(text.back()) != std::string::npos;
    return odd ? text + " is odd, expected an even number" : std::string();
  };
  const CLI::Validator even(refuse_odd, "even");
  return command.add_option(option, side, help)->check(CLI::Range(kSizeMin, kSizeMax) & even)->capture_default_str();
}

template <typename Options>
void add_bake_options(CLI::App& command, Options& options) {
  command.add_option("--lobes", options.lobes, "lobes per texel")->check(CLI::Range(1, 8))->capture_default_str();
  command.add_option("--threads", options.threads, "threads to use (default: all cores)")->check(CLI::Range(1, 1024));
  command.add_option("--folder", options.folder, "folder for temporary maps and results (default: $TMPDIR, /tmp)")
      ->check(CLI::ExistingDirectory);
}

template <typename Options>
void add_repetitions(CLI::App& command, Options& options, const std::string& help) {
  command.add_option("--repetitions", options.repetitions, help)->check(CLI::Range(1, 1000))->capture_default_str();
}

Benchmark add_em(CLI::App& app, EmBenchmarkOptions& em) {
  CLI::App* command = app.add_subcommand("em", "compare the EM kernels with plain C++ (SIMD)");
  command->add_option("--size", em.size, "side of the map, a power of two")
      ->check(CLI::IsMember({64, 128, 256, 512, 1024, 2048, 4096}))
      ->capture_default_str();
  command->add_option("--lobes", em.lobes, "lobes per texel")->check(CLI::IsMember({4, 6, 8}))->capture_default_str();
  command->add_option("--iterations", em.iterations)->check(CLI::Range(1, 100))->capture_default_str();
  add_repetitions(*command, em, "pairs of runs per level");
  command->add_option("--threads", em.threads, "if 0, the fastest number for each level is used")
      ->check(CLI::Range(0, 256))
      ->capture_default_str();
  command->add_option("--device", em.device, kDeviceHelp);
  add_choice(*command, "--instructions", em.instructions, kInstructions,
             "vector instructions for the yardstick and for kernels on PoCL (default: the widest)");
  command->add_flag("!--no-yardstick", em.yardstick, "time only the kernels");
  return {command, "", [&em](Progress* progress) {
            if (em.threads > 0) set_pocl_threads(em.threads);
            return run_em_benchmark(em, progress);
          }};
}

Benchmark add_infer(CLI::App& app, InferenceBenchmarkOptions& infer) {
  CLI::App* command = app.add_subcommand("infer", "compare the solver of texture inference with Eigen");
  command->add_option("--size", infer.size, "side of the texture, a power of two")
      ->check(CLI::IsMember({32, 64, 128, 256, 512, 1024, 2048}))
      ->capture_default_str();
  command->add_option("--views", infer.views, "number of views in the largest stack")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command->add_option("--iterations", infer.iterations, "iterations of a timed solve")
      ->check(CLI::Range(4, 400))
      ->capture_default_str();
  add_repetitions(*command, infer, "pairs of runs");
  command->add_option("--threads", infer.threads)->check(CLI::Range(1, 256))->capture_default_str();
  command->add_option("--device", infer.device, kDeviceHelp);
  return {command, "", [&infer](Progress* progress) {
            set_pocl_threads(infer.threads);
            return run_inference_benchmark(infer, progress);
          }};
}

Benchmark add_bake(CLI::App& app, BakeBenchmarkOptions& bake) {
  CLI::App* command = app.add_subcommand(
      "bake", "compare the time, processor time and memory of multum bake and of maketx --bumpslopes");
  add_side(*command, "--size", bake.size, "side of the map");
  add_bake_options(*command, bake);
  add_repetitions(*command, bake, "pairs of runs");
  add_choice(*command, "--instructions", bake.instructions, kInstructions,
             "vector instructions of multum's kernels on PoCL (default: the widest)");
  command->add_option("options", bake.bake_options, "after --: more options of multum bake");
  return {command, "", [&bake](Progress* progress) { return run_bake_benchmark(bake, progress); }};
}

Benchmark add_batch(CLI::App& app, BatchBenchmarkOptions& batch) {
  CLI::App* command = app.add_subcommand(
      "batch", "compare multum bake of many small maps in one process with one process of maketx per map");
  add_side(*command, "--size-min", batch.size_min, "side of the smallest maps");
  add_side(*command, "--size-max", batch.size_max, "largest side; sides double from one group of maps to the next");
  command->add_option("--count", batch.count, "number of maps per side")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  add_bake_options(*command, batch);
  add_repetitions(*command, batch, "pairs of runs per side");
  add_choice(*command, "--instructions", batch.instructions, kInstructions,
             "vector instructions of multum's kernels on PoCL (default: the widest)");
  command->add_option("options", batch.bake_options, "after --: more options of multum bake");
  return {command, "", [&batch](Progress* progress) { return run_batch_benchmark(batch, progress); }};
}

Benchmark add_scale(CLI::App& app, ScaleBenchmarkOptions& scale) {
  CLI::App* command = app.add_subcommand(
      "scale", "measure the time of multum bake for maps that double in size, with one process per map");
  add_side(*command, "--size-min", scale.size_min, "side of the smallest map");
  add_side(*command, "--size-max", scale.size_max, "largest side; sides double from one map to the next");
  add_bake_options(*command, scale);
  add_repetitions(*command, scale, "runs per size");
  command->add_option("options", scale.bake_options, "after --: more options of multum bake");
  return {command, "", [&scale](Progress* progress) { return run_scale_benchmark(scale, progress); }};
}

Benchmark add_load(CLI::App& app, LoadBenchmarkOptions& load) {
  CLI::App* command = app.add_subcommand(
      "load",
      "for every encoding and compression, measure the file size and the times for writing, reading and upload to GL");
  add_side(*command, "--size", load.size, "side of the map");
  add_bake_options(*command, load);
  add_repetitions(*command, load, "runs per file");
  add_choice(*command, "--context", load.context, kContextBackends, "source of the GL context");
  return {command, "", [&load](Progress* progress) { return run_load_benchmark(load, progress); }};
}

Benchmark add_frames(CLI::App& app, FramesBenchmarkOptions& frames) {
  CLI::App* command = app.add_subcommand(
      "frames", "measure frame times of lobes, moments and harmonics, and compare them with averaged normals");
  add_side(*command, "--size", frames.size, "side of the map");
  const auto set_picture = [&frames](const std::string& text) {
    const bool is_size = std::sscanf(text.c_str(), "%dx%d", &frames.width, &frames.height) == 2;
    if (!is_size || frames.width < 1 || frames.height < 1 || frames.width > 8192 || frames.height > 8192)
      throw CLI::ValidationError("--picture", "is '" + text + "', expected WIDTHxHEIGHT, 1 to 8192 pixels each");
  };
  command->add_option_function<std::string>("--picture", set_picture,
                                            "size of the picture in pixels (default: 1920x1080)");
  add_repetitions(*command, frames, "runs per picture");
  command->add_option("--device", frames.device, kDeviceHelp);
  command->add_option("--folder", frames.folder, "folder for temporary bakes (default: $TMPDIR, /tmp)")
      ->check(CLI::ExistingDirectory);
  add_choice(*command, "--context", frames.context, kContextBackends, "source of the GL context");
  return {command, "", [&frames](Progress* progress) { return run_frames_benchmark(frames, progress); }};
}

Benchmark add_filters(CLI::App& app, FilterBenchmarkOptions& filters) {
  CLI::App* command = app.add_subcommand(
      "filters",
      "measure errors, flicker and frame times for several numbers of taps, level biases and numbers of lobes");
  command->add_option("--maps", filters.maps, "folder of normal maps (default: the four-quarter map)")
      ->check(CLI::ExistingDirectory);
  command->add_option("--maps-max", filters.maps_max, "number of maps, in the order of their names")
      ->check(CLI::Range(1, 100000));
  add_side(*command, "--size", filters.map_size, "side of the four-quarter map");
  command
      ->add_option("--reference-noise", filters.noise_max,
                   "largest noise of reference pictures, as a relative L1 error")
      ->check(CLI::Range(1e-4, 1.0))
      ->capture_default_str();
  command->add_option("--device", filters.device, kDeviceHelp);
  command->add_option("--folder", filters.folder, "folder for temporary bakes (default: $TMPDIR, /tmp)")
      ->check(CLI::ExistingDirectory);
  add_choice(*command, "--context", filters.context, kContextBackends, "source of the GL context");
  return {command, "", [&filters](Progress* progress) { return run_filter_benchmark(filters, progress); }};
}

CLI::App* add_on_gpu(CLI::App& app, OnGpuOptions& options, std::string& from) {
  CLI::App* command =
      app.add_subcommand("on-gpu", "measure multum on a GPU; write OUTPUT.json and OUTPUT.md after each step");
  command
      ->add_option("--minutes", options.minutes,
                   "minutes for all steps together; steps for which no time is left are skipped")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
  command->add_option("-o,--output", options.output, "name of both output files, without extension")
      ->capture_default_str();
  command->add_option("--device", options.device, kDeviceHelp);
  command->add_flag("--any-device", options.any_device, "without a GPU, use a processor and GL in software");
  command->add_flag("--small", options.small, "use only a few small maps, to try the command");
  command->add_option("--folder", options.folder, "folder for temporary maps and bakes (default: $TMPDIR, /tmp)")
      ->check(CLI::ExistingDirectory);
  command->add_option("--from", from, "measure nothing, and write the page of this OUTPUT.json to OUTPUT.md again")
      ->check(CLI::ExistingFile);
  return command;
}

CLI::App* add_coverage(CLI::App& app, CoverageDocumentOptions& coverage) {
  CLI::App* command = app.add_subcommand("coverage", "make the page about the coverage of error intervals");
  command->add_option("-o,--output", coverage.output, "Markdown file to write")->required();
  command->add_option("--maps", coverage.maps, "folder of normal maps")->required()->check(CLI::ExistingDirectory);
  command->add_option("--side", coverage.side, "side of the mosaic that replaces larger maps")
      ->check(CLI::Range(16, 4096))
      ->capture_default_str();
  command->add_option("--replicates", coverage.replicates, "choices of footprints")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
  command->add_option("--map-count", coverage.map_count, "number of maps, in the order of their names; all maps if 0")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--commit", coverage.commit, "commit that the document states")->default_val(built_commit());
  command->add_option("--threads", coverage.threads)->check(CLI::Range(1, 256))->capture_default_str();
  return command;
}

void add_allow_dirty(CLI::App& command, bool& allow_dirty) {
  command.add_flag("--allow-dirty", allow_dirty, "accept uncommitted sources, which the document states");
}

CLI::App* add_accuracy(CLI::App& app, AccuracyDocumentOptions& accuracy) {
  CLI::App* command = app.add_subcommand("accuracy", "make docs/evidence/ACCURACY.md");
  command->add_option("-o,--output", accuracy.output, "Markdown file to write")->required();
  command->add_option("--maps", accuracy.maps, "folder of real maps")->check(CLI::ExistingDirectory);
  command->add_option("--brdfs", accuracy.brdfs, "folder of measured BRDFs")->check(CLI::ExistingDirectory);
  command
      ->add_option("--section", accuracy.sections,
                   "make only these sections, and keep the others of an existing document (default: all)")
      ->check(CLI::IsMember(std::vector<std::string>(std::begin(kSections), std::end(kSections))));
  command->add_option("--size", accuracy.size, "side of the four-quarter map")
      ->check(CLI::Range(16, 4096))
      ->capture_default_str();
  command->add_option("--commit", accuracy.commit, "commit that the document states")->default_val(built_commit());
  command->add_flag("--quick", accuracy.is_quick,
                    "measure only a few settings of every representation, to try the page");
  add_allow_dirty(*command, accuracy.allow_dirty);
  command->add_option("--threads", accuracy.threads)->check(CLI::Range(1, 256))->capture_default_str();
  return command;
}

CLI::App* add_document(CLI::App& app, BenchmarksDocumentOptions& document) {
  CLI::App* command =
      app.add_subcommand("document", "make docs/evidence/BENCHMARKS.md from results, without running benchmarks");
  command->add_option("-o,--output", document.output, "Markdown file to write")->required();
  command
      ->add_option(
          "--json", document.results,
          "result file of em, bake, batch, scale, load, infer or frames; can be repeated for more results, which "
          "keep this order")
      ->required();
  add_allow_dirty(*command, document.allow_dirty);
  return command;
}

int run_benchmark(const Benchmark& benchmark, const std::string& command) {
  if (!benchmark.json.empty()) check_writable(benchmark.json);
  const auto progress = make_terminal_progress(false);  // handles Ctrl-C and removes temporary files
  const Json result = make_result(benchmark.command->get_name(), command, benchmark.run(progress.get()));
  const ResultView view = view_of(result);
  fmt::print("{}, on {}\n\n{}\n\n{}\nresult hash {}\n", view.title, result.at("device").get<std::string>(), view.method,
             view.table, result.at("result_hash").get<std::string>().substr(0, 16));
  if (!benchmark.json.empty()) write_text_file(benchmark.json, result.dump(2) + "\n");
  if (std::fflush(stdout) != 0) throw Error(ErrorCode::kEnvironment, "cannot write standard output");
  return 0;
}

int run(int argc, char** argv) {
  CLI::App app("multum-bench compares multum with other programs in one run, and reports ratios", "multum-bench");
  app.require_subcommand(1);
  app.failure_message(usage_error);
  EmBenchmarkOptions em;
  BakeBenchmarkOptions bake;
  BatchBenchmarkOptions batch;
  ScaleBenchmarkOptions scale;
  LoadBenchmarkOptions load;
  InferenceBenchmarkOptions infer;
  FramesBenchmarkOptions frames;
  FilterBenchmarkOptions filters;
  OnGpuOptions on_gpu;
  std::string on_gpu_from;
  std::vector<Benchmark> benchmarks = {add_em(app, em),         add_bake(app, bake),      add_batch(app, batch),
                                       add_scale(app, scale),   add_load(app, load),      add_infer(app, infer),
                                       add_frames(app, frames), add_filters(app, filters)};
  for (Benchmark& benchmark : benchmarks)
    benchmark.command->add_option("--json", benchmark.json,
                                  "also write the result to this file, for multum-bench document");
  AccuracyDocumentOptions accuracy;
  BenchmarksDocumentOptions document;
  CoverageDocumentOptions coverage;
  const CLI::App* coverage_command = add_coverage(app, coverage);
  const CLI::App* accuracy_command = add_accuracy(app, accuracy);
  const CLI::App* document_command = add_document(app, document);
  std::string contexts_json;
  CLI::App* contexts_command = app.add_subcommand("contexts", "list the GL contexts of this machine");
  contexts_command->add_option("--json", contexts_json, "also write the list to this file");
  const CLI::App* on_gpu_command = add_on_gpu(app, on_gpu, on_gpu_from);
  prepare_commands(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return print_parse_error(app, error);
  }
  if (document_command->parsed()) return write_benchmarks_document(document);
  for (const Benchmark& benchmark : benchmarks)
    if (benchmark.command->parsed()) return run_benchmark(benchmark, command_line(argc, argv));
  if (contexts_command->parsed()) {
    const Json contexts = list_gl_contexts();
    for (const Json& row : contexts)
      fmt::print(
          "{}: {}\n", row["display"].get<std::string>(),
          (row["description"].get<std::string>().empty() ? row["reason"] : row["description"]).get<std::string>());
    if (!contexts_json.empty()) write_text_file(contexts_json, contexts.dump(2) + "\n");
    return 0;
  }
  if (on_gpu_command->parsed()) {
    if (on_gpu_from.empty()) return run_on_gpu(on_gpu, command_line(argc, argv), make_terminal_progress(false).get());
    write_text_file(on_gpu.output + ".md", on_gpu_page(on_gpu_from));
    return 0;
  }
  if (coverage_command->parsed()) {
    set_pocl_threads(coverage.threads);
    return write_coverage_document(coverage);
  }
  MULTUM_CHECK(accuracy_command->parsed());
  set_pocl_threads(accuracy.threads);
  return write_accuracy_document(accuracy);
}

}  // namespace
}  // namespace multum::bench

int main(int argc, char** argv) { return multum::run_guarded("multum-bench", multum::bench::run, argc, argv); }
