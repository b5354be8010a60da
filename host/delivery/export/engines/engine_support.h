// SPDX-License-Identifier: Apache-2.0
// Names the engines that are known to fail to load an export's files. Some engines then draw without the texture and
// report no error.
#pragma once

#include <string>
#include <vector>

#include "host/delivery/export/material_folder.h"

namespace multum {

/// Returns the names of engines that refuse such files or draw without them. The result is empty if no such engine is
/// known. docs/evidence/EXPORT.md lists sources and versions.
std::vector<std::string> engines_that_fail(MaterialFormat format, MaterialTexels texels);

/// Returns the names of these engines and a remedy as one line of text without a newline. The result is empty if no
/// such engine is known. `uastc` is the option that selects UASTC.
std::string engine_line(MaterialFormat format, MaterialTexels texels, const std::string& uastc);

}  // namespace multum
