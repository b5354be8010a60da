// SPDX-License-Identifier: Apache-2.0
// Times what a runtime waits for: reading a baked file and handing it to GL as multum-view does, for every encoding and
// compression, beside what each takes on the disk and to write.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "host/foundation/base/progress.h"
#include "runtime_gl/context/headless_context.h"
#include "tools/lab/bench/documents/result_view.h"

namespace multum::bench {

struct LoadBenchmarkOptions {
  int size = 1024;      // map side, even
  int lobes = 4;        // 1..8
  int repetitions = 3;  // of every file
  int threads = 0;      // OpenEXR's, for reading and writing; 0: all cores
  gl::ContextBackend context = gl::ContextBackend::kOsmesa;
  std::string folder;  // where files go; empty: the system's folder for temporary files
};

/// Bakes once, as floats, and rounds that to each encoding. Throws Error(kVerification) when a file reads back
/// differently.
nlohmann::ordered_json run_load_benchmark(const LoadBenchmarkOptions& options, Progress* progress);

ResultView view_load(const nlohmann::ordered_json& result);

}  // namespace multum::bench
