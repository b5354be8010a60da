// SPDX-License-Identifier: Apache-2.0
// Reads the error of frames that are drawn with inferred textures, compared with the ray-traced frames, from the report
// of `multum infer`. Packing derives its error limit from this error.
#pragma once

#include <optional>
#include <string>

namespace multum {

constexpr const char* kInferenceReportName = "report.json";  // next to the manifest

/// Returns the squared error of frames drawn with a folder's textures, compared with the ray-traced frames. The error
/// is the mean of red, green and blue in 8-bit sRGB units, summed over all wholly covered pixels of all samples. If no
/// frames were drawn, the errors of the layers are added instead. For four samples of field_demo1, this sum is 4 %
/// larger. Returns nullopt if the folder has no report, or a report without these figures.
std::optional<double> inference_error_sum(const std::string& folder);

}  // namespace multum
