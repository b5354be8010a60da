// SPDX-License-Identifier: Apache-2.0
// Reads the numbers of an image file. Image libraries run in a child process (child_image_file.cpp), because some
// broken files crash the process that opens them, and because loading OpenImageIO takes a quarter of a second.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/image/files/image_container.h"
#include "host/foundation/sandbox/decoding_child.h"

namespace multum {

/// A file's own description of one of its pictures. Code may rely only on the fields that check_described() checks.
struct ImagePart {
  int x = 0, y = 0, width = 0, height = 0, depth = 1;  // the data window
  int full_x = 0, full_y = 0, full_width = 0, full_height = 0;
  int tile_width = 0, tile_height = 0;  // 0 for scan lines
  int alpha_channel = -1;
  bool is_deep = false;
  int base_type = 0;                         // type of the widest channel (host/formats/image/files/number_type.h)
  std::vector<std::string> channel_names;    // one per channel
  std::vector<int> channel_types = {};       // types of the channels if they differ; empty if all are base_type
  std::string colour_space, compression;     // names from the file; may be empty
  int rows_per_strip = 0;                    // only for TIFF
  std::map<std::string, std::string> texts;  // string attributes; only if the file was opened with all_parts

  int channel_count() const { return static_cast<int>(channel_names.size()); }
  int type_of(int channel) const {
    return channel_types.empty() ? base_type : channel_types[static_cast<std::size_t>(channel)];
  }
  std::size_t texel_bytes() const;
};

struct ImageDescription {
  std::string format;  // as in ImageContainer
  std::int64_t file_size = 0;
  std::vector<ImagePart> parts;
  std::vector<std::string> notes = {};  // as in ImageContainer
  double texel_metres = 0.0;            // as in ImageContainer
  std::optional<double> no_data = {};   // as in ImageContainer
};

/// Rows of some channels as numbers of one type, with interleaved channels.
struct PixelBlock {
  int part = 0;
  int y_begin = 0, y_end = 0;  // in the data window's coordinates
  int channel_begin = 0, channel_end = 0;
  int base_type = 0;
};
std::size_t block_bytes(const ImagePart& part, const PixelBlock& block);

struct ImageFileSettings {
  std::int64_t texel_count_max = std::int64_t{1} << 30;
  int threads = 1;         // <= 0 means one per core
  bool all_parts = false;  // true for all parts and their texts; false for the first part
};

class ImageFile {
 public:
  virtual ~ImageFile() = default;
  const ImageDescription& description() const { return description_; }
  const ImagePart& part(int index = 0) const { return description_.parts[static_cast<std::size_t>(index)]; }

  /// Returns memory for read(). The memory is valid until the next call, which discards the contents.
  virtual std::byte* reserve(std::size_t byte_count) = 0;
  /// Reads the block to this offset in the reserved memory. Returns the error message of the library, or "" after
  /// success. While a child works, calls `while_waiting`, which may throw. Throws Error like open_image_file().
  virtual std::string read(const PixelBlock& block, std::size_t offset,
                           const std::function<void()>& while_waiting = {}) = 0;

 protected:
  ImageDescription description_;
};

/// Opens a file, or an image in memory by its name. Throws Error(kInput), which names the file, if it is missing,
/// damaged or of another format, or takes too long to decode.
std::unique_ptr<ImageFile> open_image_file(const std::string& path, const ImageFileSettings& settings);

/// Sets how open_image_file() opens files in the whole process. By default, files are opened in a child with the
/// defaults of DecodingChild.
using ImageOpener = std::function<std::unique_ptr<ImageFile>(const std::string&, const ImageFileSettings&)>;
void set_image_opener(ImageOpener opener);

/// Returns an opener that decodes in a child.
ImageOpener open_in_child(const DecodingChild& child);

/// Throws Error(kInput) if a description cannot belong to a picture, because later code computes with its numbers.
void check_described(const std::string& path, const ImageDescription& description, std::int64_t texel_count_max);

}  // namespace multum
