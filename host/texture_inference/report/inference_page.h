// SPDX-License-Identifier: Apache-2.0
// The report of `multum infer` as one page of HTML: it refers to the pictures in OUTPUT/report and to nothing else, has
// no scripts, and can be read in light, in dark and on paper.
#pragma once

#include <string>

#include "host/texture_inference/report/inference_pictures.h"
#include "host/texture_inference/report/inference_report.h"

namespace multum {

std::string inference_page(const InferenceReport& report, const ReportPictures& pictures);

/// Writes report.json, the pictures and report.html into the output folder.
void write_inference_report(const ParameterizedScene& field, const InferenceReport& report);

}  // namespace multum
