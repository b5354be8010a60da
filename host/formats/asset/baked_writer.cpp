// SPDX-License-Identifier: Apache-2.0
// Rows wait in a queue for the writer's thread. The thread holds one unfinished row of tiles per part and level:
//
//     rows of any count --> queue (16 MiB) --> row of tiles per part and level --> SHA-256, halfs, OpenEXR's writeTiles
//
// writeTiles distributes the tiles among OpenEXR's own threads. The file stores tiles in the order of these calls
// (RANDOM_Y). Readers find tiles through the tables that OpenEXR writes last.
#include "host/formats/asset/baked_writer.h"

#include <ImfMultiPartOutputFile.h>
#include <ImfThreading.h>
#include <ImfTiledOutputPart.h>
#include <fmt/format.h>
#include <half.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <mutex>
#include <thread>

#include "host/formats/asset/exr/exr_output.h"
#include "host/formats/asset/exr/exr_rows.h"
#include "host/formats/asset/exr/zlib_compress.h"
#include "host/formats/asset/header_hash.h"
#include "host/formats/asset/row_checksums.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/messages/log_listener.h"

namespace multum {
namespace {

constexpr std::size_t kQueueBytesMax = std::size_t{16} << 20;

using Portion = std::unique_ptr<const BakedRows>;

// First-in-first-out queue for one producer and one consumer.
class PortionQueue {
 public:
  /// Waits until there is room. An empty queue accepts a portion of any size.
  void put(Portion portion) {
    const std::size_t bytes = portion->bytes();
    std::unique_lock<std::mutex> lock(mutex_);
    room_.wait(lock, [&] { return portions_.empty() || bytes_ + bytes <= kQueueBytesMax; });
    portions_.push_back(std::move(portion));
    bytes_ += bytes;
    filled_.notify_one();
  }
  /// Waits for the next portion. Returns false if no more portions will come.
  bool take(Portion& portion) {
    std::unique_lock<std::mutex> lock(mutex_);
    filled_.wait(lock, [&] { return !portions_.empty() || closed_; });
    if (portions_.empty()) return false;
    portion = std::move(portions_.front());
    portions_.pop_front();
    bytes_ -= portion->bytes();
    room_.notify_one();
    return true;
  }
  void close(bool discard) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (discard) portions_.clear();
    closed_ = true;
    filled_.notify_one();
  }

 private:
  std::mutex mutex_;
  std::condition_variable room_, filled_;
  std::deque<Portion> portions_;
  std::size_t bytes_ = 0;
  bool closed_ = false;
};

// One level of one part, with its unfinished row of tiles and the digest of the earlier rows.
struct PartLevel {
  const BakedPart* part;
  int part_index;
  std::vector<float> values;
  ContentHash hash;
};

struct Level {
  int width, height;
  int rows_accepted = 0;  // rows counted by the caller's thread
  int rows_written = 0;   // rows counted by the writer's thread, like rows_waiting
  int rows_waiting = 0;   // number of rows in PartLevel::values
  std::vector<std::unique_ptr<PartLevel>> parts;
};

}  // namespace

class BakedWriter::Work {
 public:
  Work(const std::string& path, const BakedHeader& header, std::vector<BakedPart> parts,
       const std::vector<Imf::Header>& headers, const BakedWriteOptions& options)
      : file_(path), options_(options), parts_(std::move(parts)), row_checksums_(header, parts_, options.tile_size) {
    MULTUM_CHECK(header.first_level >= 0 && header.first_level < header.level_count());
    MULTUM_CHECK(replaces_zlib_compress());
    MULTUM_CHECK(options.tile_size >= 1 && options.threads >= 1 && options.measured_error_bytes >= 0);
    for (int l = 0; l < header.level_count(); ++l)
      levels_.push_back({mip_level_size(header.width, l), mip_level_size(header.height, l), 0, 0, 0, {}});
    for (std::size_t i = 0; i < parts_.size(); ++i)
      for (int l = 0; l < parts_[i].level_count; ++l)
        levels_[static_cast<std::size_t>(parts_[i].first_level + l)].parts.push_back(
            std::unique_ptr<PartLevel>(new PartLevel{&parts_[i], static_cast<int>(i), {}, {}}));
    stream_ = std::make_unique<ExrOutputStream>(file_);
    guarded([&] {
      use_exr_threads(options.threads);
      out_ = std::make_unique<Imf::MultiPartOutputFile>(*stream_, headers.data(), static_cast<int>(headers.size()),
                                                        false, options.threads);
    });
    thread_ = std::jthread(with_own_log([this] { run(); }));
  }

