// SPDX-License-Identifier: Apache-2.0
#include "tools/multum/info_json.h"

#include <filesystem>

#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/asset/gpu_bytes.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/asset/pyramid/pyramid_file.h"
#include "host/formats/asset/representation.h"

namespace multum {
namespace {

// Parses an attribute that holds JSON. Returns any other text as a string, and null for an empty text.
OrderedJson attribute_json(const std::string& text) {
  if (text.empty()) return nullptr;
  OrderedJson json = OrderedJson::parse(text, nullptr, false);
  return json.is_discarded() ? OrderedJson(text) : json;
}

OrderedJson source_json(const BakedProvenance& from) {
  if (from.source_hash.empty()) return nullptr;
  OrderedJson json = {{"name", path_json(from.source_name)}, {"sha256", from.file_hash()}};
  if (!from.source_tiles.empty()) json["set_sha256"] = from.source_hash;
  return json;
}

OrderedJson header_json(const std::string& path, const std::string& representation, const BakedHeader& file) {
  return {{"file", path_json(path)},
          {"representation", representation},
          {"width", file.width},
          {"height", file.height},
          {"levels", file.level_count()},
          {"first_level", file.first_level},
          {"wrap_s", wrap_mode_name(file.wrap_s)},
          {"wrap_t", wrap_mode_name(file.wrap_t)},
          {"encoding", storage_encoding_name(file.encoding)},
          {"bytes", std::filesystem::file_size(path)},
          {"source", source_json(file.provenance)},
          {"settings", attribute_json(file.provenance.settings)},
          {"checksum", file.provenance.content_hash},
          {"software", file.provenance.software}};
}

}  // namespace

OrderedJson baked_file_json(const std::string& path) {
  if (is_pyramid_file(path)) {
    const PyramidHeader pyramid = read_pyramid_header(path);
    OrderedJson json = header_json(path, "pyramid", pyramid.map);
    json["contents"] = pyramid_kind_name(pyramid.kind);
    return json;
  }
  const BakedHeader file = read_baked_header(path);
  const RepresentationInfo& info = representation_info(file.representation);
  OrderedJson json = header_json(path, info.option, file);
  if (info.lobes != nullptr) json["lobes"] = read_movmf_header(path).lobe_count();
  if (info.has_order) json["sh_order"] = read_sh_header(path).order;
  json["has_colours"] = file.has_colours;
  json["weights"] = file.weight_count;
  json["has_roughness"] = file.has_roughness;
  if (file.has_roughness) json["mean_cosine"] = file.mean_cosine;
  json["gpu_bytes"] = baked_gpu_bytes(path);
  json["default_gpu_bytes"] = default_gpu_bytes(file.width, file.height);
  json["reading"] = attribute_json(file.provenance.reading);
  json["measured_error"] = attribute_json(file.provenance.measured_error);
  return json;
}

}  // namespace multum
