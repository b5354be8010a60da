// SPDX-License-Identifier: Apache-2.0
// Stores pyramids of plain averages (Williams 1983) in files that any reader of mip-mapped textures can use. Such a
// file has one tiled part with all levels and linear values (docs/reference/file_format.md, "Pyramids").
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/formats/asset/baked_file.h"
#include "host/formats/asset/baked_verify.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// The meaning of the averaged values.
enum class PyramidKind {
  kColour,       // linear RGB, or three numbers with another meaning
  kReflectance,  // RGB radiance towards the eye, over the normals of a surface (reflectance_mapping.h)
  kHeight,       // heights over a plane
  kPosition,     // x, y, z of a grid of points
};

const char* pyramid_kind_name(PyramidKind kind);

struct PyramidHeader {
  PyramidKind kind = PyramidKind::kColour;
  BakedHeader map;  // sizes, wrap modes, encoding (kHalf, kFloat) and provenance; stores all levels

  int channel_count() const { return kind == PyramidKind::kHeight ? 1 : 3; }
  int level_count() const { return map.level_count(); }
};

/// A level, or some of its rows, in row-major order from the top of the image, with interleaved channels.
struct PyramidLevel {
  int width = 0;
  int height = 0;
  std::vector<float> values;
};

struct Pyramid {
  PyramidHeader header;
  std::vector<PyramidLevel> levels;
};

/// Rounds to values that the encoding stores. Values above the largest half become 65504. Returns the number of values
/// above the largest half.
std::uint64_t quantize_pyramid(std::vector<float>& values, StorageEncoding encoding);

class PyramidWriter {
 public:
  /// Ignores the content hash in `header`, because commit() sets it. Throws like AtomicFile if the path cannot be
  /// written, and throws Error(kUsage) for an unknown compression.
  PyramidWriter(const std::string& path, const PyramidHeader& header, const BakedWriteOptions& options);
  /// Removes the file, unless commit() was called.
  ~PyramidWriter();
  PyramidWriter(const PyramidWriter&) = delete;
  PyramidWriter& operator=(const PyramidWriter&) = delete;

  /// Takes rows that quantize_pyramid() has rounded. The rows of a level come in order from row 0. The levels come in
  /// any order.
  void write_level(int level, int first_row, PyramidLevel rows);
  void commit(Progress* progress);
  /// Returns the checksum of the content. Call commit() first.
  const std::string& content_hash() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

/// Returns whether the header says that the file is a pyramid. Throws Error(kInput) if the file is not an EXR file.
bool is_pyramid_file(const std::string& path);

/// Reads a pyramid of any kind. Throws Error(kInput), which names the file, what was found and what was expected.
/// Rejects texels that are not finite.
Pyramid read_pyramid(const std::string& path);
/// Reads a pyramid. The pyramid must be of this kind.
Pyramid read_pyramid(const std::string& path, PyramidKind expected);
PyramidHeader read_pyramid_header(const std::string& path);

/// Checks the structure, the checksums of pixels and headers, and that values are finite. Also checks that every level
/// has the same mean, because levels are averages of the finest level.
std::vector<VerifyFinding> verify_pyramid(const std::string& path, int threads);

}  // namespace multum
