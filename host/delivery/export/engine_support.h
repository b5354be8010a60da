// SPDX-License-Identifier: Apache-2.0
// Names the engines that are known not to load an export's files. Some engines draw without the texture and report
// no error.
#pragma once

#include <string>
#include <vector>

#include "host/delivery/export/material_folder.h"

namespace multum {

/// Returns the names of engines that refuse such files or draw nothing for them. Empty if no such engine is known.
/// Sources and versions are in docs/evidence/EXPORT.md.
std::vector<std::string> engines_that_fail(MaterialFormat format, MaterialTexels texels);

/// Returns the names of these engines as one line of text with a remedy, without a newline. Empty if no such engine is
/// known. `uastc` is the option that selects UASTC.
std::string engine_line(MaterialFormat format, MaterialTexels texels, const std::string& uastc);

}  // namespace multum
