// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/averages/moment_parts.h"

#include "host/formats/asset/exr/exr_rows.h"

namespace multum {
namespace {

// maketx sorts its channels by these names.
constexpr const char* kSlopeNames[] = {"b0_h", "b1_dhds", "b2_dhdt", "b3_dhds2", "b4_dhdt2", "b5_dh2dsdt"};
constexpr const char* kNormalNames[] = {"normal.mean.X", "normal.mean.Y", "normal.mean.Z"};
constexpr char kSlopesText[] =
    "as maketx --bumpslopes: b1,b2 = E[dh/ds],E[dh/dt] = E[-x/z],E[-y/z] of normals +X right, +Y up, +Z out; b3,b4,b5 "
    "= "
    "E[b1*b1],E[b2*b2],E[b1*b2] of the finest; b0 = -1, no height; data, not colour";
constexpr char kNormalText[] = "X,Y,Z = mean unit normal, +X right, +Y up, +Z out; data, not colour";

}  // namespace

std::vector<MomentPart> moment_part_kinds(const BakedHeader& header) {
  using enum MomentPart;
  std::vector<MomentPart> kinds = {kSlopes, kNormal};
  if (header.has_colours) kinds.push_back(kColour);
  if (header.weight_count > 0) kinds.push_back(kWeights);
  return kinds;
}

std::vector<BakedPart> moment_parts(const BakedHeader& header) {
  using enum MomentPart;
  const int level_count = header.level_count() - header.first_level;
  const auto part = [&](const char* name, const auto& channel_names, Imf::PixelType type, const char* text) {
    BakedPart made{name, {}, header.first_level, level_count, false, text};
    for (const char* channel : channel_names) made.channels.push_back({channel, type});
    return made;
  };
  std::vector<BakedPart> parts;
  for (const MomentPart kind : moment_part_kinds(header)) switch (kind) {
      case kSlopes: parts.push_back(part("bumpslopes", kSlopeNames, vector_type(header.encoding), kSlopesText)); break;
      case kNormal: parts.push_back(part("normal", kNormalNames, vector_type(header.encoding), kNormalText)); break;
      case kColour: parts.push_back(mean_colour_part(header)); break;
      case kWeights: parts.push_back(mean_weights_part(header)); break;
    }
  return parts;
}

const float* moment_part_values(const MomentLevel& rows, MomentPart kind) {
  using enum MomentPart;
  switch (kind) {
    case kSlopes: return &rows.slopes[0].height;
    case kNormal: return &rows.normals[0].x;
    case kColour: return &rows.colours[0].x;
    case kWeights: break;
  }
  return rows.weights.data();
}

}  // namespace multum
