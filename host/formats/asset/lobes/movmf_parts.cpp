// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/lobes/movmf_parts.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/formats/asset/lobes/lobe_family.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

constexpr char kLobeWeightsText[] =
    "R,G,B,A = a*weights of basis BRDFs 0 to 3; a is in the lobe part of the same number; data, not colour";
constexpr char kLobeColourText[] = "R,G,B = a*linear RGB of the lobe; a is in the lobe part of the same number";

void add_weight_channels(const std::string& layer, const MovmfMipmap& header, BakedPart& part) {
  for (int k = 0; k < header.header.weight_count; ++k)
    part.channels.push_back({fmt::format("{}.{}", layer, "RGBA"[k]), colour_type(header.header.encoding)});
}

// Lists channels in the order in which OpenImageIO lists layers and their channels. The other parts have the same
// order.
MovmfPart finest_part(const MovmfMipmap& header) {
  const LobeFamily& family = lobe_family(header.header.representation);
  const char* const text = header.header.has_roughness ? family.finest_rough_text : family.finest_text;
  MovmfPart part{{"finest", {}, 0, 1, true, text}, MovmfPartKind::kFinest, 0};
  if (header.has_colours())
    for (const char* name : {"finest.albedo.R", "finest.albedo.G", "finest.albedo.B"})
      part.channels.push_back({name, colour_type(header.header.encoding)});
  part.channels.push_back({"finest.lobe.X", Imf::HALF});
  for (const char* name : {"finest.normalX.X", "finest.normalY.X"})
    part.channels.push_back({name, vector_type(header.header.encoding)});
  if (header.header.has_roughness)
    part.channels.push_back({family.finest_rough_channel, vector_type(header.header.encoding)});
  add_weight_channels("finest.weights", header, part);
  return part;
}

}  // namespace

const float* MovmfPart::values(const MovmfLevel& rows) const {
  const auto index = static_cast<std::size_t>(lobe);
  if (kind == MovmfPartKind::kWeights) return rows.weights[index].data();
  return kind == MovmfPartKind::kColour ? &rows.colours[index][0].x : &rows.lobes[index][0].x;
}

float* MovmfPart::values(MovmfLevel& rows) const {
  return const_cast<float*>(values(static_cast<const MovmfLevel&>(rows)));
}

std::vector<MovmfPart> movmf_parts(const MovmfMipmap& header) {
  std::vector<MovmfPart> parts;
  if (header.header.first_level == 0) parts.push_back(finest_part(header));
  const int first_level = std::max(1, header.header.first_level);
  const int level_count = static_cast<int>(header.levels.size()) - first_level;
  if (level_count <= 0) return parts;
  const LobeFamily& family = lobe_family(header.header.representation);
  for (int j = 0; j < header.lobe_count(); ++j) {
    MovmfPart part{
        {fmt::format("lobe.{}", j), {}, first_level, level_count, false, family.lobe_text}, MovmfPartKind::kLobe, j};
    for (const char* channel : {"R", "G", "B", "A"})
      part.channels.push_back(
          {fmt::format("lobe{}.{}.{}", j, family.layer, channel), vector_type(header.header.encoding)});
    parts.push_back(std::move(part));
  }
  for (int j = 0; header.has_colours() && j < header.lobe_count(); ++j) {
    MovmfPart part{
        {fmt::format("colour.{}", j), {}, first_level, level_count, false, kLobeColourText}, MovmfPartKind::kColour, j};
    for (const char* channel : {"R", "G", "B"})
      part.channels.push_back({fmt::format("colour{}.albedo.{}", j, channel), colour_type(header.header.encoding)});
    parts.push_back(std::move(part));
  }
  for (int j = 0; header.header.weight_count > 0 && j < header.lobe_count(); ++j) {
    MovmfPart part{{fmt::format("weights.{}", j), {}, first_level, level_count, false, kLobeWeightsText},
                   MovmfPartKind::kWeights,
                   j};
    add_weight_channels(fmt::format("weights{}.blend", j), header, part);
    parts.push_back(std::move(part));
  }
  return parts;
}

void interleave(const MovmfFinest& rows, std::size_t first_texel, std::size_t count, float* values) {
  const std::size_t weight_count = rows.weight_count();
  for (std::size_t i = first_texel; i < first_texel + count; ++i) {
    if (!rows.colours.empty())
      for (int c = 0; c < 3; ++c) *values++ = rows.colours[i][c];
    *values++ = static_cast<float>(rows.lobe[i]);
    *values++ = rows.normals[i].x;
    *values++ = rows.normals[i].y;
    if (rows.has_roughness) *values++ = rows.normals[i].z;
    for (std::size_t k = 0; k < weight_count; ++k) *values++ = rows.weights[i * weight_count + k];
  }
}

std::string movmf_content_hash(const MovmfMipmap& mipmap, int threads) {
  const std::vector<MovmfPart> parts = movmf_parts(mipmap);
  struct PartLevel {
    const MovmfPart* part;
    int level;
  };
  std::vector<PartLevel> items;
  for (const MovmfPart& part : parts)
    for (int l = 0; l < part.level_count; ++l) items.push_back({&part, part.first_level + l});
  std::vector<std::string> digests(items.size());
  for_each_item(static_cast<int>(items.size()), threads, [&](int item) {
    const auto [part, l] = items[static_cast<std::size_t>(item)];
    const MovmfLevel& level = mipmap.levels[static_cast<std::size_t>(l)];
    const std::size_t channels = part->channels.size();
    ContentHash hash;
    if (part->kind == MovmfPartKind::kFinest) {
      std::vector<float> values;
      for (int row = 0; row < level.height; row += kRowsPerBand) {
        const MovmfFinest rows = finest_of(level, row, std::min(kRowsPerBand, level.height - row),
                                           mipmap.header.representation, mipmap.header.has_roughness);
        values.resize(rows.normals.size() * channels);
        interleave(rows, 0, rows.normals.size(), values.data());
        hash.update(values.data(), values.size() * sizeof(float));
      }
    } else {
      hash.update(part->values(level), texel_count(level.width, level.height) * channels * sizeof(float));
    }
    digests[static_cast<std::size_t>(item)] = hash.finish();
  });
  ContentHash all;
  for (const std::string& digest : digests) all.update(digest);
  return all.finish();
}

}  // namespace multum
