// SPDX-License-Identifier: Apache-2.0
// Threads take bands from a shared counter. A slow band therefore delays no other thread. Results do not depend on
// which thread takes a band.
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/messages/log_listener.h"
#include "host/foundation/base/processes/machine.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace multum {

void for_each_row_band(int row_count, int rows_per_band, int threads,
                       const std::function<void(int band, int row_begin, int row_end)>& body) {
  const int band_count = row_band_count(row_count, rows_per_band);
  if (threads <= 0) threads = processor_count();
  threads = std::min(threads, band_count);
  std::atomic<int> next_band{0};
  std::mutex failure_mutex;
  std::exception_ptr failure;
  const auto work = [&] {
    for (int band = next_band++; band < band_count; band = next_band++) {
      try {
        const int row_begin = band * rows_per_band;
        body(band, row_begin, std::min(row_count, row_begin + rows_per_band));
      } catch (...) {
        const std::lock_guard<std::mutex> lock(failure_mutex);
        if (!failure) failure = std::current_exception();
        next_band = band_count;
      }
    }
  };
  std::vector<std::jthread> others;
  for (int i = 1; i < threads; ++i) others.emplace_back(with_own_log([&work] { work(); }));
  work();
  others.clear();  // joins the threads
  if (failure) std::rethrow_exception(failure);
}

void for_each_row_band(int row_count, int rows_per_band, int threads, Progress* progress,
                       const std::function<void(int band, int row_begin, int row_end)>& body) {
  constexpr int kBandsBetween = 64;  // there are so many bands that threads seldom wait for the last band of another
                                     // thread
  const int band_count = row_band_count(row_count, rows_per_band);
  for (int first = 0; first < band_count; first += kBandsBetween) {
    const int row_first = first * rows_per_band;
    const int rows = std::min(row_count - row_first, kBandsBetween * rows_per_band);
    for_each_row_band(rows, rows_per_band, threads, [&](int band, int row_begin, int row_end) {
      body(first + band, row_first + row_begin, row_first + row_end);
    });
    progress_advance(progress, 0);
  }
}

}  // namespace multum
