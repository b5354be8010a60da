// SPDX-License-Identifier: Apache-2.0
// Lists what the bytes of an export depend on, to tell whether what is there is still of the same map and settings.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "host/delivery/export/export_job.h"

namespace multum {

/// Everything that decides a fit: this program, the files that it reads by `hash`, and the settings of the lobe.
nlohmann::json fit_key(const ExportJob& job, const std::function<std::string(const std::string&)>& hash);

/// Everything that decides a byte of the files. Throws Error(kInput) when a file cannot be read.
nlohmann::json export_key(const ExportJob& job);

}  // namespace multum
