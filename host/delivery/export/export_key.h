// SPDX-License-Identifier: Apache-2.0
// Lists everything on which the bytes of an export depend. The list is used to find out whether existing files were
// made from the same map with the same settings.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "host/delivery/export/export_job.h"

namespace multum {

/// Returns everything that determines a fit, which is this program, the hashes of its input files, and the lobe
/// settings.
nlohmann::json fit_key(const ExportJob& job, const std::function<std::string(const std::string&)>& hash);

/// Returns everything that determines the bytes of the files. Throws Error(kInput) if a file cannot be read.
nlohmann::json export_key(const ExportJob& job);

}  // namespace multum
