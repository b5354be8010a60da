// SPDX-License-Identifier: Apache-2.0
// Names the files of a folder written by `multum infer`. These are the filter matrix of an object at a sample, and all
// files that packing reads.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/fields/inferred/inferred_texture.h"

namespace multum {

/// Groups of samples in which an object has the same pose and texture coordinates. The samples of a group share the
/// object's filter matrix.
struct ObjectPoses {
  std::vector<std::size_t> first_samples;  // first sample of each pose
  std::vector<std::size_t> of_sample;      // index into first_samples
};

ObjectPoses object_poses(const InferredManifest& field, const InferredObject& object);

/// Returns the matrix file of an object's pose, named by its first sample, relative to the manifest.
std::string matrix_name(const InferredSample& sample, const InferredObject& object);

/// Returns the path of the manifest's scene file without opening it. The file's name is relative to `folder`.
std::string geometry_path(const InferredManifest& field, const std::string& folder);

/// Returns the same path after checks. Throws Error(kInput) if the file cannot be read, is not a regular file, or is
/// not the scene that textures were inferred for.
std::string checked_geometry(const InferredManifest& field, const std::string& folder);

/// Returns each file once. The files are the textures and matrices of the manifest's objects, its scene file, and the
/// report of `multum infer` if present. Paths are absolute if the manifest's path is. Opens only the manifest. Throws
/// Error(kInput) if the manifest cannot be read.
std::vector<std::string> inferred_field_files(const std::string& manifest_path);

}  // namespace multum
