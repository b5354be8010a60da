// SPDX-License-Identifier: Apache-2.0
// Makes a folder with a good baked file and damaged copies. Passes rows to a writer in portions.
#pragma once

#include <ImfChannelList.h>
#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfTiledInputPart.h>
#include <ImfTiledOutputPart.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {

class AlteredFile {
 public:
  /// Replaces every `from` in the bytes of the good file by `to`, which has the same length. Returns the bad file's
  /// path.
  std::string replaced(const std::string& from, const std::string& to) const {
    std::string bytes = read_bytes(good);
    EXPECT_EQ(from.size(), to.size());
    std::size_t count = 0;
    for (std::size_t at = bytes.find(from); at != std::string::npos; at = bytes.find(from, at + 1), ++count)
      bytes.replace(at, to.size(), to);
    EXPECT_GT(count, 0u) << from;
    write_bytes(bad, bytes);
    return bad;
  }

  /// Writes the good file again with changed headers and with the parts that `order` selects. Parts keep their pixels
  /// if their channels do not change. Returns the bad file's path.
  std::string rebuilt(const std::vector<int>& order, const std::function<void(Imf::Header&)>& change) const {
    Imf::MultiPartInputFile in(good.c_str());
    std::vector<Imf::Header> headers;
    for (const int part : order) {
      headers.push_back(in.header(part));
      change(headers.back());
    }
    Imf::MultiPartOutputFile out(bad.c_str(), headers.data(), static_cast<int>(headers.size()));
    for (std::size_t i = 0; i < order.size(); ++i) {
      Imf::TiledInputPart from(in, order[i]);
      Imf::TiledOutputPart to(out, static_cast<int>(i));
      if (headers[i].channels() == in.header(order[i]).channels()) to.copyPixels(from);
    }
    return bad;
  }

  const TemporaryFolder folder;
  const std::string good = folder / "good.exr", bad = folder / "bad.exr";
};

/// Passes a mipmap to a writer in portions of 0 to 49 rows, which do not match the rows of tiles. The levels alternate.
/// `rows_of(level, row, count)` returns rows of a level.
template <typename Writer, typename Mipmap, typename RowsOf>
void write_in_portions(Writer& writer, const Mipmap& mipmap, const RowsOf& rows_of) {
  std::mt19937 random(1);
  std::vector<int> next(mipmap.levels.size(), 0);
  for (bool more = true; more;) {
    more = false;
    for (int l = mipmap.header.first_level; l < mipmap.header.level_count(); ++l) {
      const auto& level = mipmap.levels[static_cast<std::size_t>(l)];
      int& row = next[static_cast<std::size_t>(l)];
      const int rows = std::min(level.height - row, static_cast<int>(random() % 50));
      writer.write_level(l, row, rows_of(level, row, rows));
      row += rows;
      more = more || row < level.height;
    }
  }
}

}  // namespace multum::testing
