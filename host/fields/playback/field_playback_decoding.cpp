// SPDX-License-Identifier: Apache-2.0
// Requests the missing images of a frame, the coarsest first, and decodes them in worker threads.
#include <algorithm>
#include <utility>

#include "host/fields/playback/field_playback.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {

// ---- requests

void FieldPlayback::request() {
  const Lock lock(mutex_);
  bool has_room = ask(0, now_);
  for (std::size_t d = 0; d < ahead_.size() && has_room; ++d) has_room = ask(d + 1, ahead_[d]);
  const auto urgency = [&](const Job& job) {
    const Rank& rank = job.image ? images_.at({job.chunk, *job.image}).rank : chunks_[job.chunk]->rank;
    return std::pair(rank.distance, job.order);
  };
  std::stable_sort(jobs_.begin(), jobs_.end(), [&](const Job& a, const Job& b) { return urgency(a) < urgency(b); });
  if (!jobs_.empty()) has_job_.notify_all();
}

/// Requests coarse parts first: coefficients, sums, the first images of all layers, then the second images. Returns
/// false if there is not enough memory to request one of these parts.
bool FieldPlayback::ask(std::size_t distance, const std::vector<SampleShare>& shares) {
  std::vector<Wanted> wanted;
  std::vector<std::size_t> chunks;
  bool has_room = true;
  if (distance == 0)
    for (const auto& chunk : chunks_) chunk->is_pending = false;
  for (std::size_t l = 0; l < chunk_of_.size(); ++l) {
    for (const SampleShare& share : shares) {
      const auto place = place_of(l, share.sample);
      if (place && chunks_[place->chunk]->state == ChunkState::kUnread) read_head(*chunks_[place->chunk], distance);
    }
    for (const SampleShare& share : mixed(l, shares)) {
      const Place place = *place_of(l, share.sample);
      Chunk& chunk = *chunks_[place.chunk];
      has_room = has_room && chunk.plan;
      if (!chunk.plan) continue;
      const bool is_missing = ask_terms(place, distance, wanted) > 0 || chunk.zeros.empty();
      if (is_missing) chunks.push_back(place.chunk);
      chunk.is_pending = chunk.is_pending || (is_missing && distance == 0);
    }
  }
  std::sort(wanted.begin(), wanted.end());
  const auto may_ask = [&] { return has_room || distance == 0; };
  for (const std::size_t chunk : chunks) has_room = may_ask() && ask_chunk(chunk, distance) && has_room;
  for (const Wanted& one : wanted) has_room = may_ask() && ask_image(one, distance) && has_room;
  return has_room;
}

/// Adds those images of a sample that are not yet requested to `wanted`. Returns how many of the sample's images are
/// missing.
std::size_t FieldPlayback::ask_terms(const Place& place, std::size_t distance, std::vector<Wanted>& wanted) const {
  const Chunk& chunk = *chunks_[place.chunk];
  const bool has_sum = images_.count(sum_of(place)) > 0;
  if (is_textures()) {
    if (!has_sum) wanted.push_back({1, sum_of(place)});
    return has_sum ? 0 : 1;
  }
  std::size_t order = 2, late = 0, missing = 0;
  for (const auto& term : chunk.plan->of_samples[place.sample]) {
    const ImageKey key{place.chunk, term.image};
    if (!chunk.is_zero(term.image) && images_.count(key) == 0) {
      wanted.push_back({order, key});
      ++missing;
    }
    late += chunk.is_zero(term.image) || has(key) ? 0 : 1;
    ++order;
  }
  const bool is_summed = settings_.kind == DecodedKind::kImagesAndSums && distance == 0 && late > 1;
  if (is_summed && !has_sum) wanted.push_back({1, sum_of(place)});
  return missing;
}

bool FieldPlayback::ask_chunk(std::size_t number, std::size_t distance) {
  Chunk& chunk = *chunks_[number];
  if (chunk.rank.frame != frame_) chunk.rank = {frame_, distance};  // the head was read just now
  if (chunk.state != ChunkState::kRead) return true;
  const std::size_t bytes = chunk_work_bytes(chunk);
  if (!make_room(bytes, distance)) return false;
  MULTUM_CHECK(memory_.take(bytes));
  chunk.state = ChunkState::kQueued;
  chunk.cancelled = false;
  jobs_.push_back({number, std::nullopt, 0});
  return true;
}

