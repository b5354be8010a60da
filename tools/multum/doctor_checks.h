// SPDX-License-Identifier: Apache-2.0
// Declares the checks of the machine that `multum doctor` runs. Each check reports its findings and, after a failure,
// what the user should do.
#pragma once

#include <string>
#include <vector>

#include "host/formats/opencl/kernel_caches.h"

namespace multum {

enum class DoctorState {
  kFine,     // works
  kAbsent,   // an optional part is not installed or is not running
  kWarning,  // works, but more slowly or with fewer resources than expected
  kFailure,  // at least one command cannot work
};

/// Returns "ok", "absent", "warning" or "failure".
const char* doctor_state_name(DoctorState state);

struct DoctorFinding {
  DoctorState state;
  std::string area;    // such as "OpenCL"
  std::string found;   // the finding, in one line
  std::string advice;  // what the user should do; empty if there is nothing to do
};
using DoctorFindings = std::vector<DoctorFinding>;

struct DoctorSettings {
  std::string device;         // value of --device; empty for the default device
  std::string viewer;         // path of the program multum-view
  KernelCacheFolders caches;  // folders that environment variables name
};

/// Checks the processors and the memory that this process may use.
DoctorFindings machine_findings();

/// Checks the OpenCL devices, and checks that --device names one of them.
DoctorFindings device_findings(const DoctorSettings& settings);

/// Checks the access rights and sizes of the folders of compiled kernels. Call this function after device_findings().
DoctorFindings cache_findings(const KernelCacheFolders& folders);

/// Checks the program that decodes images and meshes, and checks whether the operating system's kernel can confine it.
DoctorFindings decoder_findings();

/// Checks the free space and access rights of the current folder and of the folder for temporary files.
DoctorFindings disk_findings();

/// Makes a map of 32 x 32 texels in `folder`, bakes it with this program, and draws the result with each GL context
/// that multum-view supports. Returns findings for the areas "bake" and "GL". `folder` must be empty and writable.
DoctorFindings trial_findings(const DoctorSettings& settings, const std::string& folder);

/// Checks optional programs: Node.js with ktx2-encoder, and ffmpeg.
DoctorFindings program_findings(const std::string& folder);

}  // namespace multum
