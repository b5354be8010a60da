// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/view_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>

#include "host/foundation/base/log.h"
#include "host/foundation/base/progress.h"
#include "runtime_gl/render/environment_background.h"
#include "tools/multum_view/kept_reference.h"

namespace multum {
namespace {

struct ComparedMethod {
  gl::Baseline baseline;
  bool has_points;  // true if the picture is shaded at as many points as the baked map needs evaluations
};

ComparedMethod method_of(const std::string& name) {
  if (name == "points") return {gl::Baseline::kMip, true};
  constexpr std::string_view kEnding = "-points";
  const bool has_points = name.ends_with(kEnding);
  const std::string_view of = std::string_view(name).substr(0, name.size() - (has_points ? kEnding.size() : 0));
  return {of == "mip"       ? gl::Baseline::kMip
          : of == "toksvig" ? gl::Baseline::kToksvig
          : of == "lean"    ? gl::Baseline::kLean
                            : gl::Baseline::kLeanJacobian,
          has_points};
}

// Returns a number of evaluations that is at least the baked map's number.
int evaluations_of(const gl::TextureFilter& filter, int lobe_count) {
  if (filter.evaluations > 0) return filter.evaluations;
  return gl::evaluations_of_lobes(lobe_count * (filter.shades_taps ? filter.taps : 1));
}

int lobe_count_of(const BakedMap& map) {
  const auto* const lobes = std::get_if<MovmfMipmap>(&map.levels);
  return lobes == nullptr || lobes->levels.empty() ? 1 : static_cast<int>(lobes->levels.front().lobes.size());
}

bool is_power_of_two(int size) { return (size & (size - 1)) == 0; }

// Draws one basis BRDF after another, and adds up the pictures, each multiplied by its weight. Reflected light is such
// a sum.
template <typename Draw>
gl::Picture draw_blended(const std::vector<Brdf>& basis, gl::RenderScene scene, gl::Material& material,
                         const Draw& draw) {
  if (basis.size() <= 1) return draw(scene);
  gl::Picture sum{};
  for (std::size_t k = 0; k < basis.size(); ++k) {
    scene.brdf = basis[k];
    material.set_basis(static_cast<int>(k));
    gl::Picture part = draw(scene);
    if (k == 0) {
      sum = std::move(part);
      continue;
    }
    // Alpha is coverage, which is the same in each picture of the sum.
    for (std::size_t i = 0; i < sum.image.rgba.size(); ++i)
      if (i % 4 != 3) sum.image.rgba[i] += part.image.rgba[i];
    sum.frame_time_ms += part.frame_time_ms;
    sum.processor_time_ms += part.processor_time_ms;
    sum.draw_time_ms += part.draw_time_ms;
    sum.sample_count = std::max(sum.sample_count, part.sample_count);
    sum.noise = std::max(sum.noise, part.noise);
  }
  material.set_basis(std::nullopt);
  return sum;
}

}  // namespace

std::shared_ptr<const gl::FloatImage> background_of(const PictureOptions& options, const gl::RenderScene& scene) {
  if (scene.environment == nullptr || options.light.no_background) return nullptr;
  return std::make_shared<const gl::FloatImage>(
      gl::environment_background(scene, options.output.width(), options.output.height()));
}

gl::FloatImage shown_image(const NamedPicture& picture) {
  if (picture.background == nullptr) return picture.picture.image;
  return gl::before_background(picture.picture.image, *picture.background);
}

PictureDrawer::PictureDrawer(const MapOptions& options, const std::vector<Brdf>& basis, const gl::GlFunctions& gl,
                             const gl::Mesh& mesh, const BakedMap& map, const gl::NormalImage& source)
    : options_(options),
      basis_(basis),
      mesh_(mesh),
      lobe_count_(lobe_count_of(map)),
      renderer_(gl, options.picture.output.width(), options.picture.output.height()),
      baked_(make_material(gl, map, options.picture.shading, source)) {
  using gl::NormalMaterial;
  if (has_kept_reference(options.comparison.kept_reference))
    kept_reference_ = read_kept_reference(options.comparison.kept_reference, options.picture.output.width(),
                                          options.picture.output.height());
  for (const std::string& name : options.comparison.pictures) {
    if (name == "reference" && kept_reference_) continue;
    if (name == "reference") finest_.emplace(gl, source, options.comparison.reference, 1.0f);
    else if (!mipmapped_)
      mipmapped_.emplace(gl, source, NormalMaterial::Sampling::kMipmapped, options.picture.shading.anisotropy);
  }
}

std::vector<NamedPicture> PictureDrawer::draw(const gl::RenderScene& scene) {
  std::vector<NamedPicture> pictures;
  const auto drawn = [&](gl::Material& material, const gl::RenderScene& of_method) {
    return draw_blended(basis_, of_method, material,
                        [&](const gl::RenderScene& one) { return renderer_.draw(mesh_, material, one); });
  };
  pictures.push_back({"multum", drawn(*baked_, scene)});
  for (const std::string& name : options_.comparison.pictures) {
    if (name == "reference" && kept_reference_) {
      pictures.insert(pictures.begin(), {name, *kept_reference_});
    } else if (name == "reference") {
      const std::unique_ptr<Progress> progress = make_terminal_progress(true);
      progress->start(static_cast<std::uint64_t>(gl::kReferenceUnits) * std::max<std::size_t>(basis_.size(), 1));
      progress->stage("draw the reference");
      const auto draw = [&](const gl::RenderScene& one) {
        return renderer_.draw_reference(mesh_, *finest_, one, options_.comparison.sampling, progress.get());
      };
      pictures.insert(pictures.begin(), {name, draw_blended(basis_, scene, *finest_, draw)});
      if (const std::string& file = options_.comparison.kept_reference; !file.empty())
        write_kept_reference(file, pictures.front().picture);
    } else {
      const ComparedMethod method = method_of(name);
      gl::RenderScene of_method = scene;
      of_method.filter.evaluations = method.has_points ? evaluations_of(scene.filter, lobe_count_) : 0;
      mipmapped_->set_baseline(method.baseline);
      pictures.push_back({name, drawn(*mipmapped_, of_method)});
    }
  }
  const std::shared_ptr<const gl::FloatImage> background = background_of(options_.picture, scene);
  for (NamedPicture& picture : pictures) picture.background = background;
  return pictures;
}

/// Warns about a fault of Mesa 22.3.6. The fault was measured with averaged normals on the plane seen from above. For a
/// terrain of 403 x 344 texels, the error is 85 % with --anisotropy 4 and 60 % without it. For the same terrain resized
/// to 256 x 256 texels, the errors are 65 % and 66 %.
void warn_of_wrong_anisotropy(const MapOptions& options, const BakedHeader& baked, const std::string& renderer) {
  if (options.picture.shading.anisotropy <= 1.0f || renderer.find("llvmpipe") == std::string::npos) return;
  if (is_power_of_two(baked.width) && is_power_of_two(baked.height)) return;
  log_warning(options.file, fmt::format("has {} x {} texels; with --anisotropy, this software renderer filters maps "
                                        "wrongly unless their sides are powers of two. Omit --anisotropy",
                                        baked.width, baked.height));
}

}  // namespace multum
