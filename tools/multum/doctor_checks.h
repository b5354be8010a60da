// SPDX-License-Identifier: Apache-2.0
// Checks of the machine that `multum doctor` runs. Each says what it found and, if something is wrong, what to do.
#pragma once

#include <string>
#include <vector>

#include "host/formats/opencl/kernel_caches.h"

namespace multum {

enum class DoctorState {
  kFine,     // works
  kAbsent,   // optional and not installed, or not running
  kWarning,  // works, but slower or with less than expected
  kFailure,  // some command cannot work
};

/// "ok", "absent", "warning" or "failure".
const char* doctor_state_name(DoctorState state);

struct DoctorFinding {
  DoctorState state;
  std::string area;    // such as "OpenCL"
  std::string found;   // one line
  std::string advice;  // what to do; empty if nothing is to be done
};
using DoctorFindings = std::vector<DoctorFinding>;

struct DoctorSettings {
  std::string device;         // as --device; empty: the default device
  std::string viewer;         // program multum-view
  KernelCacheFolders caches;  // as the environment names them
};

/// Processors and memory that this process may use.
DoctorFindings machine_findings();

/// OpenCL devices, and whether --device names one of them.
DoctorFindings device_findings(const DoctorSettings& settings);

/// Folders of compiled kernels: whether they can be written, and their sizes. Call after device_findings().
DoctorFindings cache_findings(const KernelCacheFolders& folders);

/// The program that decodes images and meshes, and whether the kernel can confine it.
DoctorFindings decoder_findings();

/// Free space and rights of the current folder and of the folder for temporary files.
DoctorFindings disk_findings();

/// Makes a map of 32 x 32 texels in `folder`, bakes it by this program, and draws the result by each GL context that
/// multum-view knows. Findings of areas "bake" and "GL". `folder` is empty and can be written.
DoctorFindings trial_findings(const DoctorSettings& settings, const std::string& folder);

/// Optional programs: Node.js with ktx2-encoder, and ffmpeg.
DoctorFindings program_findings(const std::string& folder);

}  // namespace multum
