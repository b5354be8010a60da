// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/pyramid/row_window.h"

#include <algorithm>
#include <cstring>

#include "host/formats/opencl/launch_shape.h"
#include "host/foundation/base/error.h"
#include "kernels/shared/movmf_fit.h"

namespace multum {

void for_each_piece(int first_row, int row_count, int size,
                    const std::function<void(int first, int count, int at)>& body) {
  for (int at = 0; at < row_count;) {
    const int first = wrapped_row(first_row + at, size);
    const int count = std::min(row_count - at, size - first);
    body(first, count, at);
    at += count;
  }
}

RowWindow::RowWindow(Device& device, int plane_count, std::size_t row_bytes, int capacity_rows, const std::string& what)
    : device_(&device),
      plane_count_(plane_count),
      row_bytes_(row_bytes),
      capacity_rows_(capacity_rows),
      buffer_(device.make_buffer(
          static_cast<std::size_t>(plane_count) * static_cast<std::size_t>(capacity_rows) * row_bytes +
              MULTUM_GROUP * sizeof(float),
          what)) {
  device.fill_zero(buffer_);
}

void RowWindow::move_to(int first_row, int row_count, const Fill& fill) {
  MULTUM_CHECK(row_count <= capacity_rows_);
  // Rows [kept_begin, kept_end) are in the window both before and after the move.
  const int kept_begin = std::max(first_row, first_row_),
            kept_end = std::max(kept_begin, std::min(first_row + row_count, first_row_ + row_count_));
  MULTUM_CHECK(row_count_ == 0 || first_row >= first_row_ || kept_end == kept_begin);  // windows can only slide down
  if (first_row == first_row_ && kept_end == first_row + row_count) {
    row_count_ = row_count;
    return;
  }
  if (kept_end > kept_begin && first_row != first_row_) {
    std::vector<BufferMove> moves;
    for (int p = 0; p < plane_count_; ++p)
      moves.push_back({rows_of_plane(p, kept_begin - first_row_, kept_end - kept_begin),
                       rows_of_plane(p, kept_begin - first_row, 0).begin});
    device_->move_down(moves);
  }
  first_row_ = first_row;
  row_count_ = row_count;
  if (!fill) return;
  if (kept_end == kept_begin) {
    fill_rows(first_row, first_row + row_count, fill);
  } else {
    fill_rows(first_row, kept_begin, fill);
    fill_rows(kept_end, first_row + row_count, fill);
  }
}

BufferRange RowWindow::rows_of_plane(int plane, int first, int count) const {
  const auto before = static_cast<std::size_t>(plane) * static_cast<std::size_t>(capacity_rows_);
  return {&buffer_, (before + static_cast<std::size_t>(first)) * row_bytes_,
          static_cast<std::size_t>(count) * row_bytes_};
}

// Splits rows [begin, end) of the window's level into pieces that one copy per plane can handle.
template <typename Body>
void RowWindow::for_each_copy(int begin, int end, const Body& body) const {
  const std::size_t most = device_->shape().staging_bytes, row = static_cast<std::size_t>(plane_count_) * row_bytes_;
  const int rows = most == 0 || row == 0 ? std::max(1, end - begin)
                                         : static_cast<int>(std::clamp<std::size_t>(most / row, 1, 1u << 20));
  for (int first = begin; first < end; first += rows) {
    const int count = std::min(rows, end - first);
    std::vector<BufferRange> ranges;
    for (int p = 0; p < plane_count_; ++p) ranges.push_back(rows_of_plane(p, first - first_row_, count));
    body(first, count, ranges);
  }
}

void RowWindow::fill_rows(int begin, int end, const Fill& fill) {
  for_each_copy(begin, end, [&](int first, int count, const std::vector<BufferRange>& ranges) {
    device_->write_ranges(ranges, [&](const Device::Bytes& planes) { fill(first, count, planes); });
  });
}

void RowWindow::copy_rows(int first_row, int count, void* rows) const {
  MULTUM_CHECK(first_row >= first_row_ && first_row + count <= first_row_ + row_count_);
  auto* to = static_cast<unsigned char*>(rows);
  for_each_copy(first_row, first_row + count, [&](int, int copied, const std::vector<BufferRange>& ranges) {
    device_->read_ranges(ranges, [&](const Device::Bytes& planes) {
      for (std::size_t row = 0; row < static_cast<std::size_t>(copied); ++row)
        for (const unsigned char* plane : planes) {
          std::memcpy(to, plane + row * row_bytes_, row_bytes_);
          to += row_bytes_;
        }
    });
  });
}

RowWindow::Fill fill_planes(int store_rows, std::size_t row_bytes, ReadRows read) {
  return
      [store_rows, row_bytes, read = std::move(read)](int row, int count, const std::vector<unsigned char*>& planes) {
        const std::size_t plane_bytes = row_bytes / planes.size();
        std::vector<unsigned char> rows;
        for_each_piece(row, count, store_rows, [&](int first, int piece, int at) {
          const std::size_t to = static_cast<std::size_t>(at) * plane_bytes;
          if (planes.size() == 1) {
            read(first, piece, planes[0] + to);
            return;
          }
          rows.resize(static_cast<std::size_t>(piece) * row_bytes);
          read(first, piece, rows.data());
          for (std::size_t r = 0; r < static_cast<std::size_t>(piece); ++r)
            for (std::size_t p = 0; p < planes.size(); ++p)
              std::memcpy(planes[p] + to + r * plane_bytes, rows.data() + (r * planes.size() + p) * plane_bytes,
                          plane_bytes);
        });
      };
}

RowWindow::Fill fill_planes(const RowStore& store) {
  return fill_planes(store.row_count(), store.row_bytes(),
                     [&store](int first, int count, void* rows) { store.read(first, count, rows); });
}

MapWindow::MapWindow(Device& device, const PlaneStore& store, int capacity_rows, const std::string& what)
    : store_(&store) {
  for (int p = 0; p < 3; ++p)
    planes_.emplace_back(device, 1, static_cast<std::size_t>(store.width()) * sizeof(float), capacity_rows, what);
}

MapWindows::MapWindows(Device& device, const PlaneStore& normals_store, const std::vector<const PlaneStore*>& stores,
                       int capacity_rows)
    : normals(device, normals_store, capacity_rows, "normals") {
  for (const PlaneStore* store : stores) rgb_planes.emplace_back(device, *store, capacity_rows, "features");
}

void MapWindows::move_to(int first_row, int row_count) {
  normals.move_to(first_row, row_count);
  for (MapWindow& rgb_plane : rgb_planes) rgb_plane.move_to(first_row, row_count);
}

std::optional<MapWindows> map_on_device(Device& device, const PlaneStore& normals,
                                        const std::vector<const PlaneStore*>& rgb_planes) {
  const std::uint64_t texels =
      static_cast<std::uint64_t>(normals.width()) * static_cast<std::uint64_t>(normals.height());
  const std::uint64_t bytes = texels * 3 * sizeof(float) * (1 + rgb_planes.size());
  // window_bytes_useful is 0 on a CPU, so maps stay in host memory.
  if (bytes > device.shape().window_bytes_useful / 2) return std::nullopt;
  MapWindows map(device, normals, rgb_planes, normals.height());
  map.move_to(0, normals.height());
  return map;
}

void MapWindow::move_to(int first_row, int row_count) {
  const auto width = static_cast<std::size_t>(store_->width());
  for (int p = 0; p < 3; ++p)
    planes_[static_cast<std::size_t>(p)].move_to(
        first_row, row_count, [&](int row, int count, const std::vector<unsigned char*>& to) {
          for_each_piece(row, count, store_->height(), [&](int first, int piece, int at) {
            store_->read_rows(p, first, piece, reinterpret_cast<float*>(to[0]) + static_cast<std::size_t>(at) * width);
          });
        });
}

}  // namespace multum
