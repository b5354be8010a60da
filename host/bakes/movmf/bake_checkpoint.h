// SPDX-License-Identifier: Apache-2.0
// Keeps the rows of lobes that a bake has done in a hidden folder beside the output, from which a bake that was killed
// is resumed.
//
//   .multum-partial-NAME/
//     progress          what bake it is, then a line for each block of rows: level, first row, rows, CRC-64
//     level-5.lobes     rows [lobe][column], which finer levels grow from; level-5.features with features;
//                       level-5.refined, what the file stores of a level that is refined
//
// A block counts when its line is whole and its bytes have that checksum: a machine that lost power loses blocks, not
// trust.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "host/bakes/pyramid/row_store.h"
#include "host/foundation/base/files/journal_file.h"
#include "host/foundation/base/files/work_folder.h"

namespace multum {

class BakeCheckpoint {
 public:
  /// Opens the folder of the bake of `output`; `key` stands for the sources and settings: everything that its rows
  /// depend on. What is there of the same bake is kept when `resume`, anything else is removed. Null while another
  /// process bakes the same output: the folder is its own. Throws Error(kEnvironment).
  static std::unique_ptr<BakeCheckpoint> open(const std::string& output, const std::string& key, bool resume);
  BakeCheckpoint(const BakeCheckpoint&) = delete;
  BakeCheckpoint& operator=(const BakeCheckpoint&) = delete;

  /// Stores of a level's rows; made on the first call, sizes must be those of the bake that was killed.
  struct Level {
    RowStore lobes;
    std::optional<RowStore> features, refined;
    int rows_done = 0;  // from row 0

    /// What the file stores.
    const RowStore& stored() const { return refined ? *refined : lobes; }
  };
  struct RowBytes {
    std::size_t lobes = 0, features = 0;  // features: 0: none
    bool is_refined = false;
  };
  Level& open_level(int level, int row_count, const RowBytes& row_bytes);
  struct Rows {
    const void* lobes = nullptr;
    const void* features = nullptr;  // null: none
    const void* refined = nullptr;   // of a level that is refined
  };
  /// Writes rows [level.rows_done, + row_count) to the level's stores and makes a note of them.
  void add_rows(int level, int row_count, const Rows& rows);

  /// The folder stays when this is destroyed: the bake was stopped and may go on.
  void leave() { folder_->leave(); }
  /// Rows of texels that an earlier bake left.
  std::uint64_t rows_resumed() const { return rows_resumed_; }

 private:
  struct Block {
    int first_row, row_count;
    std::string checksum;
  };
  BakeCheckpoint(std::unique_ptr<WorkFolder> folder, const std::string& key, bool resume);
  /// Bytes of the file `progress` that count; 0 when it is of another bake.
  std::uint64_t read_progress(const std::string& key);
  static std::string block_checksum(const Level& level, int first_row, int row_count);

  std::unique_ptr<WorkFolder> folder_;  // removed at the end, unless left
  JournalFile progress_;
  std::map<int, std::vector<Block>> found_;  // by level, in order
  std::map<int, Level> levels_;
  std::uint64_t rows_resumed_ = 0;
};

}  // namespace multum
