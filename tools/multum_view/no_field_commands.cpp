// SPDX-License-Identifier: Apache-2.0
// Replaces fields/field_commands.cpp in builds without fields.
#include "host/foundation/base/error.h"
#include "tools/multum_view/view_commands.h"

namespace multum {

std::vector<ViewCommand> field_commands() { return {}; }

void draw_field_thumbnail(const ThumbnailOptions& options) {
  throw Error(ErrorCode::kUsage, options.result +
                                     ": is a folder, expected a baked file: this multum-view was built without fields "
                                     "(CMake option MULTUM_FIELDS)");
}

}  // namespace multum
