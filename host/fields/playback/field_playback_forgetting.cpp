// SPDX-License-Identifier: Apache-2.0
// Forgets decoded images that have expired, and images that must make room for more urgent ones.
#include <algorithm>
#include <cmath>
#include <utility>

#include "host/fields/playback/field_playback.h"

namespace multum {

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

/// Forgets images until `bytes` fit. First forgets images that no known frame wants, in the order of their expiry. If
/// `distance` is 0, then forgets images that later frames want, beginning with the latest frame, and coefficients that
/// the current frame does not need. If all of these would not free enough memory, forgets nothing and returns false.
bool FieldPlayback::make_room(std::size_t bytes, std::size_t distance) {
  struct Victim {
    bool is_wanted;
    double life;  // frames until expiry; for a wanted image, the negative number of frames until it is wanted
    std::map<ImageKey, Image>::iterator image;
    Chunk* chunk;  // the chunk whose coefficients can be forgotten; null for an image
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

}  // namespace multum
