// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/lobes/movmf_header.h"

#include <ImfFloatAttribute.h>
#include <ImfIntAttribute.h>
#include <fmt/format.h>

#include "host/formats/asset/lobes/lobe_family.h"

namespace multum {

std::vector<Imf::Header> make_headers(const MovmfMipmap& header, const std::vector<MovmfPart>& parts,
                                      const BakedWriteOptions& options) {
  std::vector<Imf::Header> headers = make_baked_headers(full_header(header), {parts.begin(), parts.end()}, options);
  for (Imf::Header& one : headers) {
    one.insert("multum:lobeCount", Imf::IntAttribute(header.lobe_count()));
    one.insert("multum:kappaMax",
               Imf::FloatAttribute(lobe_family(header.header.representation).kappa_max(header.header.encoding)));
  }
  return headers;
}

MovmfMipmap parse_header(const Imf::Header& header, const std::string& path) {
  BakedHeader baked = parse_baked_header(header, path);
  if (!holds_lobes(baked.representation))
    baked = parse_baked_header(header, default_representation(), path);  // this call rejects the file
  const int lobe_count = int_attribute(header, "multum:lobeCount", path);
  if (lobe_count < 1 || lobe_count > kLobeCountMax)
    refuse_file(path, fmt::format("{} lobes", lobe_count), fmt::format("1 to {}", kLobeCountMax));
  return empty_movmf_mipmap(baked, lobe_count);
}

}  // namespace multum
