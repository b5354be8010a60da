// SPDX-License-Identifier: Apache-2.0
// Draws pictures next to each other, each below a line of text.
#pragma once

#include <string>
#include <vector>

#include "runtime_gl/gl/framebuffer.h"

namespace multum::gl {

struct SheetCell {
  std::string label;  // lower-case letters, A E L N T, digits and . , : % - + / ( ) | = _; others are drawn as blanks
  FloatImage image;
};

/// Draws rows of cells with images of the same size. Rows may be shorter than the first row. Letters are large enough
/// to be read when the sheet is shown 1280 pixels wide, if the images have room for them. Labels are never cut. If the
/// images are narrower than the longest label, cells are as wide as this label. `label_value` is the letters' grey
/// value.
FloatImage make_contact_sheet(const std::vector<std::vector<SheetCell>>& rows, float label_value);

/// Draws a legend for pictures that show differences times `gain`: a ramp from no difference to the difference that is
/// drawn in white. `white` is the value that is displayed as white.
FloatImage difference_legend(int width, int height, float gain, float white);

}  // namespace multum::gl
