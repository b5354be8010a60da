// SPDX-License-Identifier: Apache-2.0
// Draws the course of a playback, with one column of pixels per frame. The picture shows for each layer whether its
// images were ready in time. It also shows which data was decoded and how full the memory was.
//
//      one band per layer  green: all images were ready; above it, yellow: the share that was late; red: the texture of
//                          an earlier frame; black: nothing to draw
//      decoding            blue: images decoded since the previous frame, one pixel each; violet: chunks
//      memory              grey, relative to the band's height; a line marks the highest value so far
#pragma once

#include <cstddef>
#include <vector>

#include "runtime_gl/animation/field_player.h"
#include "runtime_gl/gl/framebuffer.h"

namespace multum {

struct PlayedFrame {
  std::vector<gl::LayerReport> layers;
  std::size_t images_decoded = 0, chunks_decoded = 0;  // since the previous frame
  std::size_t bytes = 0, bytes_most = 0;
  double decoding_seconds = 0.0;  // processor time since the previous frame
};

/// Returns linear colours. A frame is four pixels wide, or narrower if the picture would otherwise be wider than 16384
/// pixels.
gl::FloatImage debug_picture(const std::vector<PlayedFrame>& frames, std::size_t memory_max);

}  // namespace multum
