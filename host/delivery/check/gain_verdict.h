// SPDX-License-Identifier: Apache-2.0
// Turns measured errors into advice: one sentence per map, a table and JSON.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/delivery/check/gain_meter.h"

namespace multum {

enum class GainAdvice { kKeep, kExport, kLobes };

struct GainVerdict {
  std::string name;                 // the file, or the file and the material
  std::string kept;                 // reason why nothing was measured; empty if `measured` is set
  std::vector<GainError> measured;  // see measure_gain()
  std::optional<double> roughness;  // roughness of the sentence; not set for a roughness map

  GainAdvice advice() const;
  /// Returns the largest gain over plain mips from any distance, in percentage points, at the sentence's roughness.
  double gain() const;
  /// Returns a sentence such as "at 5 m and roughness 0.3: plain mips 21.0 %, export 14.0 %, lobes 6.0 %; lobes are
  /// worth it from 2 m on".
  std::string to_text() const;
  /// Returns all errors as a table.
  std::string to_table() const;
  /// Returns {"name", "sentence", "advice", "gain", "errors": [{"distance", "roughness", "light", "plain", "export",
  /// "lobes", "noise"}]}.
  nlohmann::ordered_json to_json() const;
};

}  // namespace multum
