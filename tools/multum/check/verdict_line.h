// SPDX-License-Identifier: Apache-2.0
// Measures how much a baked or exported map gains (host/delivery/check), for the sentence that ends a command.
#pragma once

#include <cstdio>
#include <optional>

#include "host/bakes/bake/bake_job.h"
#include "host/bakes/bake/bake_report.h"
#include "host/delivery/check/gain_verdict.h"
#include "host/delivery/export/export_job.h"
#include "tools/multum/json_output.h"

namespace multum {

/// Measure the gain and print it to `out`. Return nothing if the report has no mosaic, or if a signal stops the
/// measurement, because the map is complete by then. If the gain cannot be measured, log the reason and return nothing.
std::optional<GainVerdict> end_with_verdict(const BakeJob& job, const BakeReport& report, const CommonOptions& common,
                                            Device& device, std::FILE* out = stdout);
std::optional<GainVerdict> end_with_verdict(const ExportJob& job, const ExportReport& report,
                                            const CommonOptions& common, Device& device, std::FILE* out = stdout);

/// Prints "NAME: SENTENCE" if the command prints text, and the table with --verbose.
void print_verdict(const std::string& name, const std::optional<GainVerdict>& verdict, const CommonOptions& common,
                   std::FILE* out = stdout);

/// Adds the key "gain".
OrderedJson with_verdict(OrderedJson json, const std::optional<GainVerdict>& verdict);

}  // namespace multum
