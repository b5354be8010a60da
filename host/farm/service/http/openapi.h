// SPDX-License-Identifier: Apache-2.0
// The text of docs/reference/openapi.json at build time.
#pragma once

namespace multum {

extern const char* const openapi_json;

}  // namespace multum
