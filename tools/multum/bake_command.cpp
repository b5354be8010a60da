// SPDX-License-Identifier: Apache-2.0
// multum bake: options as maketx names them where it has them.
#include <cstdio>
#include <memory>

#include "host/bake/bake_batch.h"
#include "host/bake/bake_job.h"
#include "host/base/error.h"
#include "host/base/log.h"
#include "host/base/machine.h"
#include "tools/command_line/choices.h"
#include "tools/command_line/reading_options.h"
#include "tools/multum/commands.h"

namespace multum {
namespace {

struct BakeOptions {
  CommonOptions common;
  BakeJob job;
  std::string device;
  std::string wrap, wrap_s, wrap_t;
  ReadingOptions reading;
  std::vector<std::string> inputs;
  std::string region;
  bool no_measure = false;
  bool run_stats = false;
};

const Choices<FitOrder> kOrders = {{"colour", FitOrder::kColour}, {"scanline", FitOrder::kScanline}};
const Choices<CoarseNormals> kCoarseNormals = {{"condensed", CoarseNormals::kCondensed}, {"all", CoarseNormals::kAll}};
const Choices<StorageEncoding> kEncodings = {
    {"snorm16", StorageEncoding::kSnorm16}, {"half", StorageEncoding::kHalf}, {"float", StorageEncoding::kFloat}};

void add_input_options(CLI::App& bake, BakeOptions& o) {
  NormalMapSettings& r = o.job.reading;
  o.reading.bump_format = r.bump_format;  // --help shows these as the defaults
  o.reading.height_scale = r.height_scale;
  o.reading.fix_nan = r.fix_nan;
  o.reading.repair_share_max = r.repair_share_max;
  const CLI::Validator wraps = CLI::IsMember({"black", "clamp", "periodic", "mirror"});
  add_reading_options(bake, o.reading);
  bake.add_option("--wrap", o.wrap, "beyond the border: black, clamp, periodic or mirror (default: periodic)")
      ->check(wraps);
  bake.add_option("--swrap", o.wrap_s, "the same for s (x) alone")->check(wraps);
  bake.add_option("--twrap", o.wrap_t, "the same for t (y) alone")->check(wraps);
  bake.add_flag("--checknan", r.check_nan, "refuse a file with NaN or Inf, naming the first");
  bake.add_option("--albedo", o.job.albedo, "colour map of the same size: bakes colours per lobe");
}

void add_fit_options(CLI::App& bake, BakeOptions& o) {
  MovmfSettings& f = o.job.fitting;
  bake.add_option("--lobes", f.lobe_count, "lobes a texel, 1..8: more are more accurate, larger and slower")
      ->capture_default_str();
  bake.add_flag_callback(
      "--reference", [&f] { make_reference(f); },
      "every normal at every level, 30 iterations, none cut short: what the defaults are measured against, slower");
  bake.add_option_function<int>(
          "--iterations", [&f](int count) { f.iteration_count = f.iteration_count_coarse = count; },
          "EM iterations a texel, at most")
      ->default_str(std::to_string(f.iteration_count));
  bake.add_option("--sweeps", f.sweep_count, "times that a level is fitted; more than one aligns it better")
      ->capture_default_str();
  add_choice(bake, "--order", f.order, kOrders, "colour (parallel) or scanline (the paper's)");
  add_choice(bake, "--coarse-normals", f.coarse_normals, kCoarseNormals,
             "what EM sees of coarse texels: all, or condensed (cells of like normals: faster)");
  bake.add_flag_callback(
      "--no-rehearsal", [&f] { f.rehearse_start = false; },
      "start from the candidate of least error, without trying them all: saves half a second");
  bake.add_option("--align", f.alignment, "weight of the alignment prior; 0: none")->capture_default_str();
  bake.add_option("--kappa-cap", f.kappa_cap,
                  "sharpest lobe that EM uses on rough texels; smooth ones get sharper ones")
      ->capture_default_str();
}

void add_output_options(CLI::App& bake, BakeOptions& o) {
  bake.add_option("-o,--output", o.job.output,
                  "file to write, *.ndf.exr; of several maps: a folder, or a name with <UDIM>")
      ->required();
  bake.add_option("--first-level", o.job.fitting.first_level,
                  "finest level to store; renderers take finer ones from the normal map (docs/FORMAT.md)")
      ->capture_default_str();
  add_choice(bake, "-d,--data-format", o.job.encoding, kEncodings,
             "what lobes are rounded to; half loses kappa above 1000 (docs/FORMAT.md)");
  bake.add_option("--compression", o.job.writing.compression, "none, rle, zips, zip or piz, zip:1..9")
      ->capture_default_str();
  bake.add_option("--report", o.job.report, "write times, counts and errors as JSON; of several maps: as --output");
  bake.add_option("--device", o.device, "OpenCL device: a number of `multum devices` or part of a name");
  bake.add_flag("--scalar", o.job.fitting.force_scalar,
                "run the kernels' scalar variant, as GPUs do: same bytes, slower on CPUs");
  bake.add_option(
          "--memory", o.job.memory_bytes,
          "resident memory to stay within, as 800M or 2G: larger maps are baked in bands of rows, with the same "
          "result (default: a quarter of the machine's)")
      ->transform(CLI::AsSizeValue(false));
  bake.add_option("--scratch", o.job.scratch_folder, "folder for what does not fit in memory (default: the output's)");
  bake.add_flag("--resume", o.job.resume, "go on from what a killed bake of the same output left beside it");
  bake.add_option("--region", o.region,
                  "x,y,width,height: only this part of the map was edited; fit it again and keep the rest of --onto");
  bake.add_option("--onto", o.job.onto, "the file that was baked before the edit; may be the output");
  bake.add_flag("--force", o.job.force, "bake even if the output is from the same file with the same settings");
  bake.add_flag("--no-measure", o.no_measure, "skip measuring the error of what is written");
  bake.add_flag("--runstats", o.run_stats, "print times, launches and numerical events");
}

WrapMode wrap_or(const std::string& name, WrapMode fallback) {
  return name.empty() ? fallback : *parse_wrap_mode(name);
}

std::optional<MapRegion> parse_region(const std::string& text) {
  if (text.empty()) return std::nullopt;
  MapRegion region;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%d,%d,%d,%d%c", &region.x, &region.y, &region.width, &region.height, &rest) != 4)
    throw Error(ErrorCode::kUsage, "--region is '" + text + "', expected x,y,width,height in texels, as 0,256,128,64");
  return region;
}

BakeReport bake_with_progress(const BakeJob& job, const BakeOptions& o, Device& device) {
  const auto progress = make_progress(o.common);
  return bake_file(job, device, progress.get());
}

void print_report(const BakeJob& job, const BakeOptions& o, const BakeReport& report) {
  if (o.common.quiet) return;
  if (report.unchanged) {
    std::printf("%s: unchanged, from the same file with the same settings; --force bakes it again\n",
                job.output.c_str());
    return;
  }
  std::printf("%s: written\n%s", job.output.c_str(), report.to_text().c_str());
  if (!o.run_stats && !o.common.verbose) return;
  if (report.rows_resumed > 0)
    std::printf("%llu rows of levels were there from a bake that was killed\n",
                static_cast<unsigned long long>(report.rows_resumed));
  std::printf("%s", report.plan.c_str());
  for (const LevelReport& level : report.levels)
    std::printf("level %2d  %6d x %-6d  %8.3f s  %6llu launches\n", level.level, level.width, level.height,
                level.seconds, static_cast<unsigned long long>(level.launches));
  for (const auto& [kernel, count] : report.launches)
    std::printf("%-24s %6llu launches\n", kernel.c_str(), static_cast<unsigned long long>(count));
}

// Each map for itself: one that fails does not keep the others from their bake. The exit code is the first failure's.
int bake_several(const std::vector<BakeJob>& jobs, const BakeOptions& o, Device& device) {
  int code = 0;
  std::size_t unchanged = 0, failed = 0;
  for (const BakeJob& job : jobs) {
    try {
      const BakeReport report = bake_with_progress(job, o, device);
      print_report(job, o, report);
      unchanged += report.unchanged ? 1 : 0;
    } catch (const Error& error) {
      std::fprintf(stderr, "multum: %s\n", error.what());
      if (code == 0) code = exit_code(error.code());
      ++failed;
    }
  }
  if (!o.common.quiet || failed > 0)
    std::fprintf(failed > 0 ? stderr : stdout, "%zu maps: %zu baked, %zu unchanged, %zu failed\n", jobs.size(),
                 jobs.size() - unchanged - failed, unchanged, failed);
  return code;
}

int run_bake(BakeOptions& o) {
  const int threads = apply(o.common);
  BakeJob& job = o.job;
  const WrapMode wrap = wrap_or(o.wrap, WrapMode::kPeriodic);
  job.reading.wrap_s = wrap_or(o.wrap_s, wrap);
  job.reading.wrap_t = wrap_or(o.wrap_t, wrap);
  apply(o.reading, job.reading);
  job.threads = job.writing.threads = threads;
  job.measure = !o.no_measure;
  job.region = parse_region(o.region);
  keep_freed_memory();
  Device device = Device::open(o.device);
  const std::vector<BakeJob> jobs = make_bake_jobs(job, o.inputs);
  if (jobs.size() > 1) return bake_several(jobs, o, device);
  print_report(jobs[0], o, bake_with_progress(jobs[0], o, device));
  return 0;
}

}  // namespace

void add_bake_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<BakeOptions>();
  CLI::App* bake =
      app.add_subcommand("bake", "bake a normal map or height field into an aligned mixture-of-vMF mipmap");
  bake->add_option("input", options->inputs,
                   "PNG, TIFF, EXR, JPEG or WebP, sides to 32768; several maps, or sets as rock_<UDIM>.png")
      ->required();
  add_output_options(*bake, *options);
  add_fit_options(*bake, *options);
  add_input_options(*bake, *options);
  add_common_options(*bake, options->common);
  bake->callback([options, exit_code] { *exit_code = run_bake(*options); });
}

}  // namespace multum
