// SPDX-License-Identifier: Apache-2.0
// Manages windows that slide down over rows stored elsewhere. Each window is a device buffer with some rows of every
// plane. On a map that repeats, rows wrap, so a window may begin above the map's first row or end below its last row.
//
//   stored rows 0 1 2 3 4 5 6 7 8 9 ...
//   window          [2 3 4 5 6]           plane 0: 2 3 4 5 6, plane 1: 2 3 4 5 6, ...
//   moved to            [4 5 6 7 8]       4 5 6 move up in each plane, 7 8 are read
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/bakes/pyramid/row_store.h"
#include "host/formats/image/plane_store.h"
#include "host/formats/opencl/device.h"

namespace multum {

/// Wraps `row` to a level or map of `size` rows. `row` can be outside by a few times `size`.
inline int wrapped_row(int row, int size) { return ((row % size) + size) % size; }

/// Splits rows [first_row, first_row + row_count) into pieces that do not wrap, and calls body(first, count, at) for
/// each. A piece consists of rows [first, first + count) of `size` rows, and begins `at` rows after first_row.
void for_each_piece(int first_row, int row_count, int size,
                    const std::function<void(int first, int count, int at)>& body);

/// Holds `plane_count` planes in one device buffer, each with a fixed number of rows of `row_bytes` bytes.
class RowWindow {
 public:
  RowWindow() = default;
  RowWindow(Device& device, int plane_count, std::size_t row_bytes, int capacity_rows, const std::string& what);

  int first_row() const { return first_row_; }
  int row_count() const { return row_count_; }
  int capacity_rows() const { return capacity_rows_; }
  DeviceBuffer& buffer() { return buffer_; }
  const DeviceBuffer& buffer() const { return buffer_; }

  /// Moves the window and fills rows that were not yet in it. `fill(row, count, planes)` is called for some rows at a
  /// time, and `planes[p]` is the destination of row `row` of plane p. Without `fill`, the contents of these rows are
  /// undefined.
  using Fill = std::function<void(int row, int count, const std::vector<unsigned char*>& planes)>;
  void move_to(int first_row, int row_count, const Fill& fill);
  /// Copies rows [first_row, first_row + count) in the order of the store, in which the planes of each row follow one
  /// another.
  void copy_rows(int first_row, int count, void* rows) const;

 private:
  BufferRange rows_of_plane(int plane, int first, int count) const;
  template <typename Body>
  void for_each_copy(int begin, int end, const Body& body) const;
  void fill_rows(int begin, int end, const Fill& fill);

  Device* device_ = nullptr;
  int plane_count_ = 0;
  std::size_t row_bytes_ = 0;
  int capacity_rows_ = 0, first_row_ = 0, row_count_ = 0;
  DeviceBuffer buffer_;
};

/// Fills windows through `read` from `store_rows` rows of `row_bytes` bytes. Rows wrap. Each row is [plane][column].
using ReadRows = std::function<void(int first_row, int row_count, void* rows)>;
RowWindow::Fill fill_planes(int store_rows, std::size_t row_bytes, ReadRows read);
/// Fills windows from rows of `store`. Rows wrap. Each row is [plane][column]. The store must outlive the result.
RowWindow::Fill fill_planes(const RowStore& store);

/// Holds rows of three planes of a map. Each plane is in its own buffer, with MULTUM_GROUP finite values after the last
/// texel.
class MapWindow {
 public:
  MapWindow(Device& device, const PlaneStore& store, int capacity_rows, const std::string& what);

  int first_row() const { return planes_[0].first_row(); }
  int row_count() const { return planes_[0].row_count(); }
  int capacity_rows() const { return planes_[0].capacity_rows(); }
  const DeviceBuffer& operator[](std::size_t plane) const { return planes_[plane].buffer(); }
  const PlaneStore& store() const { return *store_; }
  void move_to(int first_row, int row_count);

 private:
  const PlaneStore* store_;
  std::vector<RowWindow> planes_;
};

/// The windows that hold the same rows of a map's normals and features.
struct MapWindows {
  MapWindow normals;
  std::vector<MapWindow> rgb_planes;

  MapWindows(Device& device, const PlaneStore& normals, const std::vector<const PlaneStore*>& rgb_planes,
             int capacity_rows);
  void move_to(int first_row, int row_count);
};

/// If the device has its own memory with room for all rows and for the levels' windows, copies all rows to the device
/// once for all levels. Otherwise returns nullopt, and the caller uses windows that hold only some rows.
std::optional<MapWindows> map_on_device(Device& device, const PlaneStore& normals,
                                        const std::vector<const PlaneStore*>& rgb_planes);

}  // namespace multum
