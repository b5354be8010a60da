// SPDX-License-Identifier: Apache-2.0
// Shows the report of `multum infer` as one page of HTML: it refers to the pictures in OUTPUT/report and to nothing
// else, and can be read in light, in dark and on paper. host/fields/inference/report/templates has what it says.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "host/fields/inference/report/inference_pictures.h"
#include "host/fields/inference/report/inference_report.h"

namespace multum {

std::string inference_page(const InferenceReport& report, const ReportPictures& pictures);

/// Writes report.json, the pictures and report.html into the output folder.
void write_inference_report(const ParameterizedScene& field, const InferenceReport& report);

/// The files of host/fields/inference/report/templates, by name. Made by tools/embed_files.py.
const std::map<std::string, std::string_view>& inference_templates();

}  // namespace multum
