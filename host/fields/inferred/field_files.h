// SPDX-License-Identifier: Apache-2.0
// Names the files of a folder that multum infer wrote: which filter matrix an object has at a sample, and all files
// that who packs the field reads.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/fields/inferred/inferred_texture.h"

namespace multum {

/// Samples that see an object alike, from one place and with the same texture coordinates, share its filter matrix.
struct ObjectPoses {
  std::vector<std::size_t> first_samples;  // of each pose
  std::vector<std::size_t> of_sample;      // index into first_samples
};

ObjectPoses object_poses(const InferredManifest& field, const InferredObject& object);

/// Of a pose of the object, by its first sample; relative to the manifest.
std::string matrix_name(const InferredSample& sample, const InferredObject& object);

/// Path of the manifest's scene file, which is not looked at; `folder` is what its name is relative to.
std::string geometry_path(const InferredManifest& field, const std::string& folder);

/// The same. Throws Error(kInput) where it cannot be read, is no regular file, or is not the one that textures were
/// inferred for.
std::string checked_geometry(const InferredManifest& field, const std::string& folder);

/// Textures and matrices of the manifest's objects, its scene file, and the report of `multum infer` where there is
/// one, each once: absolute where the manifest is. The files are not looked at. Throws Error(kInput) when it cannot be
/// read.
std::vector<std::string> inferred_field_files(const std::string& manifest_path);

}  // namespace multum
