// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/settings_search/tradeoff_sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host/bakes/bake/bake_file.h"
#include "host/bakes/movmf/start_memory.h"
#include "host/bakes/settings_search/pending_views.h"
#include "host/bakes/settings_search/plane_picture.h"
#include "host/formats/asset/gpu_bytes.h"
#include "host/formats/brdf/brdf_text.h"
#include "host/formats/brdf/facet_distribution.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/work_folder.h"
#include "host/foundation/base/messages/held_warnings.h"
#include "host/foundation/base/run_times.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {
namespace {

constexpr std::uint64_t kWaitingBytesMax = 32 << 20;  // limit for baked files that wait for drawing
constexpr std::size_t kTimeRepeats = 5;               // repeats of the default settings, to measure the noise of times
constexpr const char* kMomentShadings[] = {"toksvig", "lean", "lean-jacobian"};

// A way to draw a bake.
struct View {
  std::string group;
  std::string arguments;                              // arguments in addition to --brdf
  std::string brdf;                                   // option of multum-view; empty for the target's BRDF
  bool is_measured;                                   // true if the errors measured for the target are valid
  std::optional<Highlight> highlight = std::nullopt;  // another highlight to measure
  std::string shading = {};                           // AccuracyBrdf::shading of the errors of this view
};

struct SweptBake {
  ParameterValues values;
  std::vector<View> views;
};

// Returns the GGX that is as wide as Blinn-Phong with that exponent: alpha^2 = 2 / (s + 2). The roughness of glTF is
// sqrt(alpha).
std::string ggx_of(double exponent) {
  return fmt::format("ggx:{:.3f}", std::clamp(std::pow(2.0 / (exponent + 2.0), 0.25), 0.05, 1.0));
}

// Adds views drawn with sums of 1 to 4 vMFs. The BRDF is the target if it is a sum, otherwise a GGX of the same width.
void add_term_views(const TargetBrdf& target, std::vector<View>& views) {
  const std::string text = target.is_sum() ? target.text : ggx_of(equivalent_exponent(target.brdf));
  for (int terms = 1; terms <= kBrdfTermCountMax; ++terms) {
    const std::string arguments = fmt::format("--brdf-terms {}", terms);
    views.push_back(
        {"BRDF terms", arguments, text, false,
         make_highlight(AccuracyBrdf::named("terms:" + std::to_string(terms)), parse_brdf("--brdf", text, terms))});
  }
}

// Draws the default bake by every formula and every number of terms.
void add_default_views(const TradeoffJob& job, std::vector<View>& views) {
  if (job.length == SweepLength::kQuick) return;
  views.push_back({"shading formula", "--shade-first", "", false});
  if (job.has_roughness()) return;  // the BRDF is determined by the map and has only one formula
  if (job.brdf.brdf.kind == BrdfKind::kBlinnPhong) views.push_back({"shading formula", "--formula paper", "", false});
  if (job.brdf.has_highlight()) add_term_views(job.brdf, views);
}

std::vector<View> views_of(const SettingCandidate& candidate, const TradeoffJob& job) {
  const std::string group = candidate_axis_name(candidate.axis);
  std::vector<View> views;
  if (candidate.axis == CandidateAxis::kMoments)
    for (const char* shading : kMomentShadings)
      views.push_back({group, fmt::format("--moments {}", shading), "", true, std::nullopt, shading});
  else views.push_back({group, "", "", true});
  if (candidate.axis == CandidateAxis::kLobes && candidate.lobe_count() == default_lobe_count())
    add_default_views(job, views);
  if (candidate.values.flag("unaligned")) views.push_back({group, "--shade-first", "", false});
  return views;
}

CandidateUser user_of(SweepLength length) {
  switch (length) {
    case SweepLength::kQuick: return kQuickSweep;
    case SweepLength::kDefault: return kDefaultSweep;
    case SweepLength::kFull: return kFullSweep;
  }
  return kDefaultSweep;
}

std::vector<SweptBake> make_sweep(const TradeoffJob& job) {
  std::vector<SweptBake> sweep;
  for (const SettingCandidate& one : setting_candidates(user_of(job.length))) {
    if (!job.brdf.can_shade(one.representation())) continue;
    if (!one.is_for(job.bake)) continue;
    sweep.push_back({one.values, views_of(one, job)});
  }
  return sweep;
}

// Removes files that a killed sweep left.
std::unique_ptr<WorkFolder> take_scratch(const std::string& output) {
  std::unique_ptr<WorkFolder> folder = WorkFolder::take(partial_folder_of(output));
  if (!folder) throw Error(ErrorCode::kEnvironment, output + ": is being written by another process");
  folder->clear();
  return folder;
}

// Returns the arguments of every view. The map is needed for the reference.
std::vector<std::string> common_arguments(const TradeoffJob& job) {
  std::vector<std::string> arguments = {
      "--source", job.bake.input, "--context", job.context,
      "--decode", job.decode,     "--size",    fmt::format("{}x{}", job.width, job.height)};
  if (job.has_roughness())
    arguments.insert(arguments.end(), {job.bake.roughness_is_gloss ? "--gloss" : "--roughness", job.bake.roughness});
  return arguments;
}

class Sweep {
 public:
  Sweep(const TradeoffJob& job, Device& device, Progress* progress)
      : job_(job),
        device_(device),
        progress_(progress),
        scratch_(take_scratch(job.output)),
        views_(job.viewer, common_arguments(job), scratch_->path()) {}

