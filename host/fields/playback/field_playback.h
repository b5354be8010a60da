// SPDX-License-Identifier: Apache-2.0
// Decodes a packed field while it is played (Hakura et al. 2000, section 5): which images of which chunks a point of
// the parameter space needs, worker threads that decode them, nearest ahead and coarsest first, and a cache that
// forgets an image a b^l frames after it was last used, l levels above those of single samples. What lies on any
// adaptive pyramid or basis has no such level; an image that S samples are made of counts as level log4(S), which it is
// in the paper's pyramid over two parameters. Nothing here draws: whoever does uploads images, and says so.
//
// Memory: everything is counted before it is allocated - coefficients, images, uploaded copies of them, what a worker
// needs while it works, what the caller draws with - and never exceeds memory_max. Not counted: the description and the
// index.
//
// One thread calls all of this; workers are inside. In three files: what a point needs and what is there of it;
// _forgetting, what is forgotten, and for what; _decoding, what is asked for and how workers decode it.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "host/fields/codec/field_unpacking.h"
#include "host/fields/playback/decoded_image.h"
#include "host/fields/playback/field_point.h"
#include "host/fields/playback/image_key.h"
#include "host/fields/playback/memory_account.h"

namespace multum {

struct PlaybackSettings {
  std::size_t memory_max = std::size_t{256} << 20;  // bytes, at least 2^20
  int threads = 0;                                  // that decode; 0: all cores
  double lifetime = 20.0;        // a: frames that an image of a single sample is kept unused; 0 to 1e6
  double lifetime_factor = 4.0;  // b, 1 to 64
  DecodedKind kind = DecodedKind::kImages;
};

struct NeededImage {
  ImageKey key;
  float weight;
};

/// What the texture of a layer is the sum of, at a point; one texture of DecodedKind::kTextures.
struct LayerNeed {
  bool is_drawn = false;            // the object has a texture of the layer there, and its chunk is undamaged
  std::size_t mapping = 0;          // of the object: the texture's size
  bool is_decoded = false;          // all coefficients are there: which images are zero is known
  std::array<float, 3> offset{};    // gamma-coded
  std::vector<NeededImage> images;  // coarsest first; without those that are known to be zero
};

enum class ImageState { kAbsent, kAwaited, kDecoded, kUploaded };

struct PlaybackCounts {
  std::size_t chunks_decoded = 0, images_decoded = 0, cancelled = 0, forgotten = 0;
  std::size_t bytes = 0, bytes_most = 0;
  double chunk_seconds = 0.0, image_seconds = 0.0;  // processor time of all workers together
};

class FieldPlayback {
 public:
  /// `forget`: is called within calls of this when a decoded image is forgotten; an uploaded copy, also of a part, must
  /// be gone when it returns, and it may not call this. Throws Error(kInput), Error(kUsage) for settings out of range.
  FieldPlayback(const std::string& path, const PlaybackSettings& settings, std::function<void(ImageKey)> forget);
  /// Cancels what is being decoded.
  ~FieldPlayback();
  FieldPlayback(const FieldPlayback&) = delete;
  FieldPlayback& operator=(const FieldPlayback&) = delete;

  const FieldDescription& description() const { return file_.description(); }

  /// Counts memory of the caller's for good. Throws Error(kEnvironment) when there is too little.
  void reserve(std::size_t bytes);

  /// The next frame is at `now`; later ones, the next first, will be at `ahead`. Forgets what has outlived its time,
  /// cancels what nobody wants any more, and asks for what is missing.
  void begin_frame(std::vector<SampleShare> now, std::vector<std::vector<SampleShare>> ahead);
  /// As if nothing had been decoded or asked for yet; waits for workers. Between frames.
  void forget_all();
  /// Asks for what is still missing of the same frame, as far as memory goes: after wait(), and after uploads.
  void request();
  /// Until a worker has finished something; false at once when none works.
  bool wait();

  /// What an image of a chunk is a texture of.
  struct ImageObject {
    std::size_t object, mapping;
  };
  ImageObject object_of(ImageKey key) const { return objects_[key.chunk]; }

  /// Of the frame's point. Mixed are the samples whose textures have the size of the nearest one's.
  LayerNeed need(std::size_t layer) const;
  ImageState state(ImageKey key) const;
  /// Of a state of kDecoded; stays until uploaded().
  const DecodedImage& decoded(ImageKey key) const;
  void uploaded(ImageKey key);
  /// Decoded images that the frames ahead want, the nearest first.
  std::vector<ImageKey> decoded_ahead() const;

  PlaybackCounts counts() const;
  /// What is wrong with each chunk that is left out, so far.
  std::vector<std::string> damaged() const;

