// SPDX-License-Identifier: Apache-2.0
// Plays a packed field: a program asks for a point of the parameter space each frame, and gets the textures of every
// object there, from what is decoded by then. Hakura et al. 2000, section 5: images are decoded as they are needed and
// cached (host/fields/playback), and added up by the GPU. Where all of a single sample's are waited for, workers add up
// its coefficients instead, and whole textures are cached: one transform for all images, and nothing is left for the
// GPU to do. Textures lie on exact geometry, so a camera may be anywhere near its samples; how near,
// docs/contributing/ALGORITHMS.md says.
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
  PlaybackSettings playback;                       // kind is chosen here
  std::size_t upload_max = std::size_t{16} << 20;  // bytes to the GPU a frame, at least 2^16
  bool is_linear = false;  // between samples: mixed, gamma-coded, linearly along each parameter; else the nearest
  bool waits = false;      // for all that a frame needs; else for the coarsest image of each texture alone
};

/// A layer in a frame.
struct LayerReport {
  bool is_drawn = false;    // there is something to draw
  bool is_old = false;      // nothing of this point's is there: the texture drawn before stays
  std::size_t needed = 0;   // images that the texture is the sum of
  std::size_t missing = 0;  // of them, those that were not there in time
};

struct FrameReport {
  std::vector<LayerReport> layers;  // of the description
  std::size_t uploaded_bytes = 0;
  std::size_t textures_made = 0;
  double wait_seconds = 0.0, upload_seconds = 0.0, sum_seconds = 0.0;
};

class FieldPlayer {
 public:
  /// Of a packed file. Throws Error.
  FieldPlayer(const GlFunctions& gl, const std::string& path, const PlayerSettings& settings);

  const FieldDescription& description() const { return playback_.description(); }

  /// Makes the textures of a point (by index along each parameter, clamped to the grid). `ahead`: where the next frames
  /// will be, as far as that is known, the next first. Throws Error(kEnvironment) where memory does not suffice for
  /// what it waits for.
  const FrameReport& prepare(const std::vector<double>& point, const std::vector<std::vector<double>>& ahead);

  /// Nothing is decoded any more: what the next frame takes is what a jump to anywhere takes.
  void forget_all();

  /// Of the point: the textures to be added up, and the mapping whose coordinates they have. Valid until the next
  /// prepare().
  std::vector<const Texture*> layers(std::size_t object) const;
  std::size_t mapping(std::size_t object) const;
  /// World to clip at a point: between samples the camera's position goes linearly, its rotation by slerp.
  glm::dmat4 camera(const std::vector<double>& point) const;

  PlaybackCounts counts() const { return playback_.counts(); }
  std::vector<std::string> damaged() const { return playback_.damaged(); }

 private:
  struct Upload {
    Texture texture;
    int level = 0, row = 0;  // the next that is to come
  };
  struct LayerTexture {
    std::unique_ptr<Texture> texture;
    std::size_t mapping = 0;
    std::vector<std::pair<ImageKey, float>> images;  // that it is the sum of
    std::array<float, 3> offset{};
    bool is_made = false;
    std::optional<ImageKey> whole;  // in their place: a whole texture, as it was decoded
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
  std::unique_ptr<LayerSum> sum_;       // null: has_whole_textures()
  std::vector<LayerTexture> textures_;  // of each layer
  std::size_t nearest_ = 0;             // sample
  FrameReport report_;
};

}  // namespace multum::gl
