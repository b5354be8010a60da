// SPDX-License-Identifier: Apache-2.0
// Launches movmf_shade for one lobe.
#pragma once

#include <string>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/formats/opencl/device.h"
#include "host/foundation/base/source_edit.h"
#include "kernels/shared/highlight.h"

namespace multum {

/// Shades the lobe (a r, a), including the amplitude. If s >= 1, the unit vectors in `directions` are half vectors for
/// Blinn-Phong with exponent s. If s is 0, they are lights for Lambert. If `planar` is true, the lobe is a Gaussian (a
/// mu, a (2 sigma^2 + |mu|^2), a). The w of directions is unused.
std::vector<double> shade_lobe(Device& device, const glm::vec4& lobe, float s, const std::vector<glm::vec4>& directions,
                               bool planar = false);
/// Shades a highlight of any kind at the given half vectors.
std::vector<double> shade_lobe(Device& device, const glm::vec4& lobe, const MultumHighlight& highlight,
                               const std::vector<glm::vec4>& directions);

/// Returns an edit of the kernel's text.
SourceEdit shade_edit(const std::string& text, const std::string& replacement);

/// Returns the angle between mu and the kernel's vector w. The length of w is not exactly 1, so the function computes
/// the angle from |mu - w|^2 / 2 = 1 - cos.
double angle_seen(const glm::dvec3& mu, const glm::vec4& w);

}  // namespace multum