  TradeoffResult run() {
    const Stopwatch stopwatch;
    // On a CPU, the processor time of the process already includes the time of OpenCL.
    if (!device_.info().is_cpu) device_.time_launches(true);
    BakeReport reading;
    const BakeSource source = read_source(job_.bake, MapReadings::kMany, reading, progress_);
    result_.width = source.map.normals.width();
    result_.height = source.map.normals.height();
    // Drops first levels that the map does not have.
    std::vector<SweptBake> sweep = make_sweep(job_);
    const int level_count = static_cast<int>(std::log2(std::max(result_.width, result_.height)));
    std::erase_if(sweep,
                  [&](const SweptBake& one) { return one.values.integer("first_level").value_or(0) > level_count; });
    std::uint64_t units = 0;
    for (const SweptBake& one : sweep) units += one.views.size() + 1 + kTimedRounds;
    progress_start(progress_, units);
    for (std::size_t i = 0; i < sweep.size(); ++i) {
      run_bake(sweep[i], source);
      // Repeats are spread over the sweep, so that they show the noise that other programs cause.
      if ((i + 1) % std::max<std::size_t>(1, sweep.size() / kTimeRepeats) == 0) repeat_default(source);
    }
    draw_views();
    time_bakes(sweep, source);
    result_.noise = {relative_half_width(bake_times_), relative_half_width(frame_times_)};
    mark_fronts(result_.rows, result_.noise);
    mark_budgets();
    choose();
    progress_finish(progress_);
    result_.seconds = stopwatch.seconds();
    return std::move(result_);
  }

 private:
  void run_bake(const SweptBake& swept, const BakeSource& source) {
    const std::string options = options_text(swept.values);
    progress_stage(progress_, "bake " + options);
    BakeJob bake = job_.bake;
    apply(swept.values, bake);
    bake.starts = starts_;
    bake.output = new_scratch_file();
    bake.report.clear();
    bake.force = true;
    choose_measured(bake);
    for (const View& view : swept.views)
      if (view.highlight) bake.highlights.push_back(*view.highlight);
    Progress quiet = cancel_only(progress_);
    HeldWarnings held;
    const BakeReport report = bake_file(bake, &source, device_, &quiet);
    const std::vector<std::string> warnings = without_name(held.take());
    result_.device = report.device;
    progress_advance(progress_, 1);
    for (const View& view : swept.views) {
      TradeoffRow row;
      row.group = view.group;
      row.options = options;
      row.view = view.arguments;
      if (!view.brdf.empty()) row.view = fmt::format("--brdf {} {}", view.brdf, view.arguments);
      row.is_measured = view.is_measured;
      row.normals_file_bytes = bake.fitting.first_level > 0 ? std::filesystem::file_size(bake.input) : 0;
      row.file_bytes = std::filesystem::file_size(bake.output) + row.normals_file_bytes;
      row.normals_bytes = finest_normals_gpu_bytes(result_.width, result_.height, bake.fitting.first_level);
      row.gpu_bytes = baked_gpu_bytes(bake.output) + row.normals_bytes;
      row.warnings = warnings;
      if (view.is_measured) add_errors(report, view, row);
      if (view.highlight) add_errors_of(report, *view.highlight, row);
      result_.rows.push_back(std::move(row));
      if (!job_.viewer.empty()) draw(bake.output, view, result_.rows.size() - 1);
      progress_advance(progress_, 1);
    }
    if (views_.waiting_bytes() > kWaitingBytesMax) draw_views();
  }

