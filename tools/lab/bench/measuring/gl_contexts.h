// SPDX-License-Identifier: Apache-2.0
// Lists the GL contexts of this machine: each EGL display (a GPU or software), and OSMesa.
#pragma once

#include <nlohmann/json.hpp>

namespace multum::bench {

/// Returns rows {"display", "is_software", "description", "reason"}. Without a context, the description is empty and
/// the
/// reason says why.
nlohmann::ordered_json list_gl_contexts();

}  // namespace multum::bench
