// SPDX-License-Identifier: Apache-2.0
// For every encoding and compression, measures the time it takes to write a baked file, to read it, and to upload it to
// GL in the same way as multum-view. Also reports file sizes.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "host/foundation/base/progress.h"
#include "runtime_gl/context/headless_context.h"
#include "tools/lab/bench/documents/result_view.h"

namespace multum::bench {

struct LoadBenchmarkOptions {
  int size = 1024;      // side of the map, an even number
  int lobes = 4;        // number of lobes, 1 to 8
  int repetitions = 3;  // number of runs per file
  int threads = 0;      // threads of OpenEXR for reading and writing; all cores if 0
  gl::ContextBackend context = gl::ContextBackend::kOsmesa;
  std::string folder;  // folder for files; the system's temporary folder if empty
};

/// Bakes once with floats, and rounds the result to each encoding. Throws Error(kVerification) if the content of a file
/// differs from the content that was written.
nlohmann::ordered_json run_load_benchmark(const LoadBenchmarkOptions& options, Progress* progress);

ResultView view_load(const nlohmann::ordered_json& result);

}  // namespace multum::bench
