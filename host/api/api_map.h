// SPDX-License-Identifier: Apache-2.0
// The handle of a baked map in multum.h. It reads levels of a file of any representation, and keeps the levels that
// callers view.
#pragma once

#include <array>
#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "host/api/multum.h"
#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/files/byte_file.h"

namespace multum {

constexpr std::size_t kMapParts = MULTUM_HARMONICS + 1;

/// The values of a level or of some of its rows: [part][layer][row][column][channel]. Empty for parts that the file
/// lacks.
using PartValues = std::array<std::vector<float>, kMapParts>;

/// Reads rows of a file of one representation.
class MapRows {
 public:
  virtual ~MapRows() = default;
  virtual PartValues read(int level, int first_row, int row_count) = 0;
  virtual const BakedHeader& header() const = 0;
  virtual int lobe_count() const { return 0; }
  virtual int sh_order() const { return 0; }
};

/// The numbers of layers and channels of a part. Both are 0 if the file lacks the part.
struct PartShape {
  int layers = 0, channels = 0;
};

}  // namespace multum

struct multum_map {
  /// Opens a file. `folder` owns the WorkFolder that holds the file, or is null. Throws Error(kInput).
  multum_map(std::string path, std::shared_ptr<void> folder);

  const std::string& path() const { return path_; }
  const multum::ByteFile& file() const { return file_; }
  const multum::BakedHeader& header() const { return header_; }
  multum_info info() const;
  multum::PartShape shape(multum_part part) const;
  /// Returns the values of a stored level. Reads them at the first call.
  const multum::PartValues& level(int level);
  /// Reads rows of a level without keeping them.
  multum::PartValues read(int level, int first_row, int row_count);
  void forget();
  const char* text(const std::string& key) const;
  void set_report(std::string report);
  /// Throws Error(kUsage) for a level that is not stored.
  void check_level(int level) const;

 private:
  void add_text(const char* key, const std::string& text) { texts_[key] = text; }
  multum::PartValues checked(multum::PartValues values, int level, int row_count) const;

  std::shared_ptr<void> folder_;
  std::string path_;
  multum::ByteFile file_;  // the file that is open, even if another file takes its name
  std::unique_ptr<multum::MapRows> rows_;
  multum::BakedHeader header_;
  int lobe_count_ = 0, sh_order_ = 0, sh_layers_ = 0;
  std::map<std::string, std::string> texts_;
  std::mutex mutex_;  // guards the reader and the making of levels
  std::vector<std::unique_ptr<multum::PartValues>> made_;
  std::vector<std::atomic<const multum::PartValues*>> levels_;
};

namespace multum {

/// Throws Error(kUsage) if the map does not consist of vMF lobes, which lookups and shading need.
void check_has_lobes(const multum_map& map);

}  // namespace multum
