// SPDX-License-Identifier: Apache-2.0
// Times the reading of a baked file and its upload to GL as in multum-view, for every encoding and compression, with
// sizes on disk and times of writing.
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
  int repetitions = 3;  // per file
  int threads = 0;      // of OpenEXR, for reading and writing; 0: all cores
  gl::ContextBackend context = gl::ContextBackend::kOsmesa;
  std::string folder;  // for files; empty: the system's temporary folder
};

/// Bakes once as floats and rounds to each encoding. Throws Error(kVerification) if a file reads back differently.
nlohmann::ordered_json run_load_benchmark(const LoadBenchmarkOptions& options, Progress* progress);

ResultView view_load(const nlohmann::ordered_json& result);

}  // namespace multum::bench
