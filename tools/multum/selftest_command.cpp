// SPDX-License-Identifier: Apache-2.0
// Implements multum selftest, which runs the numerical test cases of the kernels on the user's device and driver.
#include <fmt/format.h>

#include <cstdio>
#include <iterator>
#include <memory>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/base/stopwatch.h"
#include "host/lab/reference/case_page.h"
#include "host/lab/reference/case_table.h"
#include "host/lab/selftest/selftest.h"
#include "tools/multum/commands.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

struct SelftestCommandOptions {
  std::string device;
  std::string report;
  std::string markdown;
  std::string with;
  SelftestOptions selftest;
  CommonOptions common;
};

NumericalRun read_run(const std::string& path) {
  const std::optional<std::string> text = json_of_file(path, StandardInput::kAllowed);
  if (!text) throw Error(ErrorCode::kInput, path + ": cannot be read");
  return parse_case_json(*text, path);
}

void check(const SelftestCommandOptions& options) {
  if (!options.with.empty() && options.markdown.empty()) throw Error(ErrorCode::kUsage, "--with needs --markdown");
  if (!options.markdown.empty() && !options.selftest.filter.empty())
    throw Error(ErrorCode::kUsage, "--markdown and --filter are mutually exclusive, because the page lists all cases");
}

int run_selftest_command(SelftestCommandOptions options) {
  check(options);
  apply(options.common);
  options.selftest.without_guards = options.selftest.without_guards || !options.markdown.empty();
  const Stopwatch stopwatch;
  std::vector<NumericalRun> runs;
  if (!options.with.empty()) runs.push_back(read_run(options.with));  // read before the long work
  Device device = Device::open(options.device);
  const auto progress = make_progress(options.common);
  const NumericalRun run = run_selftest(device, options.selftest, progress.get());
  progress_finish(progress.get());
  const double seconds = stopwatch.seconds();
  if (options.common.json) print_json(parsed(case_json(run)));
  else
    write_shown(stdout, fmt::format("device  {} ({}, {})\n\n", run.device, run.platform, run.driver) + case_table(run));
  std::size_t broken = 0;
  for (const NumericalVerdict& v : run.verdicts) broken += v.holds() ? 0 : 1;
  if (!options.common.json)
    write_shown(stdout, fmt::format("\n{} cases, {} broken, {:.1f} s\n", run.verdicts.size(), broken, seconds));
  if (!options.report.empty()) write_text_file(options.report, case_json(run));
  if (!options.markdown.empty()) {
    runs.insert(runs.begin(), run);
    write_text_file(options.markdown, stability_page(runs));
  }
  if (broken > 0)
    throw Error(ErrorCode::kVerification,
                fmt::format("{} of {} numerical cases fail on {} ({}, {}); do not trust its bakes", broken,
                            run.verdicts.size(), run.device, run.platform, run.driver));
  return 0;
}

}  // namespace

void add_selftest_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<SelftestCommandOptions>();
  CLI::App* selftest =
      app.add_subcommand("selftest",
                         "check the driver of a device by running numerically difficult test cases of the "
                         "kernels");
  selftest->add_option("--device", options->device,
                       "use this OpenCL device: its number in `multum devices`, or part of its name");
  selftest->add_option("--filter", options->selftest.filter,
                       "run only the cases and kernels whose names contain this "
                       "text");
  selftest->add_flag("--without-guards", options->selftest.without_guards,
                     "also run each case without the code that guards against the numerical problem");
  selftest->add_option("--report", options->report, "write the results to this file as JSON");
  selftest->add_option("--markdown", options->markdown,
                       "write docs/contributing/STABILITY.md to this file; implies --without-guards");
  selftest->add_option("--with", options->with,
                       "with --markdown, read the GL results from this file, which gl_stability_test wrote");
  add_common_options(*selftest, options->common);
  selftest->callback([options, exit_code] { *exit_code = run_selftest_command(*options); });
}

}  // namespace multum
