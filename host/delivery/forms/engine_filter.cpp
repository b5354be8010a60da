// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/forms/engine_filter.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

using Term = EngineFilter::Term;

// The sources were read in October and November 2026. For three.js 0.187, the source is
// lights_physical_fragment.glsl.js. Its textures have an anisotropy of 1 by default. multum's add-on and viewers
// request the GPU's maximum.
constexpr EngineFilter kThree{.anisotropy_max = 16, .roughness_least = 0.045, .term = Term::kChange};
// babylonjs 9.35, getAARoughnessFactors and Texture.DEFAULT_ANISOTROPIC_FILTERING_LEVEL; babylonjs-loaders 9.28 turns
// enableSpecularAntiAliasing on.
constexpr EngineFilter kBabylon{.anisotropy_max = 4, .term = Term::kGreaterChange, .is_of_map = true};
// playcanvas 2.23.3: Texture has an anisotropy of 1, and the shader chunks use no derivatives of normals.
constexpr EngineFilter kPlayCanvas{};
// Filament: normalFiltering() in shaders/src/surface_shading_lit.fs, turned on in libs/gltfio/materials/base.mat.in;
// default variance, threshold and TextureSampler anisotropy.
constexpr EngineFilter kFilament{.roughness_least = 0.045, .term = Term::kVariance, .variance = 0.15, .limit = 0.2};
// Godot 4: the shader of its forward renderers, and the defaults of
// rendering/anti_aliasing/screen_space_roughness_limiter; materials use "linear mipmap" textures without anisotropy.
constexpr EngineFilter kGodot{
    .term = Term::kPerceptual, .rebuilds_z = true, .is_of_map = true, .variance = 0.25, .limit = 0.18};
// Unity: Texture.anisoLevel is 1, HDRP's geometric specular anti-aliasing is off, and UnpackNormal() reads x and y.
constexpr EngineFilter kUnity{.rebuilds_z = true};
// Unreal: r.MaxAnisotropy is 8 in [TextureQuality@3] of BaseScalability.ini; bNormalCurvatureToRoughness is off; normal
// maps are BC5.
constexpr EngineFilter kUnreal{.anisotropy_max = 8, .rebuilds_z = true};

// O3DE: the samplers of MaterialSrg request an anisotropy of 16; specular anti-aliasing is off by default; normal maps
// are BC5.
constexpr EngineFilter kO3de{.anisotropy_max = 16, .rebuilds_z = true};
// Blender: Cycles uses no mip levels, and no derivatives of normals.
constexpr EngineFilter kBlender{};

double squared(double v) { return v * v; }

}  // namespace

const EngineFilter& filter_of(Engine engine) {
  switch (engine) {
    case Engine::kThree: return kThree;
    case Engine::kBabylon: return kBabylon;
    case Engine::kPlayCanvas: return kPlayCanvas;
    case Engine::kFilament: return kFilament;
    case Engine::kGodot: return kGodot;
    case Engine::kUnity:
    case Engine::kUnityHdrp: return kUnity;
    case Engine::kUnreal: return kUnreal;
    case Engine::kO3de: return kO3de;
    case Engine::kBlender: return kBlender;
  }
  MULTUM_CHECK(false);
}

EngineRoughness engine_roughness(const EngineFilter& filter, double roughness, const glm::dvec3& along_x,
                                 const glm::dvec3& along_y) {
  const double least = std::max(roughness, filter.roughness_least);
  const double square_x = glm::dot(along_x, along_x), square_y = glm::dot(along_y, along_y);
  const double added = std::min(2.0 * filter.variance * (square_x + square_y), filter.limit);
  const auto same = [](double value) { return EngineRoughness{std::min(value, 1.0), std::min(value, 1.0)}; };
  switch (filter.term) {
    case Term::kNone: return same(least);
    case Term::kChange: {
      const glm::dvec3 change = glm::max(glm::abs(along_x), glm::abs(along_y));
      return same(least + std::max({change.x, change.y, change.z}));
    }
    case Term::kVariance: return same(std::pow(squared(squared(least)) + added, 0.25));
    case Term::kPerceptual: return same(std::sqrt(squared(least) + added));
    case Term::kGreaterChange: {
      const double square = std::max(square_x, square_y);
      return {std::max(least, std::cbrt(std::min(square, 1.0))),
              std::sqrt(std::min(squared(least) + 0.75 * std::sqrt(square), 1.0))};
    }
  }
  MULTUM_CHECK(false);
}

}  // namespace multum
