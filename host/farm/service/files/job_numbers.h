// SPDX-License-Identifier: Apache-2.0
// Finds which numbers of jobs a folder DATA knows.
#pragma once

#include <cstdint>
#include <string>

namespace multum {

/// The highest number of a job that anything there is named by: a log, pictures, a staging folder; 0: of none.
std::int64_t highest_job_number(const std::string& data);

}  // namespace multum
