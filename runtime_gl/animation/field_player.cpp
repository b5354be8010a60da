// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/animation/field_player.h"

#include <algorithm>

#include "host/formats/asset/mip_layout.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/stopwatch.h"

namespace multum::gl {
namespace {

constexpr std::size_t kTexelBytes = 8;  // size of four 16-bit floats
constexpr std::size_t kUploadLeast = std::size_t{1} << 16;

PlayerSettings with_kind(PlayerSettings settings) {
  // A player that waits must draw the same frames on machines of any speed.
  settings.playback.kind = !settings.waits      ? DecodedKind::kImagesAndSums
                           : settings.is_linear ? DecodedKind::kImages
                                                : DecodedKind::kTextures;
  return settings;
}

}  // namespace

FieldPlayer::FieldPlayer(const GlFunctions& gl, const std::string& path, const PlayerSettings& settings)
    : gl_(gl),
      settings_(with_kind(settings)),
      playback_(path, settings_.playback, [this](ImageKey key) { images_.erase(key); }),
      textures_(playback_.description().layers.size()) {
  if (settings.upload_max < kUploadLeast)
    throw Error(ErrorCode::kUsage, "playback: uploads of " + std::to_string(settings.upload_max) +
                                       " bytes per frame, expected at least " + std::to_string(kUploadLeast));
  if (!has_whole_textures()) reserve_memory();
}

/// Reserves memory for the largest texture of every layer, and for the sums.
void FieldPlayer::reserve_memory() {
  int width_max = 1, height_max = 1;
  std::size_t bytes = 0;
  for (const PackedLayer& layer : description().layers) {
    std::size_t most = 0;
    for (const TextureMapping& mapping : description().field.objects[layer.object].mappings) {
      width_max = std::max(width_max, mapping.width);
      height_max = std::max(height_max, mapping.height);
      const MipLayout layout(mapping.width, mapping.height);
      most = std::max(most, kTexelBytes * static_cast<std::size_t>(layout.texel_count));
    }
    bytes += most;
  }
  playback_.reserve(bytes + LayerSum::memory_bytes(width_max, height_max));
  sum_ = std::make_unique<LayerSum>(gl_, width_max, height_max);
}

bool FieldPlayer::is_there(ImageKey key) const { return playback_.state(key) == ImageState::kUploaded; }

FieldPlayer::Upload& FieldPlayer::begun_upload(ImageKey key, const DecodedImage& decoded) {
  auto found = images_.find(key);
  if (found != images_.end()) return found->second;
  const int width = static_cast<int>(decoded.width), height = static_cast<int>(decoded.height);
  if (!has_whole_textures()) {
    Texture texture(gl_, "decoded image", {width, height, 1, TexelFormat::kRgba16f},
                    {WrapMode::kClamp, WrapMode::kClamp, false, 1.0f});
    return images_.emplace(key, Upload{std::move(texture)}).first->second;
  }
  const auto [object, mapping] = playback_.object_of(key);
  const InferredObject& described = description().field.objects[object];
  Texture texture(gl_, described.name + "'s texture",
                  {width, height, MipLayout(width, height).level_count(), TexelFormat::kRgba16f},
                  {described.mappings[mapping].wrap_s, described.mappings[mapping].wrap_t, true, described.anisotropy});
  return images_.emplace(key, Upload{std::move(texture)}).first->second;
}

/// Uploads as many rows of a decoded image as fit into `bytes_max`, but at least one row.
void FieldPlayer::upload(ImageKey key, std::size_t bytes_max) {
  const ScopedStopwatch stopwatch(report_.upload_seconds);
  const DecodedImage& decoded = playback_.decoded(key);
  Upload& image = begun_upload(key, decoded);
  const TextureShape& shape = image.texture.shape();
  const MipLayout layout(shape.width, shape.height);
  const std::size_t bytes_before = report_.uploaded_bytes;
  while (image.level < shape.level_count) {
    const MipLevelPlace& level = layout.levels[static_cast<std::size_t>(image.level)];
    const std::size_t row = kTexelBytes * static_cast<std::size_t>(level.width);
    const std::size_t left = bytes_max - std::min(bytes_max, report_.uploaded_bytes - bytes_before);
    if (left < row && report_.uploaded_bytes > bytes_before) return;
    const int rows = static_cast<int>(std::clamp<std::size_t>(left / row, 1, static_cast<std::size_t>(level.height)));
    const int count = std::min(rows, level.height - image.row);
    const std::size_t texel = static_cast<std::size_t>(level.offset) +
                              static_cast<std::size_t>(image.row) * static_cast<std::size_t>(level.width);
    image.texture.upload_rows(image.level, image.row, count, decoded.halves.data() + 4 * texel);
    report_.uploaded_bytes += row * static_cast<std::size_t>(count);
    image.row += count;
    if (image.row < level.height) return;
    image.row = 0;
    ++image.level;
  }
  playback_.uploaded(key);
}

/// Uploads coarse images first. If `all` is set, uploads all images. Otherwise uploads the whole first image of each
/// layer, and other images within the frame's byte limit.
void FieldPlayer::upload_for(const std::vector<LayerNeed>& needs, bool all) {
  std::size_t most = 0;
  for (const LayerNeed& need : needs) most = std::max(most, need.images.size());
  for (std::size_t i = 0; i < most; ++i)
    for (const LayerNeed& need : needs) {
      if (i >= need.images.size() || playback_.state(need.images[i].key) != ImageState::kDecoded) continue;
      if (all || i == 0) upload(need.images[i].key, SIZE_MAX);
      else if (report_.uploaded_bytes < settings_.upload_max)
        upload(need.images[i].key, settings_.upload_max - report_.uploaded_bytes);
    }
}

bool FieldPlayer::is_drawable(std::size_t layer, const LayerNeed& need) const {
  if (!need.is_drawn) return true;
  if (settings_.waits)
    return need.is_decoded && std::all_of(need.images.begin(), need.images.end(),
                                          [this](const NeededImage& image) { return is_there(image.key); });
  if (need.is_decoded && (need.images.empty() || is_there(need.images.front().key))) return true;
  return textures_[layer].is_made && textures_[layer].mapping == need.mapping;  // texture of an earlier frame
}

void FieldPlayer::wait_for(std::vector<LayerNeed>& needs) {
  const Stopwatch stopwatch;
  const double uploading_before = report_.upload_seconds;
  while (true) {
    playback_.request();
    bool is_ready = true;
    for (std::size_t l = 0; l < needs.size(); ++l) needs[l] = playback_.need(l);
    upload_for(needs, settings_.waits);
    for (std::size_t l = 0; l < needs.size(); ++l) is_ready = is_ready && is_drawable(l, needs[l]);
    if (is_ready) break;
    if (playback_.wait()) continue;
    throw Error(ErrorCode::kEnvironment, "playback: the images of a frame do not fit into " +
                                             std::to_string(settings_.playback.memory_max) +
                                             " bytes of memory: raise the memory limit");
  }
  report_.wait_seconds = stopwatch.seconds() - (report_.upload_seconds - uploading_before);
}

void FieldPlayer::show(std::size_t layer, const LayerNeed& need) {
  LayerTexture& shown = textures_[layer];
  LayerReport& report = report_.layers[layer];
  report.is_drawn = true;
  report.needed = need.images.size();
  std::vector<std::pair<ImageKey, float>> images;
  for (const NeededImage& image : need.images)
    if (is_there(image.key)) images.emplace_back(image.key, image.weight);
  report.missing = need.images.size() - images.size();
  report.is_old = !need.is_decoded || (!need.images.empty() && !is_there(need.images.front().key));
  if (report.is_old) return;  // is_drawable() checked that an old texture exists
  if (!has_whole_textures()) return make_texture(layer, need, std::move(images));
  if (shown.whole != images.front().first) ++report_.textures_made;
  shown.whole = images.front().first;
}

void FieldPlayer::make_texture(std::size_t layer, const LayerNeed& need,
                               std::vector<std::pair<ImageKey, float>> images) {
  LayerTexture& made = textures_[layer];
  if (made.is_made && made.mapping == need.mapping && made.images == images && made.offset == need.offset) return;
  const InferredObject& object = description().field.objects[description().layers[layer].object];
  const TextureMapping& mapping = object.mappings[need.mapping];
  if (made.texture == nullptr || made.mapping != need.mapping) {
    made.texture.reset();  // frees memory before the next texture needs it
    const MipLayout layout(mapping.width, mapping.height);
    made.texture = std::make_unique<Texture>(
        gl_, object.name + "'s " + description().layers[layer].name,
        TextureShape{mapping.width, mapping.height, layout.level_count(), TexelFormat::kRgba16f},
        SamplerSettings{mapping.wrap_s, mapping.wrap_t, true, object.anisotropy});
  }
  std::vector<WeighedTexture> weighed;
  for (const auto& [key, weight] : images) weighed.push_back({&images_.at(key).texture, weight});
  sum_->add_up(weighed, need.offset, *made.texture);
  made.mapping = need.mapping;
  made.images = std::move(images);
  made.offset = need.offset;
  made.is_made = true;
  ++report_.textures_made;
}

const FrameReport& FieldPlayer::prepare(const std::vector<double>& point,
                                        const std::vector<std::vector<double>>& ahead) {
  const SampleGrid& grid = description().grid;
  const std::vector<double> here = clamped_point(grid, point);
  std::vector<std::vector<SampleShare>> later;
  for (const std::vector<double>& next : ahead)
    later.push_back(sample_shares(grid, clamped_point(grid, next), settings_.is_linear));
  report_ = {};
  report_.layers.resize(textures_.size());
  nearest_ = nearest_sample(grid, here);
  playback_.begin_frame(sample_shares(grid, here, settings_.is_linear), std::move(later));
  std::vector<LayerNeed> needs(textures_.size());
  wait_for(needs);
  for (const ImageKey& key : playback_.decoded_ahead()) {
    if (report_.uploaded_bytes >= settings_.upload_max) break;
    if (playback_.state(key) == ImageState::kDecoded) upload(key, settings_.upload_max - report_.uploaded_bytes);
  }
  const ScopedStopwatch stopwatch(report_.sum_seconds);
  for (std::size_t l = 0; l < needs.size(); ++l)
    if (needs[l].is_drawn) show(l, needs[l]);
  return report_;
}

void FieldPlayer::forget_all() {
  playback_.forget_all();
  for (LayerTexture& shown : textures_) {
    shown.is_made = false;
    shown.whole.reset();
  }
}

std::vector<const Texture*> FieldPlayer::layers(std::size_t object) const {
  std::vector<const Texture*> found;
  for (std::size_t l = 0; l < textures_.size(); ++l)
    if (description().layers[l].object == object && report_.layers[l].is_drawn)
      found.push_back(textures_[l].whole ? &images_.at(*textures_[l].whole).texture : textures_[l].texture.get());
  return found;
}

std::size_t FieldPlayer::mapping(std::size_t object) const {
  return static_cast<std::size_t>(description().field.objects[object].mapping_of_sample[nearest_]);
}

glm::dmat4 FieldPlayer::camera(const std::vector<double>& point) const {
  const FieldDescription& field = description();
  return matrix_at(
      field.grid, clamped_point(field.grid, point),
      [&](std::size_t sample) { return field.field.samples[sample].world_to_clip; }, camera_between);
}

}  // namespace multum::gl
