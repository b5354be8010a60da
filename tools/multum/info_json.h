// SPDX-License-Identifier: Apache-2.0
// Describes a file as JSON for `multum info --json`.
#pragma once

#include <string>

#include "tools/multum/json_output.h"

namespace multum {

/// Describes the header of a baked file or a pyramid. Throws Error(kInput) for a file that cannot be read.
OrderedJson baked_file_json(const std::string& path);

}  // namespace multum
