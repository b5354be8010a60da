// SPDX-License-Identifier: Apache-2.0
// Text of docs/reference/openapi.json, as it was when this was built.
#pragma once

namespace multum {

extern const char* const openapi_json;

}  // namespace multum
