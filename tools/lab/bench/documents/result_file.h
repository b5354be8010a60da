// SPDX-License-Identifier: Apache-2.0
// The JSON file of a benchmark: first what was run on which machine, then the figures. docs/evidence/BENCHMARKS.md is
// made of such files.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/lab/bench/documents/result_view.h"

namespace multum::bench {

/// What was run, where, and how it was built, before the benchmark's own `figures`.
nlohmann::ordered_json make_result(const std::string& benchmark, const std::string& command,
                                   const nlohmann::ordered_json& figures);

/// Throws Error(kInput) that names the file unless it holds the result of a benchmark that this program knows.
nlohmann::ordered_json read_result(const std::string& path);

/// "commit 0123abc, GNU 12.2.0, Release; AMD EPYC, 2 cores, 23 GiB of memory, Debian GNU/Linux 12 (bookworm)".
std::string conditions_text(const nlohmann::ordered_json& result);

/// Throws nlohmann's exceptions where a result lacks something.
ResultView view_of(const nlohmann::ordered_json& result);

}  // namespace multum::bench
