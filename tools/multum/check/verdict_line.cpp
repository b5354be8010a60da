// SPDX-License-Identifier: Apache-2.0
#include "tools/multum/check/verdict_line.h"

#include "host/delivery/check/check_job.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/progress.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/base/system_failure.h"

namespace multum {
namespace {

std::optional<GainVerdict> measured(const CheckJob& job, const MapMosaic* mosaic, StartMemory* starts, Device& device) {
  if (mosaic == nullptr) return std::nullopt;
  try {
    const auto progress = make_terminal_progress(false);
    return quick_verdict(job, *mosaic, starts, device, progress.get());
  } catch (const Cancelled&) {
    return std::nullopt;
  } catch (...) {
    log_warning(job.input, std::string("its gain was not measured: ") + caught_error(job.input).what());
    return std::nullopt;
  }
}

CheckJob check_of(const std::string& input, int threads) {
  CheckJob check;
  check.input = input;
  check.threads = threads;
  return check;
}

}  // namespace

std::optional<GainVerdict> end_with_verdict(const BakeJob& job, const BakeReport& report, const CommonOptions& common,
                                            Device& device, std::FILE* out) {
  const auto verdict = measured(check_of(job.input, job.threads), report.mosaic.get(), report.starts.get(), device);
  print_verdict(job.output, verdict, common, out);
  return verdict;
}

std::optional<GainVerdict> end_with_verdict(const ExportJob& job, const ExportReport& report,
                                            const CommonOptions& common, Device& device, std::FILE* out) {
  CheckJob check = check_of(job.input, job.threads);
  check.engine = job.engine.value_or(Engine::kThree);
  check.base_roughness = job.lobe.base_roughness;
  check.has_roughness = !job.roughness.empty();
  check.has_metalness = !job.metalness.empty();
  const auto verdict = measured(check, report.mosaic.get(), nullptr, device);
  print_verdict(job.output, verdict, common, out);
  return verdict;
}

void print_verdict(const std::string& name, const std::optional<GainVerdict>& verdict, const CommonOptions& common,
                   std::FILE* out) {
  if (!verdict || !prints_text(common)) return;
  print_shown(out, "%s: %s\n", name.c_str(), verdict->to_text().c_str());
  if (common.verbose && !verdict->measured.empty()) print_shown(out, "%s", verdict->to_table().c_str());
}

OrderedJson with_verdict(OrderedJson json, const std::optional<GainVerdict>& verdict) {
  if (verdict) json["gain"] = verdict->to_json();
  return json;
}

}  // namespace multum
