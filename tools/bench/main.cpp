// SPDX-License-Identifier: Apache-2.0
// multum-bench: two programs in one run, in turns, ratios with their spread.
#include <CLI/CLI.hpp>
#include <cstdlib>

#include "host/base/error.h"
#include "tools/bench/accuracy_document.h"
#include "tools/bench/em_benchmark.h"

namespace {

int run(int argc, char** argv) {
  CLI::App app("multum-bench: benchmarks that pair multum with a yardstick in one run and report ratios");
  app.require_subcommand(1);
  multum::bench::EmBenchmarkOptions em;
  CLI::App* em_command = app.add_subcommand("em", "EM kernels against a plain C++ SIMD yardstick");
  em_command->add_option("--size", em.size, "side of the map, a power of two")
      ->check(CLI::IsMember({64, 128, 256, 512, 1024, 2048, 4096}))
      ->capture_default_str();
  em_command->add_option("--lobes", em.lobes, "lobes a texel")->check(CLI::IsMember({4, 6, 8}))->capture_default_str();
  em_command->add_option("--iterations", em.iterations)->check(CLI::Range(1, 100))->capture_default_str();
  em_command->add_option("--repetitions", em.repetitions, "pairs of runs a level")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  em_command->add_option("--threads", em.threads)->check(CLI::Range(1, 256))->capture_default_str();
  em_command->add_option("--json", em.json, "write the result here too");
  multum::bench::AccuracyDocumentOptions accuracy;
  CLI::App* accuracy_command = app.add_subcommand("accuracy", "make docs/ACCURACY.md: every figure of it");
  accuracy_command->add_option("-o,--output", accuracy.output, "Markdown file to write")->required();
  accuracy_command->add_option("--maps", accuracy.maps, "folder of real maps")->check(CLI::ExistingDirectory);
  accuracy_command->add_option("--size", accuracy.size, "side of the four-quarter map")
      ->check(CLI::Range(16, 4096))
      ->capture_default_str();
  accuracy_command->add_option("--commit", accuracy.commit, "named in the document")->default_val("unknown");
  accuracy_command->add_option("--threads", accuracy.threads)->check(CLI::Range(1, 256))->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : multum::exit_code(multum::ErrorCode::kUsage);
  }
  const int threads = accuracy_command->parsed() ? accuracy.threads : em.threads;
  setenv("POCL_MAX_PTHREAD_COUNT", std::to_string(threads).c_str(), 1);
  if (accuracy_command->parsed()) return multum::bench::write_accuracy_document(accuracy);
  return multum::bench::run_em_benchmark(em);
}

}  // namespace

int main(int argc, char** argv) { return multum::run_guarded("multum-bench", run, argc, argv); }
