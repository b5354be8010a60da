// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/gltf/source_forms.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "host/delivery/export/uastc/level_texture.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr std::size_t kPicturedPixels = 250;  // pixels of a picture
constexpr int kFormRows = 64;
// Lobes do not include the separate normals of a clearcoat. If lobes are drawn, these normals are evaluated at only one
// point.
constexpr const char* kClearcoatNormal = "/extensions/KHR_materials_clearcoat/clearcoatNormalTexture";

// If the noise is at least this share of an error, the errors of two forms cannot be told apart.
constexpr double kNoiseMost = 0.5;

}  // namespace

GltfFactors gltf_factors(const GltfJson& material) {
  constexpr double kGreyOfTextures = 0.5;
  const auto found = material.find("pbrMetallicRoughness");
  if (found == material.end()) return {};
  const GltfJson& pbr = *found;
  GltfFactors made{pbr.value("metallicFactor", 1.0), pbr.contains("baseColorTexture") ? kGreyOfTextures : 1.0};
  if (const auto factor = pbr.find("baseColorFactor"); factor != pbr.end() && factor->is_array() &&
                                                       factor->size() >= 3 && factor->at(0).is_number() &&
                                                       factor->at(1).is_number() && factor->at(2).is_number())
    made.grey *= 0.2126 * factor->at(0).get<double>() + 0.7152 * factor->at(1).get<double>() +
                 0.0722 * factor->at(2).get<double>();
  made.grey = std::clamp(made.grey, 0.02, 1.0);
  return made;
}

glm::dvec2 place_in_image(const TextureCoordinates& coordinates, const glm::dvec2& uv) {
  const double u = coordinates.scale[0] * uv.x, v = coordinates.scale[1] * (1.0 - uv.y);
  const double c = std::cos(coordinates.rotation), s = std::sin(coordinates.rotation);
  return {coordinates.offset[0] + c * u + s * v, coordinates.offset[1] - s * u + c * v};
}

struct SourceForms::Drawn {
  TriangleMesh mesh;
  bool is_sphere = false;
  std::optional<ModelPictures> pictures;
};

SourceForms::SourceForms(const GltfAsset& asset, const GltfPlan& plan, const SourceFitSettings& settings, Engine engine,
                         Progress* progress)
    : asset_(asset), plan_(plan), settings_(settings), engine_(engine), progress_(progress) {}
SourceForms::~SourceForms() = default;

const SourceForms::Drawn& SourceForms::drawn(std::uint64_t uv_set) {
  std::unique_ptr<Drawn>& made = drawn_[uv_set];
  if (made != nullptr) return *made;
  made = std::make_unique<Drawn>();
  try {
    made->mesh = read_mesh(asset_.path, static_cast<int>(uv_set));
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInput) throw;
    log_info(fmt::format("{}; pictures show the materials on a sphere", error.what()));
    made->mesh = textured_sphere();
    made->is_sphere = true;
  }
  made->pictures.emplace(made->mesh, PictureSet::of_all_sizes(BoundingSphere::of(made->mesh).radius), settings_.threads,
                         progress_);
  return *made;
}

ChosenForm SourceForms::choose(std::size_t source, const FittedSource& fitted, const std::string& baked) {
  const LobeSource& from = plan_.sources[source];
  PicturedSurface surface;
  std::optional<std::size_t> first;
  for (std::size_t m = 0; m < plan_.materials.size(); ++m)
    if (plan_.materials[m].kept.empty() && plan_.materials[m].source == source) {
      if (!first) first = m;
      surface.materials.push_back(static_cast<int>(m));
    }
  MULTUM_CHECK(first.has_value());
  const TextureCoordinates& coordinates = plan_.materials[*first].coordinates;
  surface.place_of_uv = [&](const glm::dvec2& uv) { return place_in_image(coordinates, uv); };

  const Drawn* on = &drawn(coordinates.set);
  if (on->is_sphere) surface.materials = {0};
  const std::vector<ModelPicture> pictures = on->pictures->of(surface, kPicturedPixels);
  const TextureFrame frame{fitted.normal->width(), fitted.normal->height(), fitted.normal->level_count(), from.wrap_s,
                           from.wrap_t};
  const std::uint64_t bytes_each = settings_.memory_bytes / 4;
  const LevelFileTexture averages(*fitted.averages, frame, bytes_each), normals(*fitted.normal, frame, bytes_each);
  std::optional<LevelFileTexture> material;
  if (fitted.surface != nullptr) material.emplace(*fitted.surface, frame, bytes_each);
  const GltfJson& described = asset_.array("materials").at(*first);
  const GltfFactors factors = gltf_factors(described);
  const FormTextures textures{&averages, &normals, material ? &*material : nullptr, factors.metalness, factors.grey};
  const FormMeter meter(textures, pictures, {engine_, !baked.empty(), settings_.threads});

  ChosenForm made;
  made.is_on_sphere = on->is_sphere;
  made.views = meter.views();
  if (made.views.empty()) {
    made.has_lobes = !baked.empty();
    return made;
  }
  const ChosenNormalForm chosen = choose_normal_form(meter, NormalForm::of(meter.level_count(), {}));
  made.normals = chosen.form;
  made.errors = {{"plain", chosen.plain}, {"one_lobe", chosen.fitted}, {"chosen", chosen.chosen}};
  if (baked.empty() || described.contains(GltfJson::json_pointer(kClearcoatNormal))) return made;
  const LobeLevels lobes(baked, from.wrap_s, from.wrap_t, bytes_each);
  made.errors["points_4"] = meter.points(made.normals);
  made.errors["lobes_4"] = meter.lobes(lobes, made.normals);
  made.errors["noise"] = meter.noise();
  // If the references are too noisy to decide, the requested lobes are kept.
  const double lobes_error = made.errors["lobes_4"].mean;
  made.has_lobes =
      lobes_error < made.errors["points_4"].mean - kFormGain || made.errors["noise"].mean > kNoiseMost * lobes_error;
  if (!made.has_lobes || !lobes.has_colours()) return made;
  const FormMeter::Coloured coloured = meter.coloured_lobes(lobes, made.normals);
  made.errors["mean_colour_4"] = coloured.mean;
  made.errors["lobe_colours_4"] = coloured.own;
  made.has_lobe_colours = coloured.own.mean < coloured.mean.mean - kFormGain;
  return made;
}

void apply_normal_form(const NormalForm& form, FittedSource& fitted) {
  LevelFile& normal = *fitted.normal;
  for (int level = 1; level < normal.level_count(); ++level) {
    const LevelForm& of_level = form.levels[size_of(level)];
    const int height = mip_level_size(normal.height(), level);
    for (int row = 0; row < height; row += kFormRows) {
      const int count = std::min(kFormRows, height - row);
      std::vector<std::uint8_t> averages = fitted.averages->read_rows(level, row, count);
      if (fitted.surface != nullptr) {
        std::vector<std::uint8_t> surface = fitted.surface->read_rows(level, row, count);
        for (std::size_t i = 0; i < surface.size(); i += 4) {
          surface[i + 1] = static_cast<std::uint8_t>(std::lround(
              255.0 * mixed_roughness(averages[i + 3] / 255.0, surface[i + 1] / 255.0, of_level.fitted_share)));
        }
        fitted.surface->write_rows(level, row, surface);
      }
      if (of_level.has_fitted_normals) continue;
      for (std::size_t i = 3; i < averages.size(); i += 4) averages[i] = 255;
      normal.write_rows(level, row, averages);
    }
  }
}

}  // namespace multum
