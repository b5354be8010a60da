// SPDX-License-Identifier: Apache-2.0
// Compares filtering methods with the reference in pictures and motion. The methods are averaged normals, the engines'
// rules, the exported lobe (isotropic and anisotropic), and the lobes of a bake.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/delivery/export/export_job.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Grey sRGB pixels for display, and their errors.
struct StudyPicture {
  std::vector<std::uint8_t> grey;  // kFrameSide * kFrameSide pixels
  double error = 0.0;              // relative L1 error of the highlight
  double energy = 1.0;             // energy relative to the reference
};

/// Pictures from one distance. The first picture shows the reference, and the others show the models.
struct StudyDistance {
  double level;
  std::vector<StudyPicture> pictures;
};

/// The flicker of one model in one motion, over all frames.
struct StudyFlicker {
  double error = 0.0;  // relative L1 error
  // The sum over frames and pixels of |change of the model - change of the reference|, divided by the sum of the
  // reference. This value measures false and missing flicker per frame, and is 0 for the reference.
  double flicker = 0.0;
  double change = 0.0;  // the same sum with only |change of the model|
};

struct StudyMotion {
  std::string id;  // "zoom" or "turn"
  int frame_count = 0;
  double reference_change = 0.0;  // StudyFlicker::change of the reference
  std::vector<StudyFlicker> models;
  // The pixels, as [frame][picture][pixel]. The first picture is the reference, followed by the models.
  std::vector<std::vector<std::vector<std::uint8_t>>> frames;
};

struct SurfaceStudy {
  std::vector<std::string> ids, names;  // ids and names of the models
  std::vector<StudyDistance> distances;
  std::vector<StudyMotion> motions;
};

/// The finest level in the pictures. On finer levels, all methods give the same result.
constexpr int kStudyFirstLevel = 2;

/// Reads the job's source again, and fits isotropic and anisotropic lobes. Throws the same errors as export_file().
SurfaceStudy study_surface(const ExportJob& job, const std::string& scratch_folder, Device& device, Progress* progress);

}  // namespace multum
