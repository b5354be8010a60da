// SPDX-License-Identifier: Apache-2.0
// Plays a packed field (Hakura et al. 2000, section 5). In each frame, a program asks for a point of the parameter
// space, and gets the textures of every object at that point, made from the images decoded so far. Images are decoded
// when they are needed, cached (host/fields/playback), and summed by the GPU. If the player waits for all images of a
// single sample, workers instead add up the sample's coefficients and cache whole textures. Then all images together
// need only one transform, and the GPU adds nothing. Textures are mapped on exact geometry, so the camera can be
// anywhere near the field's samples. docs/contributing/ALGORITHMS.md gives the allowed distance.
//
//      player.prepare(point, ahead);                         // each frame
//      for each object: draw its mesh of player.mapping(object) with player.layers(object)
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/fields/playback/field_playback.h"
#include "runtime_gl/animation/layer_sum.h"
#include "runtime_gl/gl/texture.h"

namespace multum::gl {

struct PlayerSettings {
  PlaybackSettings playback;                       // FieldPlayer sets playback.kind
  std::size_t upload_max = std::size_t{16} << 20;  // bytes uploaded per frame, at least 2^16
  bool is_linear = false;  // mixes gamma-coded samples linearly along each parameter; if false, uses the nearest sample
  bool waits = false;      // waits for all images of a frame; if false, only for each texture's coarsest image
};

/// The state of a layer in a frame.
struct LayerReport {
  bool is_drawn = false;    // the layer has something to draw
  bool is_old = false;      // no image of this point is decoded, so the previous texture stays
  std::size_t needed = 0;   // images that the texture sums
  std::size_t missing = 0;  // needed images that were not ready in time
};

struct FrameReport {
  std::vector<LayerReport> layers;  // reports, one per layer, in the description's order
  std::size_t uploaded_bytes = 0;
  std::size_t textures_made = 0;
  double wait_seconds = 0.0, upload_seconds = 0.0, sum_seconds = 0.0;
};

class FieldPlayer {
 public:
  /// Opens a packed file. Throws Error.
  FieldPlayer(const GlFunctions& gl, const std::string& path, const PlayerSettings& settings);

  const FieldDescription& description() const { return playback_.description(); }

  /// Makes the textures of a point, which is an index along each parameter, clamped to the grid. `ahead` lists the
  /// expected points of the next frames, as far as they are known, in the order of the frames. Throws
  /// Error(kEnvironment) if the images that the player waits for do not fit into memory.
  const FrameReport& prepare(const std::vector<double>& point, const std::vector<std::vector<double>>& ahead);

  /// Forgets all decoded images, so that the next frame measures the cost of a jump to any point.
  void forget_all();

  /// Returns the textures to add up at the point, and the mapping whose coordinates they use. The textures are valid
  /// until the next prepare().
  std::vector<const Texture*> layers(std::size_t object) const;
  std::size_t mapping(std::size_t object) const;
  /// Returns the world-to-clip matrix of a point. Between samples, the camera's position is interpolated linearly and
  /// its rotation by slerp.
  glm::dmat4 camera(const std::vector<double>& point) const;

  PlaybackCounts counts() const { return playback_.counts(); }
  std::vector<std::string> damaged() const { return playback_.damaged(); }

 private:
  struct Upload {
    Texture texture;
    int level = 0, row = 0;  // the next row to upload
  };
  struct LayerTexture {
    std::unique_ptr<Texture> texture;
    std::size_t mapping = 0;
    std::vector<std::pair<ImageKey, float>> images;  // images that the texture sums, with weights
    std::array<float, 3> offset{};
    bool is_made = false;
    std::optional<ImageKey> whole;  // a whole decoded texture, used in place of images
  };

  void reserve_memory();
  bool has_whole_textures() const { return settings_.playback.kind == DecodedKind::kTextures; }
  bool is_there(ImageKey key) const;
  Upload& begun_upload(ImageKey key, const DecodedImage& decoded);
  void upload(ImageKey key, std::size_t bytes_max);
  void upload_for(const std::vector<LayerNeed>& needs, bool all);
  bool is_drawable(std::size_t layer, const LayerNeed& need) const;
  void wait_for(std::vector<LayerNeed>& needs);
  void show(std::size_t layer, const LayerNeed& need);
  void make_texture(std::size_t layer, const LayerNeed& need, std::vector<std::pair<ImageKey, float>> images);

  const GlFunctions& gl_;
  PlayerSettings settings_;
  std::map<ImageKey, Upload> images_;
  FieldPlayback playback_;
  std::unique_ptr<LayerSum> sum_;       // null if has_whole_textures()
  std::vector<LayerTexture> textures_;  // one per layer
  std::size_t nearest_ = 0;             // the nearest sample
  FrameReport report_;
};

}  // namespace multum::gl
