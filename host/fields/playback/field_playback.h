// SPDX-License-Identifier: Apache-2.0
// Decodes a packed field during playback (Hakura et al. 2000, section 5). Finds which images of chunks are needed at a
// point of the parameter space. Worker threads decode these images, starting with the nearest frames and the coarsest
// levels. A cache forgets an image `a * b^l` frames after its last use, where `l` is the image's level above the images
// of single samples. In an adaptive pyramid or a basis, images have no such level. There, an image that S samples share
// counts as level `log4(S)`, as in the paper's pyramid over two parameters. This class does not draw. The caller
// uploads images and reports each upload.
//
// Memory is counted before it is allocated, and never exceeds memory_max. Coefficients, images, their uploaded copies,
// the workers' buffers, and the caller's memory for drawing are counted. The description and the index are not counted.
//
// Only one thread may call this class; the workers are internal. The code is in three files. field_playback.cpp
// determines which images are needed and their state, field_playback_forgetting.cpp forgets images, and
// field_playback_decoding.cpp makes requests and runs the workers.
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
  int threads = 0;                                  // number of decoding threads; 0 means one per core
  double lifetime = 20.0;        // a: number of frames for which an unused image of a single sample is kept; 0 to 1e6
  double lifetime_factor = 4.0;  // b, 1 to 64
  DecodedKind kind = DecodedKind::kImages;
};

struct NeededImage {
  ImageKey key;
  float weight;
};

/// The images whose sum is a layer's texture at a point. With DecodedKind::kTextures, there is only one texture.
struct LayerNeed {
  bool is_drawn = false;            // the object has a texture of the layer there, and its chunk is undamaged
  std::size_t mapping = 0;          // mapping of the object, which gives the texture's size
  bool is_decoded = false;          // all coefficients are decoded, so it is known which images are zero
  std::array<float, 3> offset{};    // gamma-coded
  std::vector<NeededImage> images;  // the coarsest first, without images that are known to be zero
};

enum class ImageState { kAbsent, kAwaited, kDecoded, kUploaded };

struct PlaybackCounts {
  std::size_t chunks_decoded = 0, images_decoded = 0, cancelled = 0, forgotten = 0;
  std::size_t bytes = 0, bytes_most = 0;
  double chunk_seconds = 0.0, image_seconds = 0.0;  // processor time of all workers together
};

class FieldPlayback {
 public:
  /// Calls `forget` whenever another call discards a decoded image. `forget` must delete all uploaded copies of the
  /// image, including partial ones, and must not call this object. Throws Error(kInput). Throws Error(kUsage) for
  /// settings out of range.
  FieldPlayback(const std::string& path, const PlaybackSettings& settings, std::function<void(ImageKey)> forget);
  /// Cancels running decodings.
  ~FieldPlayback();
  FieldPlayback(const FieldPlayback&) = delete;
  FieldPlayback& operator=(const FieldPlayback&) = delete;

  const FieldDescription& description() const { return file_.description(); }

  /// Permanently counts memory that the caller uses. Throws Error(kEnvironment) if there is too little.
  void reserve(std::size_t bytes);

  /// Begins the next frame at `now`. Later frames are expected at the points `ahead`, in this order. Forgets expired
  /// images, cancels unwanted decodings, and requests missing images.
  void begin_frame(std::vector<SampleShare> now, std::vector<std::vector<SampleShare>> ahead);
  /// Forgets all decoded images and requests. Waits for workers. Call it between frames.
  void forget_all();
  /// Requests the images that the same frame still lacks, as far as memory allows. Must be called after wait() and
  /// after uploads.
  void request();
  /// Waits until a worker has finished a request. Returns false at once if no worker runs.
  bool wait();

  /// The object and mapping of a chunk's images.
  struct ImageObject {
    std::size_t object, mapping;
  };
  ImageObject object_of(ImageKey key) const { return objects_[key.chunk]; }

  /// Returns the images that are needed at the frame's point. Mixes only samples whose textures have the size of the
  /// nearest sample's texture.
  LayerNeed need(std::size_t layer) const;
  ImageState state(ImageKey key) const;
  /// Returns an image whose state is kDecoded. The image is kept until uploaded() is called.
  const DecodedImage& decoded(ImageKey key) const;
  void uploaded(ImageKey key);
  /// Returns decoded images that later frames need, the nearest first.
  std::vector<ImageKey> decoded_ahead() const;

  PlaybackCounts counts() const;
  /// Returns the faults of all chunks that have been left out so far.
  std::vector<std::string> damaged() const;

 private:
  // A chunk may use 1/kChunkShare of the memory for its coefficients, and as much for its head. Several chunks then fit
  // into memory, and an untrusted chunk cannot take all of it.
  static constexpr std::size_t kChunkShare = 4;

  struct Rank {
    std::uint64_t frame = 0;   // the last frame that wanted it
    std::size_t distance = 0;  // number of frames until it is wanted; 0 means now
  };
  enum class ChunkState { kUnread, kRead, kQueued, kDecoding, kDecoded, kDamaged };
  struct Chunk {
    std::size_t section = 0;
    ChunkState state = ChunkState::kUnread;
    std::optional<TextureChunkFormat> format;
    std::optional<ImagePlan> plan;
    std::vector<std::uint32_t> served;  // number of samples that each image serves
    std::vector<bool> zeros;            // whether each image is zero; empty until this is known
    std::array<float, 3> offset{};
    std::shared_ptr<const TextureChunk> decoded;
    std::size_t head_bytes = 0, coefficient_bytes = 0;  // counted bytes
    std::size_t limit = 0;                              // bytes for coefficients at the next try
    std::size_t images_at_work = 0;                     // includes requested images
    std::atomic<bool> cancelled{false};
    Rank rank;
    bool is_pending = false;  // the current frame needs images that are not yet decoded from this chunk

    bool is_zero(std::size_t image) const { return !zeros.empty() && zeros[image]; }
  };
  struct Image {
    ImageState state = ImageState::kAwaited;
    DecodedImage decoded;
    std::size_t bytes = 0, work_bytes = 0;  // counted bytes of the result, and bytes needed only while decoding
    Rank rank;
  };
  struct Job {
    std::size_t chunk;
    std::optional<std::size_t> image;  // if unset, the chunk's coefficients
    std::size_t order = 0;             // order among the jobs of a frame, as in Wanted
  };
  struct Wanted {
    std::size_t order;  // 0 for coefficients, 1 for a sum or a texture; terms have 2, 3 and so on, the coarsest first
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
  /// Returns the key of the sum of a sample's images, or of its texture.
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
  std::vector<std::vector<std::optional<std::size_t>>> chunk_of_;  // [layer][block]; unset if nothing in it is visible
  std::vector<ImageObject> objects_;                               // object of each chunk
  std::vector<SampleShare> now_;
  std::vector<std::vector<SampleShare>> ahead_;

  mutable std::mutex mutex_;  // protects all members below
  std::condition_variable has_job_, has_news_;
  std::vector<std::unique_ptr<Chunk>> chunks_;
  std::map<ImageKey, Image> images_;
  std::deque<Job> jobs_;
  MemoryAccount memory_;
  PlaybackCounts counts_;
  std::vector<std::string> damaged_;
  std::uint64_t frame_ = 0;
  std::size_t at_work_ = 0;
  bool has_finished_ = false;  // a worker has finished since wait() last returned
  bool is_ending_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace multum
