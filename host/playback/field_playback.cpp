// SPDX-License-Identifier: Apache-2.0
#include "host/playback/field_playback.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/base/error.h"
#include "host/base/half_bits.h"
#include "host/base/stopwatch.h"
#include "host/base/vector_clones.h"
#include "host/codec/decoder/mip_levels.h"

namespace multum {
namespace {

constexpr std::size_t kMemoryLeast = std::size_t{1} << 20;
// A chunk may take so much of the memory for its coefficients, and an eighth of that for its head: several fit, and no
// file of a stranger's gets all.
constexpr std::size_t kChunkShare = 4;
constexpr std::size_t kHalfBytes = 8;   // of an image, a texel: RGBA halves
constexpr std::size_t kWorkBytes = 20;  // a texel while an image is decoded: three colours, a plane, lines of wavelets
constexpr std::size_t kTextureWorkBytes = 32;  // of a texture: three colours, and three of all mip levels

std::size_t texels_of(const TextureChunkFormat& format) { return format.width * format.height; }

/// Of a head and its plan: 24 bytes a vector, 16 a term, 64 an image. read_chunk_format() holds S L 2^D to 2^22, so no
/// product overflows.
std::size_t plan_bytes_max(const TextureChunkFormat& format) {
  std::size_t samples = 1;
  for (const std::size_t size : format.sizes) samples *= size;
  const std::size_t levels = std::max(format.levels.size(), format.basis.size());
  const std::size_t terms = samples * levels << (format.linear ? format.sizes.size() : 0);
  return 24 * samples + 16 * terms + 64 * samples * levels + samples * format.basis.size();
}

/// What a chunk's coefficients take as a rule: cosines a place for each block of each plane, both so many bytes a coded
/// byte (at most 250 in files of field_demo1 at 60:1 to 800:1), wavelets two images at work, at eight bytes a texel of
/// each plane.
std::size_t likely_bytes(const TextureChunkFormat& format, std::size_t image_count, std::size_t coded_bytes) {
  const std::size_t blocks = (format.width / format.side + 1) * (format.height / format.side + 1);
  return 256 * coded_bytes +
         (format.coder == ImageCoder::kWavelet ? 48 * texels_of(format) : 12 * image_count * blocks);
}

MULTUM_VECTOR_CLONES void round_to_halves(const float* values, std::size_t count, std::uint16_t* halves) {
  for (std::size_t i = 0; i < count; ++i) halves[i] = clamped_to_half(values[i]);
}

/// Four halves a texel of three floats, the fourth left as it is. Rounded some hundred texels at a time, without the
/// fourth, so that the loop becomes vector instructions.
void write_halves(std::span<const float> colours, std::span<std::uint16_t> halves) {
  constexpr std::size_t kTexels = 256;
  std::array<std::uint16_t, 3 * kTexels> rounded;
  const std::size_t texels = colours.size() / 3;
  for (std::size_t first = 0; first < texels; first += kTexels) {
    const std::size_t count = std::min(kTexels, texels - first);
    round_to_halves(colours.data() + 3 * first, 3 * count, rounded.data());
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t c = 0; c < 3; ++c) halves[4 * (first + i) + c] = rounded[3 * i + c];
  }
}

DecodedImage halves_of(const TextureChunk& chunk, std::size_t number, DecodedKind kind) {
  const TextureChunkFormat& format = chunk.format();
  const std::size_t images = chunk.plan().image_count();
  const std::vector<float> colours = number < images                  ? chunk.image(number)
                                     : kind == DecodedKind::kTextures ? radiance_levels(chunk, number - images)
                                                                      : chunk.image_sum(number - images);
  DecodedImage result{format.width, format.height, std::vector<std::uint16_t>(colours.size() / 3 * 4)};
  write_halves(colours, result.halves);
  return result;
}

/// Gives back what was taken, at the end of the block.
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
    refuse(fmt::format("a factor of lifetimes of {}, expected 1 to 64", settings.lifetime_factor));
}