 private:
  // A chunk may take so much of the memory for its coefficients, and as much for its head: several fit, and no file of
  // a stranger's gets all.
  static constexpr std::size_t kChunkShare = 4;

  struct Rank {
    std::uint64_t frame = 0;   // at which it was last wanted
    std::size_t distance = 0;  // how many frames ahead, 0 is now
  };
  enum class ChunkState { kUnread, kRead, kQueued, kDecoding, kDecoded, kDamaged };
  struct Chunk {
    std::size_t section = 0;
    ChunkState state = ChunkState::kUnread;
    std::optional<TextureChunkFormat> format;
    std::optional<ImagePlan> plan;
    std::vector<std::uint32_t> served;  // samples that each image is part of
    std::vector<bool> zeros;            // of each image; empty: not known yet
    std::array<float, 3> offset{};
    std::shared_ptr<const TextureChunk> decoded;
    std::size_t head_bytes = 0, coefficient_bytes = 0;  // that are counted
    std::size_t limit = 0;                              // of bytes for coefficients, for the next try
    std::size_t images_at_work = 0;                     // asked for included
    std::atomic<bool> cancelled{false};
    Rank rank;
    bool is_pending = false;  // the frame needs something now that is yet to be decoded from it

    bool is_zero(std::size_t image) const { return !zeros.empty() && zeros[image]; }
  };
  struct Image {
    ImageState state = ImageState::kAwaited;
    DecodedImage decoded;
    std::size_t bytes = 0, work_bytes = 0;  // that are counted: kept, and until it is decoded
    Rank rank;
  };
  struct Job {
    std::size_t chunk;
    std::optional<std::size_t> image;  // none: the chunk's coefficients
    std::size_t order = 0;             // among those for the same frame, as in Wanted
  };
  struct Wanted {
    std::size_t order;  // 1: a sum or a texture; then terms from 2 on, the coarsest first. 0 are coefficients
    ImageKey key;
    auto operator<=>(const Wanted&) const = default;
  };
  /// A chunk of a layer and the sample in it.
  struct Place {
    std::size_t chunk, sample;
  };
  using Lock = std::unique_lock<std::mutex>;

  bool is_textures() const { return settings_.kind == DecodedKind::kTextures; }
  bool has(ImageKey key) const;
  /// Of the sum of a sample's images, or its texture.
  ImageKey sum_of(const Place& place) const {
    return {place.chunk, chunks_[place.chunk]->served.size() + place.sample};
  }
  std::optional<Place> place_of(std::size_t layer, std::size_t sample) const;
  std::vector<SampleShare> mixed(std::size_t layer, const std::vector<SampleShare>& shares) const;
  void read_head(Chunk& chunk, std::size_t distance);
  void drop_coefficients(Chunk& chunk);
  void damage(Chunk& chunk, const std::string& what);
  void leave_out(Chunk& chunk, const std::string& part);
  std::size_t chunk_work_bytes(const Chunk& chunk) const;
  std::size_t ask_terms(const Place& place, std::size_t distance, std::vector<Wanted>& wanted) const;

  void want(std::size_t distance, const std::vector<SampleShare>& shares);
  bool ask(std::size_t distance, const std::vector<SampleShare>& shares);
  bool ask_chunk(std::size_t number, std::size_t distance);
  bool ask_image(const Wanted& wanted, std::size_t distance);
  bool make_room(std::size_t bytes, std::size_t distance);
  double lifetime(const Chunk& chunk) const;
  double lifetime(ImageKey key) const;
  void forget_old();
  void cancel_unwanted();
  void unqueue(const Job& job);
  std::map<ImageKey, Image>::iterator forget_image(std::map<ImageKey, Image>::iterator image);

  void work();
  void decode_chunk(Lock& lock, Chunk& chunk);
  void decode_image(Lock& lock, ImageKey key);

  PlaybackSettings settings_;
  std::function<void(ImageKey)> forget_;
  std::mutex file_mutex_;
  PackedFieldFile file_;
  std::vector<std::vector<std::optional<std::size_t>>> chunk_of_;  // [layer][block]; none: nothing is seen in it
  std::vector<ImageObject> objects_;                               // of each chunk
  std::vector<SampleShare> now_;
  std::vector<std::vector<SampleShare>> ahead_;

  mutable std::mutex mutex_;  // of all below
  std::condition_variable has_job_, has_news_;
  std::vector<std::unique_ptr<Chunk>> chunks_;
  std::map<ImageKey, Image> images_;
  std::deque<Job> jobs_;
  MemoryAccount memory_;
  PlaybackCounts counts_;
  std::vector<std::string> damaged_;
  std::uint64_t frame_ = 0;
  std::size_t at_work_ = 0;
  bool has_finished_ = false;  // something, since wait() last returned
  bool is_ending_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace multum
