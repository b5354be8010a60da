// SPDX-License-Identifier: Apache-2.0
// Reads blocks of an image from a library that decodes rows only in their order.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "host/formats/decoder/library_image_file.h"

namespace multum {

/// Decodes rows one after another, from the top.
class RowStream {
 public:
  virtual ~RowStream() = default;
  virtual ImagePart part() const = 0;
  /// Decodes all channels of the next row. Returns the library's error message, or "" after success.
  virtual std::string read_row(std::uint8_t* row) = 0;
};

using RowStreamOpener = std::function<std::unique_ptr<RowStream>()>;

/// Reads rows from `stream`. Whenever an earlier row is needed, `reopen` returns a stream that begins again.
std::unique_ptr<LibraryImageFile> make_row_image_file(const ImageContainer& container,
                                                      std::unique_ptr<RowStream> stream, RowStreamOpener reopen);

}  // namespace multum
