// SPDX-License-Identifier: Apache-2.0
// Reads a folder written by `multum infer` for packing: its description, its chunks, and the weights of coding errors
// in drawn frames. Textures are read on request, because the textures of a field may not all fit into memory.
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

/// The weights of errors in an object's textures.
struct ObjectWeights {
  std::vector<std::size_t> pose_of_sample;
  std::vector<std::vector<std::vector<float>>> shares;  // [sample][layer][cell]: results of layer_shares()
  std::map<CoderAndSide, PoseEnergies> energies;
  double pixels = 0.0;  // number of covered pixels in all samples
};

/// The textures of one layer of an object over one block of the parameters.
struct ChunkToCode {
  std::size_t layer = 0, block = 0;  // indices in the description
  std::size_t object = 0, layer_of_object = 0;
  std::size_t width = 1, height = 1;              // texels
  std::vector<std::size_t> sizes;                 // samples along each dimension
  std::vector<std::string> textures;              // [chunk sample], files in the folder; "" means that the texture is
                                                  // invisible
  std::vector<std::vector<std::size_t>> seen_at;  // [chunk sample], the field's samples that draw it
  std::vector<float> texel_weights;               // as in ChunkSource
  const ObjectWeights* weights = nullptr;

  /// Returns the memory that the chunk's textures take in ChunkSource.
  std::uint64_t texture_bytes() const { return std::uint64_t{12} * width * height * textures.size(); }
};

struct FieldSource {
  std::string folder;
  FieldDescription description;
  std::vector<std::unique_ptr<ObjectWeights>> weights;  // weights of all objects
  std::vector<ChunkToCode> chunks;
  double values = 0.0;   // number of values in all frames, three per pixel
  std::string checksum;  // checksum of all data that was read
};

struct FieldSourceSettings {
  std::string folder;                  // written by multum infer
  std::string output;                  // file to write; the path to the scene file is relative to it
  bool has_absolute_geometry = false;  // store the scene file's absolute path instead
  int block = 8;                       // most samples of a chunk along a parameter
  bool stagger = false;                // let the blocks of different objects begin at different samples
  std::vector<CoderAndSide> coders;    // coders whose coefficients are weighted
  int threads = 0;
};

/// Reads the whole folder. At any time, each thread holds the matrices of only a few poses and the textures of one
/// sample. Throws Error(kInput), which names the file and its fault. Throws Cancelled.
FieldSource read_field_source(const FieldSourceSettings& settings, Progress* progress);

/// Reads a chunk's gamma-coded textures. An invisible texture is a copy of a neighbouring sample's texture. Throws
/// Error(kInput), for example if a file has changed.
ChunkSource read_chunk_source(const FieldSource& field, const ChunkToCode& chunk);

}  // namespace multum