  // Rows need only the pixel error of one BRDF, whereas a bake measures four BRDFs and each level by default.
  void choose_measured(BakeJob& bake) const {
    if (job_.has_roughness()) return;  // only one BRDF is measured, and a warning needs the errors of its levels
    if (job_.measures_all_brdfs) {
      bake.highlights = job_.brdf.more_highlights();
      return;
    }
    bake.measured_exponents.clear();
    bake.measure_levels = false;
    if (job_.brdf.has_highlight()) bake.highlights = {make_highlight(job_.brdf.id, job_.brdf.brdf)};
  }

  // Bakes again only to measure the time. The warnings about the map have already been printed.
  BakeReport bake_unmeasured(BakeJob bake, const BakeSource& source) {
    bake.report.clear();
    bake.force = true;
    bake.measure = false;
    Progress quiet = cancel_only(progress_);
    const HeldWarnings held;
    return bake_file(bake, &source, device_, &quiet);
  }

  // Bakes all settings again, alternately and without measuring errors, because the first bakes included the time for
  // compiling kernels and loading files into the cache. The start is remembered from the first bake, and the time of
  // its search is added.
  void time_bakes(const std::vector<SweptBake>& sweep, const BakeSource& source) {
    progress_stage(progress_, "time bakes");
    std::vector<RunTime> remembered(sweep.size());
    std::vector<std::function<void()>> runs;
    for (std::size_t i = 0; i < sweep.size(); ++i)
      runs.push_back([this, &one = sweep[i], &search = remembered[i], &source] {
        BakeJob bake = job_.bake;
        apply(one.values, bake);
        bake.starts = starts_;
        bake.output = scratch("timed.ndf.exr");
        search = bake_unmeasured(bake, source).fit.start_remembered;
      });
    const std::vector<RunTime> times = time_in_turns(runs, kTimedRounds, progress_, device_seconds());
    for (std::size_t i = 0; i < sweep.size(); ++i)
      for (TradeoffRow& row : result_.rows) {
        if (row.options == options_text(sweep[i].values)) row.bake = times[i] + remembered[i];
      }
  }

  DeviceSeconds device_seconds() const {
    return [&device = device_] { return device.timed_seconds(); };
  }

  // Repeats the bake and the frame of the default settings.
  void repeat_default(const BakeSource& source) {
    progress_stage(progress_, "repeat the default");
    BakeJob bake = job_.bake;
    bake.output = new_scratch_file();
    const RunClock clock(device_seconds());
    bake_unmeasured(bake, source);
    bake_times_.push_back(clock.time().work_seconds());
    if (job_.viewer.empty()) return;
    const View view{"", "", "", true};
    views_.add({bake.output, arguments_of(view)},
               [this](const DrawnView& drawn) { frame_times_.push_back(frame_work(drawn.report)); });
  }

  // Removes the map's name, which the page already shows.
  std::vector<std::string> without_name(std::vector<std::string> warnings) const {
    const std::string name = job_.bake.input + ": ";
    for (std::string& warning : warnings)
      if (warning.starts_with(name)) warning.erase(0, name.size());
    return warnings;
  }

  void add_errors(const BakeReport& report, const View& view, TradeoffRow& row) const {
    // For moments, takes the errors of this shading method.
    for (const FootprintError& one : report.error)
      if (one.brdf.shading == view.shading && !one.brdf.has_colours) row.errors.push_back(one);
    row.reached = reached_error(row.errors, job_.brdf);
    row.has_error = true;
  }

  static void add_errors_of(const BakeReport& report, const Highlight& highlight, TradeoffRow& row) {
    row.reached = reached_error(report.error, {highlight.id, highlight.id.text(), highlight.brdf});
    row.has_error = true;
  }

