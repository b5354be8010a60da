// SPDX-License-Identifier: Apache-2.0
// Reads from the report of `multum infer` how far frames drawn of its textures are from the ray-traced ones: packing
// takes its measure from that.
#pragma once

#include <optional>
#include <string>

namespace multum {

constexpr const char* kInferenceReportName = "report.json";  // beside the manifest

/// Squared error of frames drawn of a folder's textures beside the ray-traced ones: mean of red, green and blue, 8-bit
/// sRGB units, summed over the pixels that objects cover wholly in all samples. Where no frames were drawn it is summed
/// over layers: of four samples of field_demo1 that is 4 % more. Nothing where the folder has no report, or one without
/// these figures.
std::optional<double> inference_error_sum(const std::string& folder);

}  // namespace multum
