// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/baked_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/formats/asset/baked_reader.h"

namespace multum {

const RepresentationInfo& representation_of(const std::string& path) {
  const BakedReader file(path, 1);
  BakedHeader header;
  file.guarded([&] { header = parse_baked_header(file.file().header(0), path); });
  return representation_info(header.representation);
}

int BakedHeader::level_count() const { return mip_level_count(width, height); }

int BakedHeader::format_version() const {
  return representation_info(representation).version + (weight_count > 0 || has_roughness ? 1 : 0);
}

int mip_level_count(int width, int height) {
  int count = 1;
  for (int side = std::max(width, height); side > 1; side >>= 1) ++count;
  return count;
}

std::string levels_text(int first_level, int level_count) {
  if (first_level == 0) return fmt::format("{} levels", level_count);
  const int coarsest = level_count - 1;
  if (first_level == coarsest) return fmt::format("level {} of 0 to {}", coarsest, coarsest);
  return fmt::format("levels {} to {} of 0 to {}", first_level, coarsest, coarsest);
}

std::string materials_text(const BakedHeader& header) {
  std::vector<std::string> parts;
  if (header.has_colours) parts.emplace_back("colours");
  if (header.weight_count > 0) parts.push_back(fmt::format("{} weights", header.weight_count));
  if (header.has_roughness) parts.emplace_back("roughness");
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i)
    text += (i == 0 ? " with " : i + 1 == parts.size() ? " and " : ", ") + parts[i];
  return text;
}

BakedHeader read_baked_header(const std::string& path) { return representation_of(path).read_header(path); }

std::string baked_surface(const BakedHeader& header) {
  const nlohmann::json settings = nlohmann::json::parse(header.provenance.settings, nullptr, false);
  return settings.is_object() ? settings.value("surface", "texels") : "texels";
}

}  // namespace multum
