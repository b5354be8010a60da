// SPDX-License-Identifier: Apache-2.0
// An open EXR file of one or several parts, with its channels by name and its string attributes.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/formats/image/files/image_file.h"

namespace multum {

class ExrFile {
 public:
  /// Throws Error(kInput), which names the file, if it is missing, damaged, not an EXR file, or deep. Also rejects a
  /// part whose data window differs from the display window, because the pixels would be in the wrong places.
  explicit ExrFile(std::string path);

  int width() const { return width_; }
  int height() const { return height_; }
  const std::string& path() const { return path_; }
  const std::vector<std::string>& channels() const { return channels_; }
  bool has_channel(const std::string& name) const { return places_.count(name) > 0; }
  /// Returns the names of all channels. If the file has several parts, also returns each name with the name of its part
  /// as a prefix: "CryptoObject00.R" for channel "R" of part "CryptoObject00". has_channel() and read() know these
  /// names too.
  std::vector<std::string> all_names() const;
  /// Returns the string attributes of all parts. If several parts have the same attribute, the value in the first of
  /// these parts is used.
  const std::map<std::string, std::string>& attributes() const { return attributes_; }

  /// Returns width * height floats, with row 0 at the top. Throws Error(kInput) if the channel is missing (the message
  /// lists the existing ones), has integers, or has damaged rows.
  std::vector<float> read(const std::string& channel);
  /// Returns whether the samples of the channel are 32-bit floats. If so, reading keeps their bits.
  bool is_float(const std::string& channel) const;

 private:
  struct Place {
    int part, index;
    int type;  // OpenImageIO's base type
  };
  void list_part(int index, const ImagePart& part);

  std::string path_;
  std::unique_ptr<ImageFile> file_;
  int width_ = 0, height_ = 0;
  std::vector<std::string> channels_;
  std::map<std::string, Place> places_;
  std::map<std::string, std::string> attributes_;
};

}  // namespace multum
