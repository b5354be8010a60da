// SPDX-License-Identifier: Apache-2.0
#include "tools/multum/bake_print.h"
#include "host/foundation/base/shown_text.h"

namespace multum {

void print_report(const BakeJob& job, const BakePrinting& printing, const BakeReport& report) {
  if (printing.quiet) return;
  std::FILE* const out = printing.out;
  if (!report.shard.empty()) {
    print_shown(out, report.unchanged ? "%s: unchanged\n" : "%s: written\n", report.shard.c_str());
    return;
  }
  if (report.unchanged) {
    print_shown(
        out, "%s: unchanged, because it was baked from the same file with the same settings; --force bakes it again\n",
        job.output.c_str());
    return;
  }
  print_shown(out, "%s: written\n%s%s", job.output.c_str(), report.choice.c_str(),
              report.to_text(printing.details).c_str());
  if (!printing.details) return;
  if (report.rows_resumed > 0)
    print_shown(out, "%llu level rows were reused from an interrupted bake\n",
                static_cast<unsigned long long>(report.rows_resumed));
  print_shown(out, "%s", report.plan().c_str());
  for (const LevelReport& level : report.fit.levels)
    print_shown(out, "level %2d  %6d x %-6d  %8.3f s  %6llu launches\n", level.level, level.width, level.height,
                level.seconds, static_cast<unsigned long long>(level.launches));
  print_shown(out, "choosing starting values %.3f s, binning normals %.3f s\n", report.fit.start_seconds,
              report.fit.binning_seconds);
  for (const auto& [kernel, count] : report.launches) {
    const auto found = report.launch_seconds.find(kernel);
    print_shown(out, "%-26s %6llu launches", kernel.c_str(), static_cast<unsigned long long>(count));
    if (found != report.launch_seconds.end()) print_shown(out, "  %8.3f s on the device", found->second);
    std::fputc('\n', out);
  }
  const TransferCounts& t = report.transfers;
  if (t.uploads + t.downloads > 0)
    print_shown(out, "copies: %llu to the device (%.1f MiB), and %llu back (%.1f MiB)\n",
                static_cast<unsigned long long>(t.uploads), static_cast<double>(t.upload_bytes) / (1 << 20),
                static_cast<unsigned long long>(t.downloads), static_cast<double>(t.download_bytes) / (1 << 20));
}

OrderedJson bake_json(const BakeJob& job, const BakeReport& report) {
  OrderedJson json = {{"output", path_json(job.output)}};
  json.update(parsed(report.to_json()));
  return json;
}

OrderedJson failed_bake_json(const BakeJob& job, const std::string& error) {
  return {{"output", path_json(job.output)}, {"source", path_json(job.input)}, {"failed", error}};
}

}  // namespace multum
