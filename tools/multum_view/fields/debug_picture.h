// SPDX-License-Identifier: Apache-2.0
// Draws what a playback did, a column of pixels a frame: for each layer whether its images were there in time, what
// was decoded, and how full the memory was.
//
//      a band a layer      green: all of its images; above it, yellow: the share that was late; red: the texture of a
//                          frame before; black: nothing to draw
//      decoding            blue: images that were decoded since the frame before, a pixel each; violet: chunks
//      memory              grey, of the band's height; its peak so far a line
#pragma once

#include <cstddef>
#include <vector>

#include "runtime_gl/animation/field_player.h"
#include "runtime_gl/gl/framebuffer.h"

namespace multum {

struct PlayedFrame {
  std::vector<gl::LayerReport> layers;
  std::size_t images_decoded = 0, chunks_decoded = 0;  // since the frame before
  std::size_t bytes = 0, bytes_most = 0;
  double decoding_seconds = 0.0;  // of processors, since the frame before
};

/// Linear colours. Frames are four pixels wide, or less where the picture would be wider than 16384.
gl::FloatImage debug_picture(const std::vector<PlayedFrame>& frames, std::size_t memory_max);

}  // namespace multum
