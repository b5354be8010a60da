// SPDX-License-Identifier: Apache-2.0
// Names the engines that are known not to load an export's files. Some say nothing and draw without the texture.
#pragma once

#include <string>
#include <vector>

#include "host/delivery/export/material_folder.h"

namespace multum {

/// Names of engines that refuse such files, or show nothing for them; sources and versions are in
/// docs/evidence/EXPORT.md. Empty: none is known.
std::vector<std::string> engines_that_fail(MaterialFormat format, MaterialTexels texels);

/// The same as one line with a way out, without a newline; empty: none is known. `uastc`: the option that asks for
/// UASTC.
std::string engine_line(MaterialFormat format, MaterialTexels texels, const std::string& uastc);

}  // namespace multum
