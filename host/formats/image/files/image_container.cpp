// SPDX-License-Identifier: Apache-2.0
// Layouts: PNG (W3C PNG, 5 "Datastream structure"), JPEG (ITU T.81, B.1.1), WebP (RFC 9649, 2.3), TIFF (TIFF 6.0,
// section 2; BigTIFF). For OpenEXR see host/foundation/base/files/exr_survey.h. Reads only lengths, sizes and markers,
// and checks each against the file.
#include "host/formats/image/files/image_container.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/formats/image/files/ktx2_survey.h"
#include "host/formats/image/files/tiff_survey.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/byte_file.h"
#include "host/foundation/base/files/exr_survey.h"
#include "host/foundation/base/files/regular_file.h"

namespace multum {
namespace {

void keep(ImageContainer& container, std::int64_t begin, std::int64_t end) {
  if (!container.ranges.empty() && container.ranges.back().end == begin) {
    container.ranges.back().end = end;
  } else {
    container.ranges.push_back({begin, end});
  }
}

void add_orientation(ImageContainer& container, int orientation) {
  const std::string note = orientation_note(orientation);
  if (!note.empty()) container.notes.push_back(note);
}

constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n";

// Describes the damage to a PNG signature if most of its bytes are intact. Otherwise returns an empty string. The
// signature contains line ends, which show whether a file was transferred in text mode.
std::string damaged_png_signature(std::string_view head) {
  if (head.starts_with("\x89PNG\r\r\n") || head.starts_with("\x89PNG\r\r\n\x1a"))
    return "its line endings were changed from \\n to \\r\\n, probably by a transfer in text mode";
  if (head.starts_with("\x89PNG\n\x1a"))
    return "its line endings were changed from \\r\\n to \\n, probably by a transfer in text mode";
  if (head.size() < kPngSignature.size()) return "";
  std::string changed;
  std::size_t count = 0;
  for (std::size_t i = 0; i < kPngSignature.size(); ++i) {
    if (head[i] == kPngSignature[i]) continue;
    changed += fmt::format("{}byte {} is 0x{:02x} instead of 0x{:02x}", count++ == 0 ? "" : ", ", i + 1,
                           static_cast<unsigned char>(head[i]), static_cast<unsigned char>(kPngSignature[i]));
  }
  return count <= 2 ? changed : "";
}

// Throws if the colour type does not allow the bits per sample (W3C PNG, table 11.1), and for unknown methods.
void check_png_header(const std::string& path, ByteFile& file) {
  const auto field = [&file](std::int64_t at) { return file.big_endian(at, 1, "a PNG header"); };
  const std::int64_t bits = field(24), colour = field(25);
  struct ColourType {
    std::int64_t number;
    const char* name;
    std::vector<std::int64_t> bits;
  };
  static const std::vector<ColourType> kColourTypes = {{0, "grey", {1, 2, 4, 8, 16}},
                                                       {2, "RGB", {8, 16}},
                                                       {3, "a palette", {1, 2, 4, 8}},
                                                       {4, "grey with alpha", {8, 16}},
                                                       {6, "RGB with alpha", {8, 16}}};
  const auto row = std::find_if(kColourTypes.begin(), kColourTypes.end(),
                                [colour](const ColourType& one) { return one.number == colour; });
  if (row == kColourTypes.end())
    refuse_file(path, fmt::format("damaged PNG: found colour type {}, expected 0, 2, 3, 4 or 6", colour));
  if (std::find(row->bits.begin(), row->bits.end(), bits) == row->bits.end())
    refuse_file(path, fmt::format("damaged PNG: found {} bits per sample, expected {} for {}", bits,
                                  fmt::join(row->bits, ", "), row->name));
  if (field(26) != 0 || field(27) != 0 || field(28) > 1)
    refuse_file(path, fmt::format("damaged PNG: found compression method {}, filter method {} and interlace method {}, "
                                  "expected 0, 0, and 0 or 1",
                                  field(26), field(27), field(28)));
}

constexpr char kFirstFrame[] = "the file is an animation, of which only the first frame is read";

// A PNG file is a signature, then chunks of [length 4][type 4][data][CRC 4]. The picture needs IHDR PLTE tRNS gAMA sRGB
// IDAT IEND. An XMP text chunk of 52 KB keeps OpenImageIO 2.4.7 busy for 15 s
// (SharedDataDeathTest.DamagedAndHostileFilesEndInAnError).
void inspect_png(const std::string& path, ByteFile& file, ImageContainer& container) {
  constexpr std::array<std::string_view, 7> kPicture = {"IHDR", "PLTE", "tRNS", "gAMA", "sRGB", "IDAT", "IEND"};
  keep(container, 0, 8);
  std::int64_t position = 8;
  bool is_srgb = false, has_palette = false, has_rows = false;
  for (bool ended = false; !ended;) {
    const std::int64_t length = file.big_endian(position, 4, "a PNG chunk");
    const std::string type = file.bytes(position + 4, 4, "a PNG chunk");
    const std::int64_t end = position + 12 + length;
    if (end > file.size())
      refuse_file(path, fmt::format("the file is cut short: it ends at byte {}, expected {} at the end of a PNG chunk",
                                    file.size(), end));
    if (position == 8) {
      if (type != "IHDR" || length != 13) refuse_file(path, "damaged PNG: the first chunk is not a header");
      container.width = file.big_endian(position + 8, 4, "the width");
      container.height = file.big_endian(position + 12, 4, "the height");
      check_png_header(path, file);
    }
    has_palette |= type == "PLTE";
    if (type == "IDAT" && !has_palette && file.big_endian(25, 1, "a PNG header") == 3)
      refuse_file(path,
                  "damaged PNG: found no palette (PLTE) before its rows, expected one because its colour type is 3");
    has_rows |= type == "IDAT";
    if (type == "IEND" && !has_rows)
      refuse_file(path, "damaged PNG: found no rows (IDAT), expected at least one chunk");
    if (std::find(kPicture.begin(), kPicture.end(), type) != kPicture.end()) {
      keep(container, position, end);
    } else {
      container.has_metadata = true;
    }
    if (type == "eXIf") add_orientation(container, exif_orientation(file, position + 8, length));
    if (type == "sRGB") is_srgb = true;
    if (type == "gAMA" && length == 4) {
      const std::int64_t value = file.big_endian(position + 8, 4, "a gamma");
      container.gamma = value > 0 ? 100000.0 / static_cast<double>(value) : 0.0;
    }
    if (type == "acTL") container.notes.emplace_back(kFirstFrame);
    ended = type == "IEND";
    position = end;
  }
  if (is_srgb) container.gamma = 0.0;
}

// Reads segments FF marker [length 2][data] up to the first start of scan. Only two application segments matter: APP0
// (JFIF) and APP14 (Adobe: the colour model).
void inspect_jpeg(const std::string& path, ByteFile& file, ImageContainer& container) {
  keep(container, 0, 2);
  std::int64_t position = 2;
  for (;;) {
    if (file.big_endian(position, 1, "a JPEG marker") != 0xFF)
      refuse_file(path, "damaged JPEG: found no marker, expected one");
    const std::int64_t marker = file.big_endian(position + 1, 1, "a JPEG marker");
    if (marker == 0xFF) {  // a fill byte
      ++position;
      continue;
    }
    if (marker == 0xDA) break;
    const std::int64_t end = position + 2 + file.big_endian(position + 2, 2, "a JPEG segment");
    const bool is_frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (is_frame) {
      container.height = file.big_endian(position + 5, 2, "the height");
      container.width = file.big_endian(position + 7, 2, "the width");
    }
    const bool is_application = marker >= 0xE0 && marker <= 0xEF;
    if (marker == 0xE1 && end - position > 10 && file.bytes(position + 4, 4, "a JPEG segment") == "Exif")
      add_orientation(container, exif_orientation(file, position + 4, end - position - 4));
    if (marker == 0xFE || (is_application && marker != 0xE0 && marker != 0xEE)) {
      container.has_metadata = true;
    } else {
      keep(container, position, end);
    }
    position = end;
  }
  keep(container, position, file.size());
  // Looks for the end marker, because the library fills missing rows with grey. Some tools append bytes after this
  // marker.
  const std::int64_t tail_size = std::min<std::int64_t>(file.size(), 65536);
  if (file.bytes(file.size() - tail_size, tail_size, "the end").find("\xFF\xD9") == std::string::npos)
    refuse_file(path, "the file is cut short: no JPEG end marker");
}

// Reads chunks [type 4][length 4][data] after VP8X, which are padded to an even number of bytes.
void inspect_webp_chunks(ByteFile& file, std::int64_t end, ImageContainer& container) {
  for (std::int64_t position = 12; position + 8 <= end;) {
    const std::string type = file.bytes(position, 4, "a WebP chunk");
    const std::int64_t length = file.little_endian(position + 4, 4, "a WebP chunk");
    if (type == "EXIF") add_orientation(container, exif_orientation(file, position + 8, length));
    if (type == "ANIM") container.notes.emplace_back(kFirstFrame);
    position += 8 + length + length % 2;
  }
}

// A WebP file is RIFF [size 4] WEBP, then a chunk with the size of the picture: VP8X (canvas size minus 1, 24 bits),
// VP8L (size minus 1, 14 bits) or VP8 (size, 14 bits).
void inspect_webp(const std::string& path, ByteFile& file, ImageContainer& container) {
  const std::int64_t end = 8 + file.little_endian(4, 4, "the WebP size");
  if (end > file.size())
    refuse_file(path, fmt::format("the file is cut short: {} bytes, expected {} according to its WebP header",
                                  file.size(), end));
  const std::string chunk = file.bytes(12, 4, "a WebP chunk");
  if (chunk == "VP8X") {
    container.width = 1 + file.little_endian(24, 3, "the width");
    container.height = 1 + file.little_endian(27, 3, "the height");
    inspect_webp_chunks(file, end, container);
  } else if (chunk == "VP8L") {
    const std::int64_t sizes = file.little_endian(21, 4, "the size");
    container.width = 1 + (sizes & 0x3fff);
    container.height = 1 + (sizes >> 14 & 0x3fff);
  } else if (chunk == "VP8 ") {
    container.width = file.little_endian(26, 2, "the width") & 0x3fff;
    container.height = file.little_endian(28, 2, "the height") & 0x3fff;
  } else {
    refuse_file(path, "damaged WebP: the first chunk is not a picture");
  }
  keep(container, 0, file.size());
}

// Rejects baked files, because their channels do not hold a map. Baked files are recognised by the attributes of their
// first part (docs/reference/file_format.md).
void refuse_baked_file(const std::string& path, ByteFile& file) {
  std::string representation, source;
  walk_exr_headers(path, file, [&](const ExrAttribute& attribute) {
    const auto text = [&] { return file.bytes(attribute.position, attribute.size, "an EXR header"); };
    if (attribute.part > 0 || attribute.type != "string") return;
    if (attribute.name == "multum:representation") representation = text();
    if (attribute.name == "multum:sourceName") source = text();
  });
  // Pyramids are accepted, because their finest level is a normal picture or height field.
  if (representation.empty() || representation.starts_with("pyramid of ")) return;
  const std::string map = source.empty() ? "the map" : source;
  refuse_file(
      path, fmt::format(
                "is a file that multum baked from {0} ({1}), expected a map. Use {2} itself, or pass the baked file to "
                "'multum info', 'multum verify', 'multum export' (as NAME.ndf.exr), 'multum look' or 'multum-view'",
                source.empty() ? "a map" : source, representation, map));
}

void inspect_exr(const std::string& path, ByteFile& file, ImageContainer& container, std::int64_t texel_count_max) {
  const std::vector<ExrPartSize> parts = survey_exr(path, file);
  refuse_baked_file(path, file);
  for (const ExrPartSize& part : parts) check_image_size(path, part.width, part.height, texel_count_max);
  container.width = parts.front().width;
  container.height = parts.front().height;
  if (!parts.front().subsampled.empty())
    refuse_file(path,
                fmt::format("found channel {} with fewer samples than texels, as in luminance/chroma images (Y, RY, "
                            "BY); expected red, green and blue in every texel. Convert the image to RGB first",
                            parts.front().subsampled));
  if (parts.size() > 1)
    container.notes.push_back(fmt::format("the file has {} parts, of which only the first is read", parts.size()));
  keep(container, 0, file.size());
}

// Returns whether all words of a colour map are multiples of `unit`, and some of them are not 0. Some programs multiply
// 8-bit values by 256 instead of 257.
bool have_unit(ByteFile& file, const ByteRange& words, bool is_big_endian, int unit) {
  bool has_any = false;
  for (std::int64_t at = words.begin; at < words.end; at += 2) {
    const std::int64_t value =
        is_big_endian ? file.big_endian(at, 2, "a colour map") : file.little_endian(at, 2, "a colour map");
    if (value % unit != 0) return false;
    has_any |= value != 0;
  }
  return has_any;
}

constexpr int kWhiteIsZero = 0, kPalette = 3;
constexpr int kUnsigned = 1, kSigned = 2, kFloats = 3;

std::string either(const std::vector<int>& numbers) { return fmt::format("{}", fmt::join(numbers, ", ")); }

// Rejects files that OpenImageIO 2.4.7 misreads without an error. Each kind has a case in
// tests/cli/odd_inputs/odd_cases.py. Ink colours and Lab colours are not vectors, and they are not light. OpenImageIO
// mixes up the bytes of 24-bit samples, and reads signed integers of few bits as unsigned integers. OpenImageIO also
// assumes 8 bits if the file does not state the number, although the standard means 1.
void refuse_misread_tiff(const std::string& path, const TiffSurvey& tiff) {
  if (!tiff.is_whole) return;                                   // the library reports the fault
  const std::vector<int> kOtherColours = {5, 8, 9, 10, 32803};  // CMYK, three kinds of Lab, a camera's mosaic
  if (std::find(kOtherColours.begin(), kOtherColours.end(), tiff.photometric) != kOtherColours.end())
    refuse_file(path, fmt::format("found a TIFF that stores CMYK, Lab or a colour filter array "
                                  "(PhotometricInterpretation {}), expected grey, RGB or a palette",
                                  tiff.photometric));
  if (tiff.bits == 0) refuse_file(path, "found a TIFF without bits per sample, expected the tag BitsPerSample");
  const std::vector<int> bits = tiff.sample_format == kFloats     ? std::vector{16, 32, 64}
                                : tiff.sample_format == kSigned   ? std::vector{8, 16, 32}
                                : tiff.sample_format == kUnsigned ? std::vector{1, 2, 4, 6, 8, 10, 12, 14, 16, 32}
                                                                  : std::vector<int>{};
  if (!bits.empty() && std::find(bits.begin(), bits.end(), tiff.bits) == bits.end())
    refuse_file(path, fmt::format("found a TIFF with {} bits per sample, expected {} for {}", tiff.bits, either(bits),
                                  tiff.sample_format == kFloats   ? "floats"
                                  : tiff.sample_format == kSigned ? "signed integers"
                                                                  : "unsigned integers"));
  if (tiff.photometric == kPalette && tiff.samples > 1)
    refuse_file(path, fmt::format("found a TIFF with a palette and {} channels, expected one", tiff.samples));
  if (tiff.photometric == kWhiteIsZero && tiff.bits <= 8 && tiff.samples > 1)
    refuse_file(path, fmt::format("found a TIFF with {} bits per sample, where 0 is white (MinIsWhite), and {} "
                                  "channels, all of which would be inverted; expected one channel, or 0 as black",
                                  tiff.bits, tiff.samples));
  if (tiff.bits == 64 && tiff.is_tiled && (tiff.samples == 1 || !tiff.is_planar))
    refuse_file(
        path,
        "found a TIFF with 64-bit floats in tiles, which OpenImageIO does not read; expected 32-bit floats or strips");
  if (tiff.bits == 64 && tiff.compression != 1 && !tiff.is_tiled && tiff.rows_per_strip == 0)
    refuse_file(path,
                "found a compressed TIFF with 64-bit floats and no rows per strip (RowsPerStrip), which OpenImageIO "
                "does not read; expected 32-bit floats, or that tag");
}

// Workaround "TIFF rows": OpenImageIO 2.4.7 multiplies by the number of rows per strip, which may be the largest
// possible number. OpenImageIO then runs forever, or leaves doubles unread. Therefore the number is limited to the
// number of rows of the picture.
void limit_strip_rows(ByteFile& file, const TiffSurvey& tiff, ImageContainer& container) {
  if (tiff.height < 1 || tiff.rows_per_strip <= tiff.height) return;
  const bool is_big_endian = file.bytes(0, 1, "the first byte") == "M";
  const std::int64_t size = tiff.rows_per_strip_at.end - tiff.rows_per_strip_at.begin;
  std::string bytes;
  for (std::int64_t i = 0; i < size; ++i)
    bytes += static_cast<char>(tiff.height >> 8 * (is_big_endian ? size - 1 - i : i) & 255);
  container.patches.push_back({tiff.rows_per_strip_at.begin, bytes});
}

// Workaround "TIFF white": if 0 means white in a picture, OpenImageIO 2.4.7 inverts values of up to 8 bits, but not
// longer ones (ImageReaderTest.WhiteIsZeroOfTiff). With floats, no value means black. Workaround "TIFF palette":
// OpenImageIO divides words of a colour map by 257, so words of `v * 256` become one code too low
// (ImageReaderTest.PalettesOfTiff).
void inspect_tiff(const std::string& path, ByteFile& file, ImageContainer& container) {
  keep(container, 0, file.size());
  const TiffSurvey tiff = survey_tiff(file, 0);
  if (tiff.photometric == kWhiteIsZero && tiff.sample_format != kUnsigned)
    refuse_file(path,
                "found a TIFF with signed integers or floats, where 0 is white (MinIsWhite); expected unsigned "
                "integers, whose black is known, or 0 as black");
  refuse_misread_tiff(path, tiff);
  limit_strip_rows(file, tiff, container);
  container.inverts_integers = tiff.photometric == kWhiteIsZero && tiff.bits > 8;
  const std::int64_t words = (tiff.colour_map.end - tiff.colour_map.begin) / 2;
  const bool is_palette = tiff.photometric == kPalette && words > 0 && words <= 3 * 65536;
  if (is_palette) {
    const bool is_big_endian = file.bytes(0, 1, "the first byte") == "M";
    if (have_unit(file, tiff.colour_map, is_big_endian, 256)) container.byte_words.push_back(tiff.colour_map);
    else if (!have_unit(file, tiff.colour_map, is_big_endian, 257))
      container.notes.emplace_back(
          "its palette has 16-bit colours, but only the upper 8 bits are read: the error is up to 1/255");
  }
  add_orientation(container, tiff.orientation);
  if (tiff.page_count > 1)
    container.notes.push_back(
        fmt::format("the file has {} pages, of which only the first is read{}", tiff.page_count,
                    tiff.is_reduced ? ", although the file says that it is a reduced version of another page" : ""));
  else if (tiff.is_reduced)
    container.notes.emplace_back("the file says that its picture is a reduced version of another picture");
  container.texel_metres = tiff.texel_metres;
  container.no_data = tiff.no_data;
}

constexpr std::size_t kHeadBytes = 16;  // enough to recognize every format

std::string format_of(std::string_view head) {
  using namespace std::string_view_literals;
  if (head.starts_with(kPngSignature)) return "png";
  if (head.starts_with("\xFF\xD8\xFF"sv)) return "jpeg";
  if (head.starts_with("RIFF"sv) && head.size() >= 12 && head.substr(8, 4) == "WEBP"sv) return "webp";
  if (head.starts_with("\x76\x2f\x31\x01"sv)) return "openexr";
  if (head.starts_with(std::string_view(kKtx2Magic, 12))) return "ktx2";
  for (const std::string_view magic : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv})
    if (head.starts_with(magic)) return "tiff";
  return "";
}

// Recognizes files that are not images, but that users may pass by mistake.
std::string other_kind(std::string_view head) {
  using namespace std::string_view_literals;
  constexpr char kExpected[] = "expected PNG, JPEG, WebP, TIFF or OpenEXR";
  if (head.starts_with("DDS "sv))
    return fmt::format("a DDS texture for GPUs, {}; give the map from which it was made", kExpected);
  if (head.starts_with("glTF"sv))
    return fmt::format("a glTF model, {}. 'multum gltf' converts a model, and 'multum materials' lists its maps",
                       kExpected);
  return "";
}

}  // namespace

