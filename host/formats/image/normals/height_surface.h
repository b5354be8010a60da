// SPDX-License-Identifier: Apache-2.0
// Provides the heights of an image, and heights beyond its borders. The computation of slopes, their measurements and
// dequantization all use these heights.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/raw_image.h"

namespace multum {

/// The ways in which colour channels can hold a height. For kGrey, the height is the mean of the channels. The others
/// have 8 bits per channel, and V is the number with these bytes, of which red is the highest. kPacked16 is V / 65535,
/// from red and green. kPacked24 is V / 16777215, from all three channels. kTerrarium is V / 256 - 32768 metres.
/// kMapbox is V / 10 - 10000 metres.
enum class HeightCoding { kGrey, kPacked16, kPacked24, kTerrarium, kMapbox };

/// Returns "16-bit heights packed in red and green", "Terrarium elevation in metres" and so on. For kGrey, returns "".
std::string height_coding_name(HeightCoding coding);

struct HeightReading {
  HeightCoding coding = HeightCoding::kGrey;
  std::optional<float> no_data;  // value, as converted by RawImage, that marks a missing height
};

/// Returns how large a difference of 1 is in the file's own numbers: 255 for 8 bits, 1 for floats and metres.
double value_unit(const RawImageInfo& info, const HeightReading& reading);

/// Rows of heights. NaN means that there is no height.
struct HeightRows {
  int column_begin = 0;  // < 0 if there are columns beyond the border
  int row_begin = 0;
  int row_width = 0;
  std::vector<float> values;

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row - row_begin) * static_cast<std::size_t>(row_width) +
           static_cast<std::size_t>(column - column_begin);
  }
  float at(int column, int row) const { return values[index(column, row)]; }
  int row_count() const {
    return row_width > 0 ? static_cast<int>(values.size() / static_cast<std::size_t>(row_width)) : 0;
  }
  const float* row(int number) const { return &values[index(column_begin, number)]; }
};

/// The surface beyond one side. There can be no surface, the opposite side of the image, heights of 0, or a strip of
/// another image.
struct HeightSide {
  enum class Beyond { kEnd, kWrapped, kBlack, kStrip };
  Beyond beyond = Beyond::kEnd;
  // For kStrip, rows or columns next to the border, in picture order. Texels beyond the depth of the strip are unknown.
  std::shared_ptr<const HeightRows> strip = nullptr;
};

struct HeightSides {
  HeightSide left, right, above, below;
};

/// Returns the sides for wrap modes. With clamp and mirror, the surface ends. The mirror line is between texels, and a
/// slope would change its sign there, so a texel uses only the slope on its own side.
HeightSides wrapped_sides(WrapMode wrap_s, WrapMode wrap_t);

class HeightSurface {
 public:
  /// The image must outlive the object. Heights that are not finite are repaired according to `fix_nan`, unless
  /// `is_finite` says that there are none. kBox3 uses the mean of the finite 3 x 3 neighbours, or 0 if there are none.
  /// kBlack uses 0.
  HeightSurface(const RawImage& image, const HeightReading& reading, bool is_finite, FixNan fix_nan,
                HeightSides sides = {});

  int width() const { return image_.info().width; }
  int height() const { return image_.info().height; }
  const RawImageInfo& info() const { return image_.info(); }
  const HeightReading& reading() const { return reading_; }
  const HeightSides& sides() const { return sides_; }

  /// Returns rows [row_begin, row_end), which may be beyond the image, with the columns from -margin to width + margin.
  /// Several threads may read at the same time.
  HeightRows rows(int row_begin, int row_end, int margin) const;

 private:
  HeightRows merged_rows(int row_begin, int row_end) const;
  HeightRows repaired_rows(int row_begin, int row_end) const;
  bool is_no_data(const float* texel, std::size_t channel_count) const;
  void append_row(int row, int margin, HeightRows& rows) const;
  void append_own_row(const float* own, int row, int margin, HeightRows& rows) const;

  const RawImage& image_;
  HeightReading reading_;
  bool is_finite_;
  FixNan fix_nan_;
  HeightSides sides_;
};

}  // namespace multum
