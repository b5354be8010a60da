// SPDX-License-Identifier: Apache-2.0
// The JSON file of a benchmark: first what was run on which machine, then the figures.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/bench/result_view.h"

namespace multum::bench {

/// What was run, where, and how it was built, before the benchmark's own `figures`.
nlohmann::ordered_json make_result(const std::string& benchmark, const std::string& command,
                                   const nlohmann::ordered_json& figures);

/// Throws nlohmann's exceptions where a result lacks something.
ResultView view_of(const nlohmann::ordered_json& result);

}  // namespace multum::bench
