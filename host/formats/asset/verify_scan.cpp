// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/verify_scan.h"

#include <fmt/format.h>

#include <cmath>

namespace multum {

std::string WorstTexel::text() const {
  return fmt::format("level {}, texel ({}, {})", place.level, place.x, place.y) +
         (place.band < 0 ? "" : fmt::format(", band {}", place.band));
}

VerifyFinding excess_finding(const std::string& check, const WorstTexel& worst, const std::string& good,
                             const std::string& bad) {
  const bool passed = worst.value <= 0.0;
  return {check, passed, passed ? good : fmt::format("{} by {:.2e} at {}", bad, worst.value, worst.text())};
}

VerifyFinding structure_finding(const BakedHeader& header, const std::string& kind) {
  return {"structure", true,
          fmt::format("{} x {}, {}, {}{}, encoding {}", header.width, header.height,
                      levels_text(header.first_level, header.level_count()), kind, materials_text(header),
                      storage_encoding_name(header.encoding))};
}

VerifyFinding checksum_finding(const std::string& hash, const std::string& expected,
                               const std::vector<std::string>& changed) {
  if (hash == expected && changed.empty()) return {"checksum", true, hash};
  std::string detail = hash == expected ? hash : "found " + hash + ", expected " + expected + " as the header says";
  if (!changed.empty())
    detail += fmt::format("; changed: {}{}", changed.front(),
                          changed.size() > 1 ? fmt::format(" and in {} more rows of tiles", changed.size() - 1) : "");
  return {"checksum", false, detail};
}

VerifyFinding finite_finding(std::size_t nonfinite, const std::string& of_what) {
  return {"finite", nonfinite == 0, fmt::format("{} {}, expected 0", nonfinite, of_what)};
}

VerifyFinding weights_finding(int weight_count, const WorstTexel& worst, const std::string& high) {
  return excess_finding("weights", worst, fmt::format("{} per texel, each from 0 to 1", weight_count),
                        "a weight is outside 0 to " + high);
}

void scan_weights(const std::vector<float>& weights, std::size_t index, int count, double high, double tolerance,
                  const TexelPlace& place, WorstTexel& worst, std::size_t& nonfinite) {
  for (std::size_t k = index * static_cast<std::size_t>(count); k < (index + 1) * static_cast<std::size_t>(count);
       ++k) {
    const auto weight = static_cast<double>(weights[k]);
    if (!std::isfinite(weight)) ++nonfinite;
    else worst.offer(std::max(-weight, weight - high - tolerance), place);
  }
}

}  // namespace multum
