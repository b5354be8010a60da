// SPDX-License-Identifier: Apache-2.0
// Directories: [count 2][entry 12]...[next 4]; in BigTIFF [count 8][entry 20]...[next 8].
//   entry   [tag 2][type 2][count 4 or 8][value or its position: 4 or 8]
// GeoTIFF 1.1 (OGC 19-008): ModelPixelScale is three doubles. GeoKeyDirectory is words: [header 4], then [key, 0, 1,
// value] for each value stored in it. GDAL_NODATA is a text (gdal.org/drivers/raster/gtiff.html).
#include "host/formats/image/files/tiff_survey.h"

#include <bit>
#include <cmath>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "host/foundation/base/error.h"
#include "host/foundation/base/leading_number.h"

namespace multum {
namespace {

constexpr int kPageCountMax = 1000;  // further pages are not counted
constexpr std::int64_t kEntryCountMax = 4096;

struct Value {
  int type;
  std::int64_t count;
  std::int64_t position;  // position of its first value in the file
};

class Directories {
 public:
  Directories(ByteFile& file, std::int64_t base) : file_(file), base_(base) {
    is_big_endian_ = file_.bytes(base_, 2, "a TIFF header") == "MM";
    is_big_tiff_ = number(base_ + 2, 2) == 43;
  }
  std::int64_t first() { return base_ + (is_big_tiff_ ? number(base_ + 8, 8) : number(base_ + 4, 4)); }

  std::int64_t number(std::int64_t position, int count) {
    return is_big_endian_ ? file_.big_endian(position, count, "a TIFF directory")
                          : file_.little_endian(position, count, "a TIFF directory");
  }
  // Passes every directory entry to `visit`. Returns the position of the next directory. Positions are relative to
  // `base`.
  template <typename Visit>
  std::int64_t walk(std::int64_t directory, const Visit& visit) {
    const int count_bytes = is_big_tiff_ ? 8 : 2, entry_bytes = is_big_tiff_ ? 20 : 12, word = is_big_tiff_ ? 8 : 4;
    const std::int64_t count = number(directory, count_bytes);
    if (count < 0 || count > kEntryCountMax) return base_;
    std::int64_t entry = directory + count_bytes;
    for (std::int64_t i = 0; i < count; ++i, entry += entry_bytes) {
      Value value{static_cast<int>(number(entry + 2, 2)), number(entry + 4, word), entry + 4 + word};
      const std::int64_t bytes = type_bytes(value.type) * value.count;
      if (value.count < 1 || value.count > file_.size() || bytes == 0) continue;
      if (bytes > word) value.position = base_ + number(value.position, word);
      if (value.position < 0 || value.position > file_.size() - bytes) continue;
      visit(static_cast<int>(number(entry, 2)), value);
    }
    return base_ + number(entry, word);
  }
  // Returns a value of type short or long.
  int integer(const Value& value) {
    if (value.type != 3 && value.type != 4) return -1;
    return static_cast<int>(number(value.position, value.type == 3 ? 2 : 4));
  }
  double real(const Value& value) {
    if (value.type != 12) return 0.0;
    const auto half = [&](int i) { return static_cast<std::uint64_t>(number(value.position + 4 * i, 4)); };
    return std::bit_cast<double>(is_big_endian_ ? half(0) << 32 | half(1) : half(1) << 32 | half(0));
  }
  // Reads a number written as text.
  std::optional<double> text_number(const Value& value) {
    constexpr std::int64_t kLengthMax = 64;
    if (value.type != 2 || value.count > kLengthMax) return std::nullopt;
    const std::string text = file_.bytes(value.position, value.count, "a TIFF text");
    const std::optional<double> number = leading_number(text);
    return number && std::isfinite(*number) ? number : std::nullopt;
  }
  // Returns whether GeoTIFF's key directory says that x and y are in metres.
  bool is_in_metres(const Value& keys) {
    if (keys.type != 3) return false;
    constexpr int kModelType = 1024, kProjected = 1, kLinearUnit = 3076, kMetre = 9001;
    bool is_projected = false;
    for (std::int64_t i = 4; i + 3 < keys.count; i += 4) {
      const std::int64_t at = keys.position + 2 * i;
      const auto key = number(at, 2), place = number(at + 2, 2), value = number(at + 6, 2);
      if (place != 0) continue;
      if (key == kModelType) is_projected = value == kProjected;
      if (key == kLinearUnit && value != kMetre) return false;
    }
    return is_projected;
  }
  std::int64_t base() const { return base_; }

