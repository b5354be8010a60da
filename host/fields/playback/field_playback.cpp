// SPDX-License-Identifier: Apache-2.0
#include "host/fields/playback/field_playback.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/machine.h"

namespace multum {
namespace {

constexpr std::size_t kMemoryLeast = std::size_t{1} << 20;

/// Gives the bytes back at the end of its scope.
class ScopedTake {
 public:
  ScopedTake(MemoryAccount& memory, std::size_t bytes) : memory_(memory), bytes_(bytes) {}
  ~ScopedTake() { memory_.give_back(bytes_); }
  ScopedTake(const ScopedTake&) = delete;
  ScopedTake& operator=(const ScopedTake&) = delete;

 private:
  MemoryAccount& memory_;
  std::size_t bytes_;
};

void check_settings(const PlaybackSettings& settings) {
  const auto refuse = [](const std::string& what) { throw Error(ErrorCode::kUsage, "playback: " + what); };
  if (settings.memory_max < kMemoryLeast)
    refuse(fmt::format("{} bytes of memory, expected at least {}", settings.memory_max, kMemoryLeast));
  if (!(settings.lifetime >= 0.0 && settings.lifetime <= 1e6))
    refuse(fmt::format("a lifetime of {} frames, expected 0 to 1e6", settings.lifetime));
  if (!(settings.lifetime_factor >= 1.0 && settings.lifetime_factor <= 64.0))
    refuse(fmt::format("a lifetime factor of {}, expected 1 to 64", settings.lifetime_factor));
}

/// All samples of a block share one mapping.
FieldPlayback::ImageObject object_of_block(const FieldDescription& description, const PackedLayer& layer,
                                           std::size_t block) {
  const std::vector<int>& mappings = description.field.objects[layer.object].mapping_of_sample;
  for (const std::size_t sample : description.grid.samples_in(layer.blocks[block]))
    if (layer.is_seen(sample)) return {layer.object, static_cast<std::size_t>(mappings[sample])};
  return {layer.object, 0};  // such a chunk is never requested
}

}  // namespace

FieldPlayback::FieldPlayback(const std::string& path, const PlaybackSettings& settings,
                             std::function<void(ImageKey)> forget)
    : settings_(settings), forget_(std::move(forget)), file_(path), memory_(settings.memory_max) {
  check_settings(settings);
  for (std::size_t l = 0; l < description().layers.size(); ++l) {
    chunk_of_.emplace_back();
    for (std::size_t b = 0; b < description().layers[l].blocks.size(); ++b) {
      chunk_of_.back().emplace_back();
      auto chunk = std::make_unique<Chunk>();
      try {
        const auto section = file_.chunk_section(l, b);
        if (!section) continue;
        chunk->section = *section;
      } catch (const Error& missing) {
        damage(*chunk, missing.what());
      }
      chunk_of_.back().back() = chunks_.size();
      chunks_.push_back(std::move(chunk));
      objects_.push_back(object_of_block(description(), description().layers[l], b));
    }
  }
  const int threads = settings.threads > 0 ? settings.threads : processor_count();
  for (int i = 0; i < std::max(threads, 1); ++i) workers_.emplace_back([this] { work(); });
}

FieldPlayback::~FieldPlayback() {
  {
    const Lock lock(mutex_);
    is_ending_ = true;
    for (const auto& chunk : chunks_) chunk->cancelled = true;
  }
  has_job_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void FieldPlayback::reserve(std::size_t bytes) {
  const Lock lock(mutex_);
  if (memory_.take(bytes)) return;
  throw Error(ErrorCode::kEnvironment,
              fmt::format("playback: drawing takes {} bytes, but only {} of {} bytes are left; allow more memory",
                          bytes, memory_.bytes_max() - memory_.bytes(), memory_.bytes_max()));
}

// ---- the images that a point needs

std::optional<FieldPlayback::Place> FieldPlayback::place_of(std::size_t layer, std::size_t sample) const {
  const PackedLayer& described = description().layers[layer];
  if (!described.is_seen(sample)) return {};
  const std::vector<int>& at = description().field.samples[sample].at;
  const std::size_t block = described.block_at(at);
  const auto chunk = chunk_of_[layer][block];
  if (!chunk) return {};
  return Place{*chunk, described.blocks[block].chunk_sample(at)};
}

std::vector<SampleShare> FieldPlayback::mixed(std::size_t layer, const std::vector<SampleShare>& shares) const {
  const std::vector<int>& mappings = description().field.objects[description().layers[layer].object].mapping_of_sample;
  std::vector<SampleShare> same;
  float sum = 0.0f;
  for (const SampleShare& share : shares) {
    const auto place = place_of(layer, share.sample);
    const bool is_usable = place && chunks_[place->chunk]->state != ChunkState::kDamaged &&
                           mappings[share.sample] == mappings[shares.front().sample];
    if (!is_usable && same.empty()) return {};  // the nearest sample decides whether the layer is drawn
    if (!is_usable) continue;
    same.push_back(share);
    sum += share.share;
  }
  for (SampleShare& share : same) share.share /= sum;
  return same;
}

LayerNeed FieldPlayback::need(std::size_t layer) const {
  const Lock lock(mutex_);
  LayerNeed need;
  const auto shares = mixed(layer, now_);
  if (shares.empty()) return need;
  const PackedLayer& described = description().layers[layer];
  need.mapping =
      static_cast<std::size_t>(description().field.objects[described.object].mapping_of_sample[shares.front().sample]);
  need.is_drawn = true;
  need.is_decoded = true;
  std::map<std::pair<std::size_t, ImageKey>, float> weights;  // weights by place in the order of terms
  for (const SampleShare& share : shares) {
    const Place place = *place_of(layer, share.sample);
    const Chunk& chunk = *chunks_[place.chunk];
    need.is_decoded = need.is_decoded && !chunk.zeros.empty();
    if (!chunk.plan) continue;
    if (is_textures()) {
      need.images.push_back({sum_of(place), 1.0f});
      return need;
    }
    for (std::size_t c = 0; c < 3; ++c) need.offset[c] += share.share * chunk.offset[c];
    const auto& terms = chunk.plan->of_samples[place.sample];
    const bool is_whole = std::all_of(terms.begin(), terms.end(), [&](const auto& term) {
      const auto image = images_.find({place.chunk, term.image});
      return chunk.is_zero(term.image) || (image != images_.end() && image->second.state == ImageState::kUploaded);
    });
    if (!is_whole && has(sum_of(place))) {
      weights[{0, sum_of(place)}] += share.share;
      continue;
    }
    std::size_t order = 0;
    for (const auto& term : terms) {
      const ImageKey key{place.chunk, term.image};
      if (!chunk.is_zero(term.image)) weights[{order, key}] += share.share * term.weight;
      ++order;
    }
  }
  for (const auto& [place, weight] : weights) {
    const auto same = std::find_if(need.images.begin(), need.images.end(),
                                   [&, &key = place.second](const NeededImage& image) { return image.key == key; });
    if (same == need.images.end()) need.images.push_back({place.second, weight});
    else same->weight += weight;
  }
  return need;
}

/// Also returns true if the image is already uploaded.
bool FieldPlayback::has(ImageKey key) const {
  const auto found = images_.find(key);
  return found != images_.end() && found->second.state != ImageState::kAwaited;
}

ImageState FieldPlayback::state(ImageKey key) const {
  const Lock lock(mutex_);
  const auto found = images_.find(key);
  return found == images_.end() ? ImageState::kAbsent : found->second.state;
}

const DecodedImage& FieldPlayback::decoded(ImageKey key) const {
  const Lock lock(mutex_);
  const Image& image = images_.at(key);
  MULTUM_CHECK(image.state == ImageState::kDecoded);
  return image.decoded;  // no other thread uses a decoded image
}

void FieldPlayback::uploaded(ImageKey key) {
  const Lock lock(mutex_);
  Image& image = images_.at(key);
  MULTUM_CHECK(image.state == ImageState::kDecoded);
  image.state = ImageState::kUploaded;
  image.decoded = {};
  memory_.give_back(image.bytes / 2);
  image.bytes -= image.bytes / 2;
}

std::vector<ImageKey> FieldPlayback::decoded_ahead() const {
  const Lock lock(mutex_);
  std::vector<std::pair<std::size_t, ImageKey>> found;
  for (const auto& [key, image] : images_)
    if (image.state == ImageState::kDecoded && image.rank.frame == frame_) found.emplace_back(image.rank.distance, key);
  std::sort(found.begin(), found.end());
  std::vector<ImageKey> keys;
  for (const auto& [distance, key] : found) keys.push_back(key);
  return keys;
}

PlaybackCounts FieldPlayback::counts() const {
  const Lock lock(mutex_);
  PlaybackCounts counts = counts_;
  counts.bytes = memory_.bytes();
  counts.bytes_most = memory_.most();
  return counts;
}

std::vector<std::string> FieldPlayback::damaged() const {
  const Lock lock(mutex_);
  return damaged_;
}

// ---- heads and coefficients of chunks

void FieldPlayback::damage(Chunk& chunk, const std::string& what) {
  drop_coefficients(chunk);
  memory_.give_back(chunk.head_bytes);
  chunk.head_bytes = 0;
  chunk.plan.reset();
  chunk.format.reset();
  chunk.state = ChunkState::kDamaged;
  damaged_.push_back(what);
}

void FieldPlayback::leave_out(Chunk& chunk, const std::string& part) {
  damage(chunk, fmt::format("{} is omitted, because its {} would take too much of the {} bytes of memory",
                            file_.section_name(chunk.section), part, memory_.bytes_max()));
}

void FieldPlayback::read_head(Chunk& chunk, std::size_t distance) {
  const PackedSection& section = file_.index().sections()[chunk.section];
  if (section.length > memory_.bytes_max() / kChunkShare) return leave_out(chunk, "bytes");
  if (!make_room(section.length, distance)) return;  // requested again later
  MULTUM_CHECK(memory_.take(section.length));
  const ScopedTake taken(memory_, section.length);
  try {
    std::vector<std::uint8_t> bytes;
    {
      const Lock lock(file_mutex_);
      bytes = file_.section(chunk.section);
    }
    ByteReader reader(bytes);
    std::string problem;
    auto format = read_chunk_format(reader, problem);
    if (!format) return damage(chunk, file_.section_name(chunk.section) + " is damaged: " + problem);
    file_.check_head(chunk.section, *format);
    const std::size_t plan_bytes = plan_bytes_max(*format);
    if (plan_bytes > memory_.bytes_max() / kChunkShare) return leave_out(chunk, "head");
    if (!make_room(plan_bytes, distance)) return;
    MULTUM_CHECK(memory_.take(plan_bytes));
    chunk.head_bytes = plan_bytes;
    chunk.plan = format->plan();
    chunk.offset = format->offset_colour();
    chunk.served.assign(chunk.plan->image_count(), 0);
    for (const auto& terms : chunk.plan->of_samples)
      for (const auto& term : terms) ++chunk.served[term.image];
    chunk.limit = std::min(likely_coefficient_bytes(*format, chunk.plan->image_count(), section.length),
                           memory_.bytes_max() / kChunkShare);
    chunk.format = std::move(format);
    chunk.state = ChunkState::kRead;
  } catch (const Error& damaged) {
    damage(chunk, damaged.what());
  }
}

void FieldPlayback::drop_coefficients(Chunk& chunk) {
  if (chunk.decoded == nullptr) return;
  memory_.give_back(chunk.coefficient_bytes);
  chunk.coefficient_bytes = 0;
  chunk.decoded.reset();
  chunk.state = ChunkState::kRead;
}

std::size_t FieldPlayback::chunk_work_bytes(const Chunk& chunk) const {
  return file_.index().sections()[chunk.section].length + chunk.head_bytes + chunk.limit;  // decoding copies the head
}

// ---- frames

void FieldPlayback::begin_frame(std::vector<SampleShare> now, std::vector<std::vector<SampleShare>> ahead) {
  const Lock lock(mutex_);
  ++frame_;
  now_ = std::move(now);
  ahead_ = std::move(ahead);
  for (std::size_t d = ahead_.size(); d-- > 0;) want(d + 1, ahead_[d]);
  want(0, now_);
  cancel_unwanted();
  forget_old();
}

/// Marks wanted images, so that they are not forgotten for later frames.
void FieldPlayback::want(std::size_t distance, const std::vector<SampleShare>& shares) {
  for (std::size_t l = 0; l < chunk_of_.size(); ++l)
    for (const SampleShare& share : mixed(l, shares)) {
      const Place place = *place_of(l, share.sample);
      Chunk& chunk = *chunks_[place.chunk];
      chunk.rank = {frame_, distance};
      if (!chunk.plan) continue;
      for (const auto& term : chunk.plan->of_samples[place.sample]) {
        const auto found = images_.find({place.chunk, term.image});
        if (found != images_.end()) found->second.rank = {frame_, distance};
      }
      const auto sum = images_.find(sum_of(place));
      if (sum != images_.end()) sum->second.rank = {frame_, distance};
    }
}

void FieldPlayback::cancel_unwanted() {
  std::deque<Job> wanted;
  for (const Job& job : jobs_) {
    const Rank& rank = job.image ? images_.at({job.chunk, *job.image}).rank : chunks_[job.chunk]->rank;
    if (rank.frame == frame_) wanted.push_back(job);
    else unqueue(job);
  }
  jobs_ = std::move(wanted);
  for (const auto& chunk : chunks_)
    if (chunk->state == ChunkState::kDecoding && chunk->rank.frame != frame_) chunk->cancelled = true;
}

/// Removes a request that no worker has begun.
void FieldPlayback::unqueue(const Job& job) {
  Chunk& chunk = *chunks_[job.chunk];
  ++counts_.cancelled;
  if (!job.image) {
    memory_.give_back(chunk_work_bytes(chunk));
    chunk.state = ChunkState::kRead;
    return;
  }
  const auto image = images_.find({job.chunk, *job.image});
  memory_.give_back(image->second.bytes + image->second.work_bytes);
  images_.erase(image);
  --chunk.images_at_work;
}

}  // namespace multum
