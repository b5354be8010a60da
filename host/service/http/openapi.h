// SPDX-License-Identifier: Apache-2.0
// Text of docs/openapi.json, as it was when this was built.
#pragma once

#include <string>

namespace multum {

const std::string& openapi_json();

}  // namespace multum
