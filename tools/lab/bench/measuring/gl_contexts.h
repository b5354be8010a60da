// SPDX-License-Identifier: Apache-2.0
// The GL contexts that this machine gives: each display of EGL, a GPU or software, and OSMesa.
#pragma once

#include <nlohmann/json.hpp>

namespace multum::bench {

/// Rows {"display", "is_software", "description", "reason"}; an empty description: no context, for that reason.
nlohmann::ordered_json list_gl_contexts();

}  // namespace multum::bench