 private:
  static std::int64_t type_bytes(int type) {
    constexpr std::array<std::int64_t, 19> kBytes = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};
    return type >= 0 && type < static_cast<int>(kBytes.size()) ? kBytes[static_cast<std::size_t>(type)] : 0;
  }
  ByteFile& file_;
  std::int64_t base_;
  bool is_big_endian_ = false, is_big_tiff_ = false;
};

void survey_first(Directories& directories, int tag, const Value& value, TiffSurvey& survey,
                  std::optional<Value>& geo_keys) {
  switch (tag) {
    case 254: survey.is_reduced = (directories.integer(value) & 1) == 1; break;
    case 257: survey.height = directories.integer(value); break;
    case 258: survey.bits = directories.integer(value); break;
    case 259: survey.compression = directories.integer(value); break;
    case 262: survey.photometric = directories.integer(value); break;
    case 274: survey.orientation = directories.integer(value); break;
    case 277: survey.samples = directories.integer(value); break;
    case 278:
      if (value.type != 3 && value.type != 4) break;
      survey.rows_per_strip_at = {value.position, value.position + (value.type == 3 ? 2 : 4)};
      survey.rows_per_strip = directories.number(value.position, value.type == 3 ? 2 : 4);
      break;
    case 284: survey.is_planar = directories.integer(value) == 2; break;
    case 320:
      if (value.type == 3) survey.colour_map = {value.position, value.position + 2 * value.count};
      break;
    case 322: survey.is_tiled = true; break;
    case 339: survey.sample_format = directories.integer(value); break;
    case 33550: survey.texel_metres = directories.real(value); break;
    case 34735: geo_keys = value; break;
    case 42113: survey.no_data = directories.text_number(value); break;
    default: break;
  }
}

}  // namespace

TiffSurvey survey_tiff(ByteFile& file, std::int64_t base) {
  TiffSurvey survey;
  std::optional<Value> geo_keys;
  try {
    Directories directories(file, base);
    std::int64_t next = directories.walk(directories.first(), [&](int tag, const Value& value) {
      survey_first(directories, tag, value, survey, geo_keys);
    });
    survey.is_whole = true;
    if (!geo_keys || !directories.is_in_metres(*geo_keys)) survey.texel_metres = 0.0;
    std::set<std::int64_t> seen;  // a chain of directories may contain a loop
    while (next > base && survey.page_count < kPageCountMax && seen.insert(next).second) {
      next = directories.walk(next, [](int, const Value&) {});
      ++survey.page_count;
    }
  } catch (const Error&) {  // cut or damaged; libtiff decides whether the picture can be read
  }
  if (!(survey.texel_metres > 0.0) || !std::isfinite(survey.texel_metres)) survey.texel_metres = 0.0;
  return survey;
}

int exif_orientation(ByteFile& file, std::int64_t position, std::int64_t size) {
  try {
    if (size >= 6 && file.bytes(position, 4, "an EXIF block") == "Exif") position += 6;
    const std::string order = file.bytes(position, 2, "an EXIF block");
    return order == "II" || order == "MM" ? survey_tiff(file, position).orientation : 1;
  } catch (const Error&) {
    return 1;
  }
}

std::string orientation_note(int orientation) {
  constexpr std::array<const char*, 9> kNames = {"",
                                                 "",
                                                 "mirrored",
                                                 "turned by 180 degrees",
                                                 "upside down",
                                                 "mirrored and turned",
                                                 "turned by 90 degrees",
                                                 "mirrored and turned",
                                                 "turned by 270 degrees"};
  if (orientation < 2 || orientation > 8) return "";
  return fmt::format(
      "the file says that its picture should be shown {} (orientation {}), which is not applied: rows are read in "
      "stored order. If that is wrong, rotate a height field first (oiiotool --autoorient IN -o OUT). Do not rotate a "
      "normal map this way: its vectors would not be rotated",
      kNames[static_cast<std::size_t>(orientation)], orientation);
}

}  // namespace multum