/// The mapping is one for all of a block.
FieldPlayback::ImageObject object_of_block(const FieldDescription& description, const PackedLayer& layer,
                                           std::size_t block) {
  const std::vector<int>& mappings = description.field.objects[layer.object].mapping_of_sample;
  for (const std::size_t sample : description.grid.samples_in(layer.blocks[block]))
    if (layer.is_seen(sample)) return {layer.object, static_cast<std::size_t>(mappings[sample])};
  return {layer.object, 0};  // nobody asks for it
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
  const int threads = settings.threads > 0 ? settings.threads : static_cast<int>(std::thread::hardware_concurrency());
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
              fmt::format("playback: drawing takes {} bytes, {} of {} are left: allow more memory", bytes,
                          memory_.bytes_max() - memory_.bytes(), memory_.bytes_max()));
}

// ---- what a point needs

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
    if (!is_usable && same.empty()) return {};  // the nearest says whether there is anything
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
  std::map<std::pair<std::size_t, ImageKey>, float> weights;  // by place in the order of terms
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

/// Decoded, perhaps uploaded.
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
  return image.decoded;  // nobody else touches it now
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
  damage(chunk, fmt::format("{} is left out: its {} would take too much of {} bytes of memory",
                            file_.section_name(chunk.section), part, memory_.bytes_max()));
}