  std::string scratch(const std::string& name) const { return scratch_->path() + "/" + name; }
  std::string new_scratch_file() { return scratch(fmt::format("swept_{}.ndf.exr", scratch_count_++)); }

  // Compares the picture with the pixel reference, like the measured error. The reference is drawn once per BRDF.
  void draw(const std::string& baked, const View& view, std::size_t row_number) {
    const bool is_first = references_.empty();  // the page shows the reference of the first view
    std::vector<std::string> arguments = arguments_of(view);
    arguments.insert(arguments.end(), {"--compare", "reference", "--reference-of", "pixel", "--samples",
                                       fmt::format("{}", job_.samples), "--keep-reference", kept_reference(view)});
    views_.add({baked, arguments, is_first}, [this, row_number](const DrawnView& drawn) {
      TradeoffRow& row = result_.rows[row_number];
      result_.renderer = drawn.report.at("context").get<std::string>();
      row.rendered = own_picture(drawn.report).at("relative_l1").get<double>();
      row.frame_ms = own_picture(drawn.report).at("frame_time_ms").get<double>();
      row.frame_work_ms = frame_work(drawn.report);
      row.picture = drawn.picture;
      if (!drawn.reference.empty()) result_.reference = drawn.reference;
    });
  }

  void draw_views() {
    progress_stage(progress_, "draw");
    views_.draw(progress_);
  }

  // Milliseconds of a frame, from multum-view's report.
  static double frame_work(const nlohmann::json& report) {
    const char* const key = report.at("context_is_software").get<bool>() ? "frame_processor_ms" : "frame_draw_ms";
    return own_picture(report).at(key).get<double>();
  }

  const std::string& brdf_of(const View& view) const { return view.brdf.empty() ? job_.brdf.text : view.brdf; }

  // Sums of vMFs have their own references.
  std::string kept_reference(const View& view) {
    const std::string terms = view.arguments.starts_with("--brdf-terms") ? view.arguments : "";
    const std::size_t number = references_.emplace(brdf_of(view) + terms, references_.size()).first->second;
    return scratch(fmt::format("reference_{}", number));
  }

  std::vector<std::string> arguments_of(const View& view) const {
    std::vector<std::string> arguments;
    if (!job_.has_roughness()) arguments = {"--brdf", brdf_of(view)};
    std::stringstream words(view.arguments);
    for (std::string word; words >> word;) arguments.push_back(word);
    return arguments;
  }

  // A row for which no frame was drawn does not meet any time budget.
  void mark_budgets() {
    for (TradeoffRow& row : result_.rows)
      row.fits = (!job_.bytes_max || row.gpu_bytes <= *job_.bytes_max) &&
                 (!job_.frame_ms_max || (row.frame_ms >= 0.0 && row.frame_ms <= *job_.frame_ms_max)) &&
                 (!job_.bake_seconds_max || row.bake.elapsed_seconds <= *job_.bake_seconds_max);
  }

  // Chooses a row. For a target error, chooses the row with the fewest bytes, and among such rows the one with the
  // least work. For a target time, or if only budgets are given, chooses the row with the lowest error. Budgets limit
  // the elapsed time, because this is the time that users wait.
  void choose() {
    for (std::size_t i = 0; i < result_.rows.size(); ++i) {
      const TradeoffRow& row = result_.rows[i];
      if (!row.is_measured || !row.fits) continue;
      const bool fits = job_.error          ? row.reached.meets(*job_.error)
                        : job_.bake_seconds ? row.bake.elapsed_seconds <= *job_.bake_seconds
                                            : job_.has_budget();
      if (!fits) continue;
      const auto rank = [&](const TradeoffRow& one) {
        return std::pair(job_.error ? static_cast<double>(one.gpu_bytes) : one.reached.error, one.bake.work_seconds());
      };
      if (!result_.chosen || rank(row) < rank(result_.rows[*result_.chosen])) result_.chosen = i;
    }
  }

