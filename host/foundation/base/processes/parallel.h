// SPDX-License-Identifier: Apache-2.0
// Divides work among threads, in bands of an image's rows or in numbered items. A result must depend only on the rows
// or on the number of its item. The caller combines results in order, so every thread count gives the same bytes.
#pragma once

#include <functional>

#include "host/foundation/base/progress.h"

namespace multum {

/// Calls `body(band, row_begin, row_end)` once for each band of `rows_per_band` rows. The last band may be shorter.
/// Uses at most `threads` threads, or one per processor of the machine if `threads` <= 0. Rethrows the first exception
/// after all threads have ended.
void for_each_row_band(int row_count, int rows_per_band, int threads,
                       const std::function<void(int band, int row_begin, int row_end)>& body);

/// Like the function above, but `progress` may cancel the work after every few bands.
void for_each_row_band(int row_count, int rows_per_band, int threads, Progress* progress,
                       const std::function<void(int band, int row_begin, int row_end)>& body);

/// Calls `body(item)` once for each item from 0 to `item_count` - 1. Uses threads like for_each_row_band().
template <typename Body>
void for_each_item(int item_count, int threads, const Body& body) {
  for_each_row_band(item_count, 1, threads, [&](int item, int, int) { body(item); });
}

inline int row_band_count(int row_count, int rows_per_band) { return (row_count + rows_per_band - 1) / rows_per_band; }

/// Returns the number of rows per band if all texels need the same work. Bands are small enough to distribute, but
/// large enough to justify the cost of starting each of them.
constexpr int kRowsPerBand = 16;

}  // namespace multum
