// SPDX-License-Identifier: Apache-2.0
// Pictures side by side, each under a line of text.
#pragma once

#include <string>
#include <vector>

#include "runtime_gl/gl/framebuffer.h"

namespace multum::gl {

struct SheetCell {
  std::string label;  // lower-case letters, digits and . , : % - + / ( ) | = _; others are drawn as blanks
  FloatImage image;
};

/// Rows of cells, all images of one size; a row may be shorter than the first. Labels are always whole: cells are as
/// wide as the longest one where the images are narrower. `label_value`: the letters' grey.
FloatImage make_contact_sheet(const std::vector<std::vector<SheetCell>>& rows, float label_value);

}  // namespace multum::gl