  const TradeoffJob& job_;
  Device& device_;
  Progress* const progress_;
  const std::unique_ptr<WorkFolder> scratch_;
  PendingViews views_;
  int scratch_count_ = 0;
  const std::shared_ptr<StartMemory> starts_ = std::make_shared<StartMemory>();
  TradeoffResult result_;
  std::vector<double> bake_times_, frame_times_;   // bake and frame times of the default settings
  std::map<std::string, std::size_t> references_;  // [BRDF]: index of the file
};

// A cost for which there is a front. The noise is 0 if the cost is exact.
struct FrontCost {
  bool TradeoffRow::*flag;
  std::function<double(const TradeoffRow&)> of;  // < 0 if not known
  double noise;                                  // relative half width of one value
};

// True if `a` exceeds `b` by more than their intervals.
bool is_more(double a, double b, double half_width_a, double half_width_b) {
  return a - b > std::hypot(half_width_a, half_width_b);
}
bool has_more_error(const TradeoffRow& a, const TradeoffRow& b) {
  return is_more(a.reached.error, b.reached.error, a.reached.confidence, b.reached.confidence);
}
bool costs_more(const FrontCost& cost, const TradeoffRow& a, const TradeoffRow& b) {
  return is_more(cost.of(a), cost.of(b), cost.noise * cost.of(a), cost.noise * cost.of(b));
}

}  // namespace

double relative_half_width(const std::vector<double>& times) {
  // Returns Student's two-sided 95 % quantile for n - 1 degrees of freedom.
  constexpr double kStudent[] = {12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262};
  const auto n = static_cast<double>(times.size());
  if (times.size() < 2) return 0.0;
  double mean = 0.0, squares = 0.0;
  for (const double time : times) mean += time / n;
  for (const double time : times) squares += (time - mean) * (time - mean);
  const double quantile = kStudent[std::min(times.size() - 2, std::size(kStudent) - 1)];
  return mean > 0.0 ? quantile * std::sqrt(squares / (n - 1.0)) / mean : 0.0;
}

void mark_fronts(std::vector<TradeoffRow>& rows, const TimeNoise& noise) {
  const FrontCost costs[] = {
      {&TradeoffRow::on_time_front, [](const TradeoffRow& row) { return row.bake.work_seconds(); }, noise.bake},
      {&TradeoffRow::on_frame_front, [](const TradeoffRow& row) { return row.frame_work_ms; }, noise.frame},
      {&TradeoffRow::on_size_front, [](const TradeoffRow& row) { return static_cast<double>(row.gpu_bytes); }, 0.0}};
  for (const FrontCost& cost : costs)
    for (TradeoffRow& row : rows) {
      if (!row.is_measured || cost.of(row) < 0.0) continue;
      row.*cost.flag = std::none_of(rows.begin(), rows.end(), [&](const TradeoffRow& other) {
        if (!other.is_measured || cost.of(other) < 0.0) return false;
        if (has_more_error(other, row) || costs_more(cost, other, row)) return false;
        return has_more_error(row, other) || costs_more(cost, row, other);
      });
    }
  // Among indistinguishable rows, the one with the lowest error represents the others.
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].on_front()) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return rows[a].reached.error < rows[b].reached.error; });
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t k = 0; k < i && !rows[order[i]].same_as; ++k) {
      const TradeoffRow &row = rows[order[i]], &other = rows[order[k]];
      const bool is_same = !other.same_as && !has_more_error(row, other) &&
                           std::none_of(std::begin(costs), std::end(costs), [&](const FrontCost& cost) {
                             return costs_more(cost, row, other) || costs_more(cost, other, row);
                           });
      if (is_same) rows[order[i]].same_as = order[k];
    }
}

std::size_t TradeoffResult::setting_count() const {
  return static_cast<std::size_t>(
      std::count_if(rows.begin(), rows.end(), [](const TradeoffRow& row) { return row.is_measured; }));
}

TradeoffResult run_tradeoff(const TradeoffJob& job, Device& device, Progress* progress) {
  if (job.error && job.bake_seconds)
    throw Error(ErrorCode::kUsage, "--target-error and --budget-ms: expected only one of them");
  if (job.frame_ms_max && job.viewer.empty())
    throw Error(ErrorCode::kUsage, "--max-frame-ms needs pictures, found --no-pictures; expected only one of them");
  return Sweep(job, device, progress).run();
}

}  // namespace multum