void check_image_size(const std::string& path, std::int64_t width, std::int64_t height, std::int64_t texel_count_max) {
  if (width < 1 || height < 1)
    refuse_file(path, fmt::format("found {} x {} texels, expected at least 1 x 1", width, height));
  if (width > texel_count_max / height || width > INT32_MAX || height > INT32_MAX)
    refuse_file(path, fmt::format("found {} x {} texels, expected at most {} in all", width, height, texel_count_max));
}

std::string image_format(const std::string& path) { return format_of(first_bytes(path, kHeadBytes)); }

ImageContainer inspect_image_container(const std::string& path, std::int64_t texel_count_max) {
  ByteFile file(path);
  ImageContainer container;
  container.file_size = file.size();
  const std::string head = file.bytes(0, std::min<std::int64_t>(kHeadBytes, file.size()), "the first bytes");
  container.format = format_of(head);
  if (const std::string changed = damaged_png_signature(head); container.format.empty() && !changed.empty())
    refuse_file(path, fmt::format("damaged PNG: in its signature, {}", changed));
  if (container.format.empty()) {
    const std::string other = other_kind(head);
    refuse_file(path, other.empty() ? fmt::format("found an unknown format ({} bytes), expected PNG, JPEG, WebP, TIFF "
                                                  "or OpenEXR",
                                                  file.size())
                                    : fmt::format("found {}", other));
  }
  if (container.format == "png") {
    inspect_png(path, file, container);
  } else if (container.format == "jpeg") {
    inspect_jpeg(path, file, container);
  } else if (container.format == "webp") {
    inspect_webp(path, file, container);
  } else if (container.format == "openexr") {
    inspect_exr(path, file, container, texel_count_max);
  } else if (container.format == "ktx2") {
    const Ktx2Survey survey = survey_ktx2(path, file);
    container.width = survey.width;
    container.height = survey.height;
  } else {
    inspect_tiff(path, file, container);
    return container;
  }
  check_image_size(path, container.width, container.height, texel_count_max);
  return container;
}

}  // namespace multum
