// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/averages/sh_parts.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/asset/exr/exr_rows.h"

namespace multum {
namespace {

constexpr const char* kChannelNames[] = {"R", "G", "B", "A"};

// Names the channels of the part R, G, B and A. A part with fewer than four coefficients has fewer channels. The index
// of the first coefficient is 4 times the number in the name of the part.
BakedPart coefficient_part(const BakedHeader& header, int order, int part) {
  BakedPart made{fmt::format("sh.{:02}", part),
                 {},
                 header.first_level,
                 header.level_count() - header.first_level,
                 false,
                 fmt::format("R,G,B,A = coefficients {} and on of real spherical harmonics, l*l+l+m-1, l from 1, no "
                             "Condon-Shortley phase, +X right, +Y up, +Z out; data, not colour",
                             4 * part)};
  for (int c = 0; c < std::min(4, sh_coefficient_count(order) - 4 * part); ++c)
    made.channels.push_back({fmt::format("sh{:02}.Y.{}", part, kChannelNames[c]), vector_type(header.encoding)});
  return made;
}

}  // namespace

std::vector<BakedPart> sh_parts(const BakedHeader& header, int order) {
  std::vector<BakedPart> parts;
  for (int part = 0; part < sh_part_count(order); ++part) parts.push_back(coefficient_part(header, order, part));
  if (header.has_colours) parts.push_back(mean_colour_part(header));
  if (header.weight_count > 0) parts.push_back(mean_weights_part(header));
  return parts;
}

}  // namespace multum
