// SPDX-License-Identifier: Apache-2.0
// Pyramids of plain averages (Williams 1983) in files that any reader of mip-mapped textures takes: one part, tiled,
// every level, linear. docs/reference/file_format.md, "Pyramids", describes them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/formats/asset/baked_file.h"
#include "host/formats/asset/baked_verify.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Kind of the numbers that a pyramid averages.
enum class PyramidKind {
  kColour,       // linear RGB, or three numbers of another meaning
  kReflectance,  // radiance towards the eye, RGB, over the normals of a surface (reflectance_mapping.h)
  kHeight,       // heights over a plane
  kPosition,     // x, y, z of a grid of points
};

const char* pyramid_kind_name(PyramidKind kind);

struct PyramidHeader {
  PyramidKind kind = PyramidKind::kColour;
  BakedHeader map;  // sizes, wrap modes, encoding (kHalf, kFloat) and provenance; all levels are stored

  int channel_count() const { return kind == PyramidKind::kHeight ? 1 : 3; }
  int level_count() const { return map.level_count(); }
};

/// A level, or some of its rows. Row-major, from the image's top, channels interleaved.
struct PyramidLevel {
  int width = 0;
  int height = 0;
  std::vector<float> values;
};

struct Pyramid {
  PyramidHeader header;
  std::vector<PyramidLevel> levels;
};

/// Rounds to what the encoding stores; values beyond the largest half, 65504, become that one. Returns how many did.
std::uint64_t quantize_pyramid(std::vector<float>& values, StorageEncoding encoding);

class PyramidWriter {
 public:
  /// Does not read the content hash of `header`: commit() knows it. Throws as AtomicFile does for places that cannot be
  /// written, Error(kUsage) for an unknown compression.
  PyramidWriter(const std::string& path, const PyramidHeader& header, const BakedWriteOptions& options);
  /// Removes the file, unless commit() was called.
  ~PyramidWriter();
  PyramidWriter(const PyramidWriter&) = delete;
  PyramidWriter& operator=(const PyramidWriter&) = delete;

  /// Rounded rows (quantize_pyramid), in order from row 0 within the level; levels in any order.
  void write_level(int level, int first_row, PyramidLevel rows);
  void commit(Progress* progress);
  /// The content's checksum; after commit().
  const std::string& content_hash() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

/// True when the file's header says that it is a pyramid. Throws Error(kInput) where there is no EXR file.
bool is_pyramid_file(const std::string& path);

/// Throws Error(kInput) naming the file, what was found and what was expected; also for texels that are not finite.
Pyramid read_pyramid(const std::string& path);
/// Reads a pyramid that must be of one kind.
Pyramid read_pyramid(const std::string& path, PyramidKind expected);
PyramidHeader read_pyramid_header(const std::string& path);

/// Structure, checksums of pixels and headers, finite values, and that every level has the same mean (levels are
/// averages of the finest).
std::vector<VerifyFinding> verify_pyramid(const std::string& path, int threads);

}  // namespace multum