  ~Work() { stop(true); }

  void accept(int first_row, Portion portion) {
    rethrow_failure();
    MULTUM_CHECK(portion->level() >= 0 && portion->level() < static_cast<int>(levels_.size()));
    Level& level = levels_[static_cast<std::size_t>(portion->level())];
    MULTUM_CHECK(!level.parts.empty());  // the level must be stored
    MULTUM_CHECK(first_row == level.rows_accepted && first_row + portion->height() <= level.height);
    portion->check_sizes(level.width);
    level.rows_accepted += portion->height();
    queue_.put(std::move(portion));
  }

  void commit(const std::string& measured_error, const std::function<std::vector<VerifyFinding>()>& findings,
              Progress* progress) {
    rethrow_failure();
    for (const Level& level : levels_) MULTUM_CHECK(level.parts.empty() || level.rows_accepted == level.height);
    MULTUM_CHECK(measured_error.size() <= static_cast<std::size_t>(options_.measured_error_bytes));
    queue_.close(false);
    wait(progress);
    stop(false);
    rethrow_failure();
    check(findings());
    guarded([&] { out_.reset(); });  // writes the tables of tiles
    stream_->close();
    content_hash_ = hash_all();
    const int with_error = fill_in_attribute(file_, kMeasuredErrorAttribute, measured_error);
    const int with_hash = fill_in_attribute(file_, kContentHashAttribute, content_hash_);
    const int with_rows = fill_in_attribute(file_, kRowChecksumsAttribute, row_checksums_.text());
    // The header checksum comes last, because it covers all other attributes in their stored form.
    const int with_header = fill_in_attribute(file_, kHeaderHashAttribute, header_hash_text(file_.open_path()));
    MULTUM_CHECK(with_error == 1 && with_hash == static_cast<int>(parts_.size()) && with_rows == 1 && with_header == 1);
    progress_advance(progress, 0);  // the last chance to cancel
    file_.commit();
  }

  const std::string& content_hash() const { return content_hash_; }

 private:
  // Converts exceptions of OpenEXR to Error.
  template <typename Body>
  void guarded(const Body& body) const {
    try {
      body();
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      throw Error(ErrorCode::kEnvironment, file_.path() + ": writing failed: " + error.what());
    }
  }

  // Throws if a reader would reject the file. Such a file must not be published.
  void check(const std::vector<VerifyFinding>& findings) const {
    for (const VerifyFinding& finding : findings)
      if (!finding.passed && options_.is_checked)
        throw Error(ErrorCode::kEnvironment,
                    fmt::format("{}: was not written, because it would fail verification: {}: {}", file_.path(),
                                finding.check, finding.detail));
  }

  void run() {
    Portion portion;
    while (queue_.take(portion)) {
      if (has_failed()) continue;  // otherwise the caller would wait for room forever
      try {
        guarded([&] { gather(*portion); });
        portion.reset();
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex_);
        failure_ = std::current_exception();
      }
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    finished_ = true;
    finished_changed_.notify_one();
  }

  // Adds the rows of the portion to the waiting rows, and writes every complete row of tiles.
  void gather(const BakedRows& portion) {
    Level& level = levels_[static_cast<std::size_t>(portion.level())];
    portion.scan(level.rows_written + level.rows_waiting);
    for (int row = 0; row < portion.height();) {
      const int tile_rows = std::min(options_.tile_size, level.height - level.rows_written);
      const int rows = std::min(portion.height() - row, tile_rows - level.rows_waiting);
      for (const auto& at : level.parts) {
        const std::size_t channels = at->part->channels.size();
        at->values.resize(texel_count(level.width, tile_rows) * channels);
        portion.copy_values(static_cast<std::size_t>(at->part_index), texel_count(level.width, row),
                            texel_count(level.width, rows),
                            at->values.data() + texel_count(level.width, level.rows_waiting) * channels);
      }
      row += rows;
      level.rows_waiting += rows;
      if (level.rows_waiting == tile_rows) write_tiles(portion.level(), level);
    }
  }

