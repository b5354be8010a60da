// SPDX-License-Identifier: Apache-2.0
#include "host/asset/movmf_header.h"

#include <ImfFloatAttribute.h>
#include <ImfIntAttribute.h>
#include <fmt/format.h>

namespace multum {

std::vector<Imf::Header> make_headers(const MovmfMipmap& header, const std::vector<MovmfPart>& parts,
                                      const BakedWriteOptions& options) {
  std::vector<Imf::Header> headers = make_baked_headers(header_of(header), {parts.begin(), parts.end()}, options);
  for (Imf::Header& one : headers) {
    one.insert("multum:lobeCount", Imf::IntAttribute(header.lobe_count()));
    one.insert("multum:kappaMax", Imf::FloatAttribute(storage_kappa_max(header.representation, header.encoding)));
  }
  return headers;
}

MovmfMipmap parse_header(const Imf::Header& header, const std::string& path) {
  BakedHeader baked = parse_baked_header(header, path);
  if (!holds_lobes(baked.representation)) baked = parse_baked_header(header, Representation::kMovmf, path);  // refuses
  const int lobe_count = int_attribute(header, "multum:lobeCount", path);
  if (lobe_count < 1 || lobe_count > kLobeCountMax)
    refuse_file(path, fmt::format("{} lobes", lobe_count), fmt::format("1 to {}", kLobeCountMax));
  MovmfMipmap mipmap;
  mipmap.representation = baked.representation;
  mipmap.encoding = baked.encoding;
  mipmap.wrap_s = baked.wrap_s;
  mipmap.wrap_t = baked.wrap_t;
  mipmap.provenance = baked.provenance;
  mipmap.first_level = baked.first_level;
  mipmap.weight_count = baked.weight_count;
  mipmap.has_roughness = baked.has_roughness;
  mipmap.mean_cosine = baked.mean_cosine;
  for (int l = 0; l < baked.level_count(); ++l) {
    MovmfLevel level;
    level.width = mip_level_size(baked.width, l);
    level.height = mip_level_size(baked.height, l);
    level.lobes.resize(static_cast<std::size_t>(lobe_count));
    if (baked.has_colours) level.colours.resize(static_cast<std::size_t>(lobe_count));
    if (baked.weight_count > 0) level.weights.resize(static_cast<std::size_t>(lobe_count));
    mipmap.levels.push_back(std::move(level));
  }
  return mipmap;
}

}  // namespace multum
