// SPDX-License-Identifier: Apache-2.0
// Finds the highest job number in the file names of the folder DATA.
#pragma once

#include <cstdint>
#include <string>

namespace multum {

/// Returns the highest job number in the name of a log, of pictures or of a staging folder, or 0 if there is none.
std::int64_t highest_job_number(const std::string& data);

}  // namespace multum