void FieldPlayback::read_head(Chunk& chunk, std::size_t distance) {
  const PackedSection& section = file_.index().sections()[chunk.section];
  if (section.length > memory_.bytes_max() / kChunkShare) return leave_out(chunk, "bytes");
  if (!make_room(section.length, distance)) return;  // later
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
    chunk.limit =
        std::min(likely_bytes(*format, chunk.plan->image_count(), section.length), memory_.bytes_max() / kChunkShare);
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
  return file_.index().sections()[chunk.section].length + chunk.head_bytes + chunk.limit;  // it has a head of its own
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

/// Marks what is wanted: it is not forgotten for what is wanted later.
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

/// Takes back what was asked for and not begun.
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

// ---- forgetting

double FieldPlayback::lifetime(const Chunk& chunk) const {
  const double samples = chunk.plan ? static_cast<double>(chunk.plan->of_samples.size()) : 1.0;
  return settings_.lifetime * std::pow(settings_.lifetime_factor, std::log2(samples) / 2.0 + 1.0);
}

double FieldPlayback::lifetime(ImageKey key) const {
  const Chunk& chunk = *chunks_[key.chunk];
  const bool is_sum = key.image >= chunk.served.size();
  const double samples = is_sum ? 1.0 : static_cast<double>(std::max(1u, chunk.served[key.image]));
  return settings_.lifetime * std::pow(settings_.lifetime_factor, std::log2(samples) / 2.0);
}

std::map<ImageKey, FieldPlayback::Image>::iterator FieldPlayback::forget_image(
    std::map<ImageKey, Image>::iterator image) {
  forget_(image->first);
  memory_.give_back(image->second.bytes);
  ++counts_.forgotten;
  return images_.erase(image);
}

void FieldPlayback::forget_old() {
  const auto is_old = [&](const Rank& rank, double frames) {
    return static_cast<double>(frame_ - rank.frame) > frames;
  };
  for (auto image = images_.begin(); image != images_.end();) {
    const bool is_kept = image->second.state == ImageState::kAwaited || image->second.rank.frame == frame_ ||
                         !is_old(image->second.rank, lifetime(image->first));
    image = is_kept ? std::next(image) : forget_image(image);
  }
  for (const auto& chunk : chunks_)
    if (chunk->images_at_work == 0 && chunk->rank.frame != frame_ && is_old(chunk->rank, lifetime(*chunk)))
      drop_coefficients(*chunk);
}

void FieldPlayback::forget_all() {
  Lock lock(mutex_);
  for (const Job& job : std::exchange(jobs_, {})) unqueue(job);
  for (const auto& chunk : chunks_) chunk->cancelled = true;
  has_news_.wait(lock, [&] { return at_work_ == 0; });
  for (auto image = images_.begin(); image != images_.end();) image = forget_image(image);
  for (const auto& chunk : chunks_) {
    if (chunk->state == ChunkState::kUnread || chunk->state == ChunkState::kDamaged) continue;
    drop_coefficients(*chunk);
    memory_.give_back(chunk->head_bytes);
    chunk->head_bytes = 0;
    chunk->plan.reset();
    chunk->format.reset();
    chunk->zeros.clear();
    chunk->state = ChunkState::kUnread;
  }
}

/// Forgets until so many bytes fit: first what no frame in sight wants, the nearest to the end of its life first; for
/// what is wanted now also what is wanted later, the latest first, and coefficients of which nothing is wanted now.
/// False, and nothing is forgotten in vain but what nobody wants, where that is not enough.
bool FieldPlayback::make_room(std::size_t bytes, std::size_t distance) {
  struct Victim {
    bool is_wanted;
    double life;  // what is left of it, in frames; of what is wanted minus how far ahead
    std::map<ImageKey, Image>::iterator image;
    Chunk* chunk;  // its coefficients; null: the image
    std::size_t bytes;
  };
  if (memory_.has_room(bytes)) return true;
  std::vector<Victim> victims;
  const auto consider = [&](const Rank& rank, bool is_needed_now, double frames, auto image, Chunk* chunk,
                            std::size_t freed) {
    const bool is_wanted = rank.frame == frame_;
    if (is_wanted && (distance > 0 || is_needed_now)) return;
    const double life =
        is_wanted ? -static_cast<double>(rank.distance) : frames - static_cast<double>(frame_ - rank.frame);
    victims.push_back({is_wanted, life, image, chunk, freed});
  };
  for (auto image = images_.begin(); image != images_.end(); ++image)
    if (image->second.state != ImageState::kAwaited)
      consider(image->second.rank, image->second.rank.distance == 0, lifetime(image->first), image, nullptr,
               image->second.bytes);
  for (const auto& chunk : chunks_)
    if (chunk->decoded != nullptr && chunk->images_at_work == 0)
      consider(chunk->rank, chunk->is_pending, lifetime(*chunk), images_.end(), chunk.get(), chunk->coefficient_bytes);
  std::sort(victims.begin(), victims.end(), [](const Victim& a, const Victim& b) {
    return a.is_wanted != b.is_wanted ? b.is_wanted : a.life < b.life;
  });
  std::size_t freed = memory_.bytes_max() - memory_.bytes();
  for (const Victim& victim : victims) freed += victim.bytes;
  if (freed < bytes) return false;
  for (const Victim& victim : victims) {
    if (memory_.has_room(bytes)) break;
    if (victim.chunk != nullptr) drop_coefficients(*victim.chunk);
    else forget_image(victim.image);
  }
  return true;
}

// ---- asking

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

/// Coarse first: coefficients, then sums, then the first images of all layers, then the second ones. False where memory
/// is too full for something.
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

/// Of a sample: what there is not even a request for. Returns how many images that are not there it is made of.
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
  if (chunk.rank.frame != frame_) chunk.rank = {frame_, distance};  // its head was read just now
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
  const std::size_t texels = texels_of(*chunk.format);
  const std::size_t kept_texels = is_textures() ? mip_texel_count(chunk.format->width, chunk.format->height) : texels;
  const std::size_t kept = 2 * kHalfBytes * kept_texels;  // twice: the uploaded copy
  const std::size_t work = (is_textures() ? kTextureWorkBytes : kWorkBytes) * texels;
  ++chunk.images_at_work;  // its coefficients stay
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
  } catch (const std::exception& error) {  // also no memory
    problem = error.what();
    decoded.reset();
  }
  lock.lock();
  counts_.chunk_seconds += stopwatch.seconds();
  memory_.give_back(taken);
  chunk.state = ChunkState::kRead;
  if (decoded != nullptr) {
    chunk.coefficient_bytes = chunk.head_bytes + decoded->memory_bytes();
    MULTUM_CHECK(memory_.take(chunk.coefficient_bytes));  // less than was taken
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
    if (coefficients == nullptr) throw Error(ErrorCode::kEnvironment, "its coefficients are gone");
    decoded = halves_of(*coefficients, key.image, settings_.kind);
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