  void write_tiles(int level_number, Level& level) {
    for (const auto& at : level.parts) {
      const int l = level_number - at->part->first_level, tile_row = level.rows_written / options_.tile_size;
      Imf::TiledOutputPart part(*out_, at->part_index);
      part.setFrameBuffer(slices(*at, level));
      at->hash.update(at->values.data(), at->values.size() * sizeof(float));
      row_checksums_.set(static_cast<std::size_t>(at->part_index), level_number, tile_row, at->values.data(),
                         at->values.size());
      part.writeTiles(0, part.numXTiles(l) - 1, tile_row, tile_row, l);
    }
    level.rows_written += level.rows_waiting;
    level.rows_waiting = 0;
    if (level.rows_written < level.height) return;
    for (const auto& at : level.parts) at->values = std::vector<float>();
  }

  // Describes the channels to OpenEXR. 32-bit floats are read directly from memory. 16-bit floats are read through
  // `halfs_`, one channel at a time. The values are rounded first, so the checksum covers exactly the stored values.
  Imf::FrameBuffer slices(PartLevel& at, const Level& level) {
    Imf::FrameBuffer buffer;
    const std::size_t channels = at.part->channels.size(), texels = at.values.size() / channels;
    halfs_.resize(texels * channels);
    for (std::size_t c = 0; c < channels; ++c) {
      const BakedChannel& channel = at.part->channels[c];
      const void* first = &at.values[c];
      std::size_t stride = channels * sizeof(float);
      if (channel.type == Imf::HALF) {
        half* const converted = halfs_.data() + c * texels;
        for (std::size_t i = 0; i < texels; ++i) {
          float& value = at.values[i * channels + c];
          converted[i] = half(value);
          value = converted[i];
        }
        first = converted;
        stride = sizeof(half);
      }
      buffer.insert(channel.name,
                    row_slice(channel.type, first, stride, level.width, level.rows_written, level.rows_waiting));
    }
    return buffer;
  }

  std::string hash_all() {
    ContentHash all;
    for (std::size_t i = 0; i < parts_.size(); ++i)
      for (const Level& level : levels_)
        for (const auto& at : level.parts)
          if (at->part_index == static_cast<int>(i)) all.update(at->hash.finish());
    return all.finish();
  }

  bool has_failed() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return failure_ != nullptr;
  }
  void rethrow_failure() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
  }

  // Waits for the thread. Cancels the work if the caller asked for it.
  void wait(Progress* progress) {
    constexpr std::chrono::milliseconds kListenInterval(50);
    std::unique_lock<std::mutex> lock(mutex_);
    while (!finished_changed_.wait_for(lock, kListenInterval, [&] { return finished_; })) {
      lock.unlock();
      progress_advance(progress, 0);
      lock.lock();
    }
  }

  void stop(bool discard) {
    queue_.close(discard);
    if (thread_.joinable()) thread_.join();
  }

  // The order matters: the thread ends first, its output closes next, and the temporary file is removed last.
  AtomicFile file_;
  const BakedWriteOptions options_;
  const std::vector<BakedPart> parts_;
  std::vector<Level> levels_;
  RowChecksums row_checksums_;  // only for the writer's thread, until it ends
  std::vector<half> halfs_;
  std::string content_hash_;
  std::unique_ptr<ExrOutputStream> stream_;
  std::unique_ptr<Imf::MultiPartOutputFile> out_;
  PortionQueue queue_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable finished_changed_;
  bool finished_ = false;
  std::exception_ptr failure_;
  std::jthread thread_;
};

BakedWriter::BakedWriter(const std::string& path, const BakedHeader& header, std::vector<BakedPart> parts,
                         const std::vector<Imf::Header>& headers, const BakedWriteOptions& options)
    : work_(std::make_unique<Work>(path, header, std::move(parts), headers, options)) {}

BakedWriter::~BakedWriter() = default;

void BakedWriter::write(int first_row, std::unique_ptr<const BakedRows> rows) {
  work_->accept(first_row, std::move(rows));
}

void BakedWriter::commit(const std::string& measured_error, const std::function<std::vector<VerifyFinding>()>& findings,
                         Progress* progress) {
  work_->commit(measured_error, findings, progress);
}

const std::string& BakedWriter::content_hash() const { return work_->content_hash(); }

}  // namespace multum
