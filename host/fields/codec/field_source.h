// SPDX-License-Identifier: Apache-2.0
// Reads a folder that multum infer wrote for packing: its description, its chunks, and what weighs their errors in
// drawn frames. Textures are read when they are asked for: not all of a field's fit in memory.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/fields/codec/chunk_choice.h"
#include "host/fields/codec/field_description.h"
#include "host/fields/codec/pose_energies.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// What weighs the errors of an object's textures.
struct ObjectWeights {
  std::vector<std::size_t> pose_of_sample;
  std::vector<std::vector<std::vector<float>>> shares;  // [sample][layer][cell]: layer_shares
  std::map<CoderAndSide, PoseEnergies> energies;
  double pixels = 0.0;  // covered, of all samples
};

/// The textures of one layer of an object over one block of the parameters.
struct ChunkToCode {
  std::size_t layer = 0, block = 0;  // of the description
  std::size_t object = 0, layer_of_object = 0;
  std::size_t width = 1, height = 1;              // texels
  std::vector<std::size_t> sizes;                 // samples along each dimension
  std::vector<std::string> textures;              // [chunk sample], files of the folder; "": nobody draws it
  std::vector<std::vector<std::size_t>> seen_at;  // [chunk sample], the field's samples that draw it
  std::vector<float> texel_weights;               // as ChunkSource has them
  const ObjectWeights* weights = nullptr;

  /// Of its textures as ChunkSource has them.
  std::uint64_t texture_bytes() const { return std::uint64_t{12} * width * height * textures.size(); }
};

struct FieldSource {
  std::string folder;
  FieldDescription description;
  std::vector<std::unique_ptr<ObjectWeights>> weights;  // of objects
  std::vector<ChunkToCode> chunks;
  double values = 0.0;   // of all frames, three a pixel
  std::string checksum;  // of everything that was read
};

struct FieldSourceSettings {
  std::string folder;                  // that multum infer wrote
  std::string output;                  // file to be written, for the way from there to the scene file
  bool has_absolute_geometry = false;  // the scene file's path is noted whole instead
  int block = 8;                       // samples of a chunk along a parameter, at most
  bool stagger = false;                // objects' blocks begin at different samples
  std::vector<CoderAndSide> coders;    // whose coefficients are weighed
  int threads = 0;
};

/// Reads everything. A thread holds the matrices of a few poses, and a sample's textures, at a time. Throws
/// Error(kInput) naming the file and what is wrong; Cancelled.
FieldSource read_field_source(const FieldSourceSettings& settings, Progress* progress);

/// Reads a chunk's textures, gamma-coded; what nobody draws is a neighbour's. Throws Error(kInput), also where a file
/// is not what it was.
ChunkSource read_chunk_source(const FieldSource& field, const ChunkToCode& chunk);

}  // namespace multum