bool FieldPlayback::ask_image(const Wanted& wanted, std::size_t distance) {
  const ImageKey key = wanted.key;
  Chunk& chunk = *chunks_[key.chunk];
  if (chunk.decoded == nullptr || images_.count(key) > 0) return true;
  const std::size_t kept = 2 * image_bytes(*chunk.format, settings_.kind);  // twice, because of the uploaded copy
  const std::size_t work = image_work_bytes(*chunk.format, settings_.kind);
  ++chunk.images_at_work;  // so that its coefficients are kept
  const bool has_room = make_room(kept + work, distance);
  if (!has_room) {
    --chunk.images_at_work;
    return false;
  }
  MULTUM_CHECK(memory_.take(kept + work));
  Image& image = images_[key];
  image.bytes = kept;
  image.work_bytes = work;
  image.rank = {frame_, distance};
  jobs_.push_back({key.chunk, key.image, wanted.order});
  return true;
}

// ---- workers

bool FieldPlayback::wait() {
  Lock lock(mutex_);
  has_news_.wait(lock, [&] { return has_finished_ || (at_work_ == 0 && jobs_.empty()); });
  const bool had_finished = has_finished_;
  has_finished_ = false;
  return had_finished;
}

void FieldPlayback::work() {
  Lock lock(mutex_);
  while (true) {
    has_job_.wait(lock, [&] { return is_ending_ || !jobs_.empty(); });
    if (is_ending_) return;
    const Job job = jobs_.front();
    jobs_.pop_front();
    ++at_work_;
    if (job.image) decode_image(lock, {job.chunk, *job.image});
    else decode_chunk(lock, *chunks_[job.chunk]);
    --at_work_;
    has_finished_ = true;
    has_news_.notify_all();
  }
}

void FieldPlayback::decode_chunk(Lock& lock, Chunk& chunk) {
  chunk.state = ChunkState::kDecoding;
  const std::size_t taken = chunk_work_bytes(chunk);
  bool ran_out = false;
  const DecodingLimits limits{chunk.limit, &chunk.cancelled, &ran_out};
  std::shared_ptr<const TextureChunk> decoded;
  std::vector<bool> zeros;
  std::string problem;
  lock.unlock();
  const ThreadStopwatch stopwatch;
  try {
    std::vector<std::uint8_t> bytes;
    {
      const Lock file_lock(file_mutex_);
      bytes = file_.section(chunk.section);
    }
    decoded = file_.decode_chunk(chunk.section, bytes, limits);
    for (std::size_t i = 0; i < decoded->plan().image_count(); ++i) zeros.push_back(decoded->is_zero(i));
  } catch (const std::exception& error) {  // also thrown if memory runs out
    problem = error.what();
    decoded.reset();
  }
  lock.lock();
  counts_.chunk_seconds += stopwatch.seconds();
  memory_.give_back(taken);
  chunk.state = ChunkState::kRead;
  if (decoded != nullptr) {
    chunk.coefficient_bytes = chunk.head_bytes + decoded->memory_bytes();
    MULTUM_CHECK(memory_.take(chunk.coefficient_bytes));  // cannot fail, because the request had taken more bytes
    chunk.decoded = std::move(decoded);
    chunk.zeros = std::move(zeros);
    chunk.state = ChunkState::kDecoded;
    ++counts_.chunks_decoded;
  } else if (ran_out) {
    const std::size_t most = memory_.bytes_max() / kChunkShare;
    if (chunk.limit < most) chunk.limit = std::min(2 * chunk.limit, most);
    else leave_out(chunk, "coefficients");
  } else if (chunk.cancelled) {
    ++counts_.cancelled;
  } else {
    damage(chunk, problem);
  }
}

void FieldPlayback::decode_image(Lock& lock, ImageKey key) {
  Chunk& chunk = *chunks_[key.chunk];
  Image& image = images_.at(key);
  const std::shared_ptr<const TextureChunk> coefficients = chunk.decoded;
  DecodedImage decoded;
  std::string problem;
  lock.unlock();
  const ThreadStopwatch stopwatch;
  try {
    if (coefficients == nullptr) throw Error(ErrorCode::kEnvironment, "its coefficients were discarded");
    decoded = decoded_image(*coefficients, key.image, settings_.kind);
  } catch (const std::exception& error) {  // no memory
    problem = error.what();
  }
  lock.lock();
  counts_.image_seconds += stopwatch.seconds();
  memory_.give_back(image.work_bytes);
  --chunk.images_at_work;
  if (problem.empty()) {
    image.decoded = std::move(decoded);
    image.state = ImageState::kDecoded;
    ++counts_.images_decoded;
    return;
  }
  memory_.give_back(image.bytes);
  images_.erase(key);
  if (chunk.state != ChunkState::kDamaged) damage(chunk, file_.section_name(chunk.section) + ": " + problem);
}

}  // namespace multum
