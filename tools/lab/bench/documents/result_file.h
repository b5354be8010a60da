// SPDX-License-Identifier: Apache-2.0
// Writes and reads the JSON file of a benchmark. The file contains the program and the machine first, and then the
// figures. docs/evidence/BENCHMARKS.md is made from such files.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/lab/bench/documents/result_view.h"

namespace multum::bench {

/// Puts program, machine and build before the benchmark's own `figures`.
nlohmann::ordered_json make_result(const std::string& benchmark, const std::string& command,
                                   const nlohmann::ordered_json& figures);

/// If the file is not the result of a known benchmark, throws an Error(kInput) that names the file.
nlohmann::ordered_json read_result(const std::string& path);

/// Returns a sentence such as "The program was built from commit 0123abc (GNU 12.2.0, Release), and ran on AMD EPYC, 2
/// cores, 23 GiB of memory, Debian GNU/Linux 12 (bookworm)."
std::string conditions_text(const nlohmann::ordered_json& result);

/// Throws an exception of nlohmann if a result lacks a key.
ResultView view_of(const nlohmann::ordered_json& result);

}  // namespace multum::bench
