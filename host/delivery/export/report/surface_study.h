// SPDX-License-Identifier: Apache-2.0
// Compares ways to filter a surface by pictures and by motion: averaged normals, engines' rules, one lobe as exported,
// round and anisotropic, and the lobes of a bake, each beside the reference.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/delivery/export/export_job.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Grey pixels to show, sRGB, and what they are off by.
struct StudyPicture {
  std::vector<std::uint8_t> grey;  // kFrameSide * kFrameSide
  double error = 0.0;              // relative L1 of the highlight
  double energy = 1.0;             // over that of the reference
};

/// Pictures from one distance: of the reference, then of each model.
struct StudyDistance {
  double level;
  std::vector<StudyPicture> pictures;
};

/// Of one model in one motion, over all frames.
struct StudyFlicker {
  double error = 0.0;  // relative L1
  // Sum over frames and pixels of |change of the model - change of the reference|, over the sum of the reference: what
  // flickers, or fails to, a frame. 0 for the reference.
  double flicker = 0.0;
  double change = 0.0;  // the same of |change of the model| alone
};

struct StudyMotion {
  std::string id;  // "zoom", "turn"
  int frame_count = 0;
  double reference_change = 0.0;  // StudyFlicker::change of the reference
  std::vector<StudyFlicker> models;
  // [frame][picture][pixel]: the reference, then models.
  std::vector<std::vector<std::vector<std::uint8_t>>> frames;
};

struct SurfaceStudy {
  std::vector<std::string> ids, names;  // of models
  std::vector<StudyDistance> distances;
  std::vector<StudyMotion> motions;
};

/// Finest level that pictures show: nearer, all ways are alike.
constexpr int kStudyFirstLevel = 2;

/// Reads the job's source again, and fits round and anisotropic lobes. Throws as export_file() does.
SurfaceStudy study_surface(const ExportJob& job, const std::string& scratch_folder, Device& device, Progress* progress);

}  // namespace multum
