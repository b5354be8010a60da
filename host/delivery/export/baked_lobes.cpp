// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/baked_lobes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "host/formats/asset/baked_file.h"
#include "host/formats/asset/lobes/lobe_family.h"
#include "host/formats/brdf/ggx_lobe_specular.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

[[noreturn]] void refuse_baked(const std::string& path, const std::string& found, const std::string& expected) {
  throw Error(ErrorCode::kInput, fmt::format("{}: {}; expected {}", path, found, expected));
}

void check_has_lobes(const std::string& path, const BakedHeader& header) {
  if (!holds_lobes(header.representation))
    refuse_baked(path, fmt::format("holds {}", representation_info(header.representation).name),
                 "a file of lobes (from multum bake --ndf vmf or gmm), or the map that was baked");
  if (header.has_roughness)
    refuse_baked(path, "has a roughness map baked into the lengths of its normals, which cannot be undone",
                 "a file baked without --roughness, or the map that was baked");
}

// Returns a stored normal of level 0, scaled to length 1.
glm::vec3 unit_normal(const glm::vec3& stored, Representation representation) {
  const glm::vec3 normal = lobe_family(representation).normal_of_finest(stored, false);
  return normal / glm::length(normal);
}

}  // namespace

bool is_baked_name(const std::string& path) { return path.ends_with(".ndf.exr"); }

NormalMapRows read_baked_normals(const std::string& path, const SpillPolicy& spill, Progress* progress) {
  const BakedHeader header = read_baked_header(path);
  check_has_lobes(path, header);
  if (header.first_level > 0)
    refuse_baked(
        path,
        fmt::format("holds no levels finer than {}, so it does not contain the map's normals", header.first_level),
        "a file of multum bake --first-level 0, or the map that was baked");
  MovmfReader reader(path);
  NormalMapRows map{make_plane_store(header.width, header.height, spill), {}};
  map.report.format = fmt::format("baked file, {} lobes per texel, {}", reader.header().lobe_count(),
                                  storage_encoding_name(header.encoding));
  map.report.encoding = "normals of level 0";
  map.report.encoding_reason =
      fmt::format("each texel stores the normal of {} at the same position", header.provenance.source_name);
  map.report.wrap_s = header.wrap_s;
  map.report.wrap_t = header.wrap_t;
  std::vector<float> x, y, z;
  for (int row = 0; row < header.height; row += reader.tile_size()) {
    progress_advance(progress, 0);
    const int count = std::min(reader.tile_size(), header.height - row);
    const MovmfFinest finest = reader.read_finest(row, count);
    x.resize(finest.normals.size());
    y.resize(x.size());
    z.resize(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const glm::vec3 n = unit_normal(finest.normals[i], header.representation);
      if (!std::isfinite(n.x) || !std::isfinite(n.y) || !std::isfinite(n.z))
        refuse_baked(path,
                     fmt::format("the normal at texel ({}, {}) of level 0 has no direction", i % size_of(header.width),
                                 size_of(row) + i / size_of(header.width)),
                     "finite normals (multum verify lists other damage)");
      x[i] = n.x, y[i] = n.y, z[i] = n.z;
    }
    map.normals.write_rows(row, count, {x.data(), y.data(), z.data()});
  }
  return map;
}

BakedLobes::BakedLobes(const std::string& path, const std::vector<int>& levels) : reader_(path) {
  const BakedHeader& header = reader_.header().header;
  check_has_lobes(path, header);
  const RepresentationInfo& info = representation_info(header.representation);
  if (!info.has_kappa)
    refuse_baked(path, fmt::format("holds {}, which cannot be shaded by the GGX formula", info.contents),
                 "vMF lobes (from multum bake --ndf vmf)");
  for (const int level : levels)
    if (level < header.first_level)
      refuse_baked(path, fmt::format("holds no levels finer than {}", header.first_level),
                   fmt::format("a file that contains level {}, whose error is measured", level));
}

std::string BakedLobes::name() const {
  const int count = reader_.header().lobe_count();
  return count == 1 ? "1 baked lobe" : fmt::format("{} baked lobes", count);
}

std::vector<glm::dvec4> BakedLobes::texel(int level, int x, int y) {
  const MovmfLevel row = reader_.read_level(level, y, 1);
  std::vector<glm::dvec4> lobes;
  for (const std::vector<glm::vec4>& lobe : row.lobes) lobes.emplace_back(lobe[size_of(x)]);
  return lobes;
}

void lobe_highlights(const LightSet& lights, const std::vector<glm::dvec4>& lobes, double alpha,
                     std::vector<double>& values) {
  values.assign(lights.size(), 0.0);
  for (const glm::dvec4& lobe : lobes) {
    const GgxOverLobe shaded(lobe, alpha);
    for (std::size_t i = 0; i < lights.size(); ++i)
      values[i] += shaded.specular({lights.x[i], lights.y[i], lights.z[i]}, lights.view,
                                   {lights.hx[i], lights.hy[i], lights.hz[i]});
  }
}

}  // namespace multum
