// SPDX-License-Identifier: Apache-2.0
// Lists the names of choice values for parameter tables, jobs, files, reports and hashed settings. Add each new value
// here.
#pragma once

#include "host/foundation/base/choices.h"

namespace multum {

/// ndf: the representation of the normals that a texel covers (host/formats/asset/representation.h).
enum class Representation {
  kMovmf,    // mixtures of von Mises-Fisher lobes (host/formats/asset/lobes/movmf_mipmap.h)
  kGmm,      // mixtures of planar Gaussians, stored in the same mipmap type (host/formats/asset/lobes/gmm_quantize.h)
  kMoments,  // first and second moments of slopes, and the mean normal (host/formats/asset/averages/moment_mipmap.h)
  kSh,       // spherical harmonics of the normals up to an order (host/formats/asset/averages/sh_mipmap.h)
};
inline constexpr Choices<Representation> kRepresentations = {{"vmf", Representation::kMovmf},
                                                             {"moments", Representation::kMoments},
                                                             {"gmm", Representation::kGmm},
                                                             {"sh", Representation::kSh}};

/// data_format: the rounding of stored channel values. docs/reference/file_format.md states the loss of each format.
enum class StorageEncoding {
  kSnorm16,  // multiples of 1/32767 in a float channel: RGBA16_SNORM on the GPU
  kHalf,     // 16-bit floats: RGBA16F on the GPU
  kFloat,    // 32-bit floats: RGBA32F on the GPU
};
inline constexpr Choices<StorageEncoding> kStorageEncodings = {
    {"snorm16", StorageEncoding::kSnorm16}, {"half", StorageEncoding::kHalf}, {"float", StorageEncoding::kFloat}};

enum class FitOrder { kColour, kScanline };
inline constexpr Choices<FitOrder> kFitOrders = {{"colour", FitOrder::kColour}, {"scanline", FitOrder::kScanline}};

/// coarse_normals: the samples that EM uses for a texel that covers more than kSamplesUnchunkedMax normals. kBinned
/// uses bins of normals with similar directions (movmf_binning.cl). kAll uses all normals, which makes every level as
/// slow as the finest.
enum class CoarseNormals { kBinned, kAll };
inline constexpr Choices<CoarseNormals> kCoarseNormals = {{"binned", CoarseNormals::kBinned},
                                                          {"all", CoarseNormals::kAll}};
/// The names in hashed settings. "condensed" stands for kBinned, so that the hashes of old files stay the same.
inline constexpr Choices<CoarseNormals> kHashedCoarseNormals = {{"condensed", CoarseNormals::kBinned},
                                                                {"all", CoarseNormals::kAll}};

/// bumpformat: the formats of maketx --bumpformat, and heights whose bytes are spread over several channels
/// (HeightCoding).
enum class BumpFormat { kAuto, kHeight, kNormal, kPacked16, kPacked24, kTerrarium, kMapbox };
inline constexpr Choices<BumpFormat> kBumpFormats = {
    {"auto", BumpFormat::kAuto},         {"height", BumpFormat::kHeight},     {"normal", BumpFormat::kNormal},
    {"packed16", BumpFormat::kPacked16}, {"packed24", BumpFormat::kPacked24}, {"terrarium", BumpFormat::kTerrarium},
    {"mapbox", BumpFormat::kMapbox}};

/// green and write_green: the direction of green, which is up (OpenGL) or down (DirectX).
enum class GreenAxis { kUp, kDown };
inline constexpr Choices<GreenAxis> kGreenAxes = {{"up", GreenAxis::kUp}, {"down", GreenAxis::kDown}};

/// z_range: how z is computed from the blue channel, which is in 0..1. For signed, z = 2 * blue - 1, like x and y. For
/// positive, z = blue.
enum class ZRange { kSigned, kPositive };
inline constexpr Choices<ZRange> kZRanges = {{"signed", ZRange::kSigned}, {"positive", ZRange::kPositive}};

/// fixnan: as in maketx --fixnan, reject the file, use a flat normal, or use the mean of the 3 x 3 neighbours.
enum class FixNan { kNone, kBlack, kBox3 };
inline constexpr Choices<FixNan> kFixNans = {
    {"none", FixNan::kNone}, {"black", FixNan::kBlack}, {"box3", FixNan::kBox3}};

/// surface: the normals between texel centres. Either each texel is a facet with one normal, or normals are
/// interpolated as in renderers (host/formats/image/surface_points.h).
enum class MapSurface { kTexels, kInterpolated };
inline constexpr Choices<MapSurface> kMapSurfaces = {{"texels", MapSurface::kTexels},
                                                     {"interpolated", MapSurface::kInterpolated}};

/// colours of `multum mip`: the meaning of the values in an image.
enum class ColourEncoding {
  kAuto,    // as for albedo maps: integers are sRGB unless the file says otherwise, and floats are linear
  kSrgb,    // sRGB, whatever the file says
  kLinear,  // linear, whatever the file says
  kData,    // values that are not colours and may be negative; integers become 0..1; NaN and infinite values are
            // rejected
};
inline constexpr Choices<ColourEncoding> kColourEncodings = {{"auto", ColourEncoding::kAuto},
                                                             {"srgb", ColourEncoding::kSrgb},
                                                             {"linear", ColourEncoding::kLinear},
                                                             {"data", ColourEncoding::kData}};

/// format of exports: the file format that is written.
enum class MaterialFormat { kPng, kExr, kKtx2, kDds };
inline constexpr Choices<MaterialFormat> kMaterialFormats = {{"png", MaterialFormat::kPng},
                                                             {"exr", MaterialFormat::kExr},
                                                             {"ktx2", MaterialFormat::kKtx2},
                                                             {"dds", MaterialFormat::kDds}};

/// texels of exports: the storage format of texels.
enum class MaterialTexels {
  kRgba8,    // normals and directions as 0.5 + 0.5 n
  kRgba16f,  // values that are not encoded
  kRg8,      // like kRgba8, but with only x and y of normals, from which the shader computes z
  kBlocks,   // compressed: x and y of normals in BC5, a roughness texture in BC4, other textures in BC7
  kUastc,    // blocks of Basis Universal, only in KTX2 files
};
inline constexpr Choices<MaterialTexels> kMaterialTexels = {{"rgba8", MaterialTexels::kRgba8},
                                                            {"rgba16f", MaterialTexels::kRgba16f},
                                                            {"rg8", MaterialTexels::kRg8},
                                                            {"bc", MaterialTexels::kBlocks},
                                                            {"uastc", MaterialTexels::kUastc}};

/// texels of exported lobes: the storage format of layers.
enum class LobeTexels {
  kRgba16f,  // one layer of half floats per lobe
  kRgba8,    // one layer of values from 0 to 1 per lobe
  kBlocks,   // two BC5 layers of values from 0 to 1 per lobe
};
inline constexpr Choices<LobeTexels> kLobeTexels = {
    {"bc", LobeTexels::kBlocks}, {"rgba8", LobeTexels::kRgba8}, {"rgba16f", LobeTexels::kRgba16f}};

/// format of `multum gltf`: the image format of new textures.
enum class GltfTextureFormat {
  kAuto,   // kUastc if its error is small; otherwise kRgba8, with a PNG for loaders that lack KHR_texture_basisu
  kUastc,  // KHR_texture_basisu
  kRgba8,  // uncompressed KTX2, without KHR_texture_basisu; engine_support.h lists the loaders that reject it
  kPng,    // PNG, which stores only level 0
};
inline constexpr Choices<GltfTextureFormat> kGltfTextureFormats = {{"auto", GltfTextureFormat::kAuto},
                                                                   {"uastc", GltfTextureFormat::kUastc},
                                                                   {"rgba8", GltfTextureFormat::kRgba8},
                                                                   {"png", GltfTextureFormat::kPng}};

/// form of `multum gltf` and exports: the form of a material's normals.
enum class MaterialForm {
  kAuto,      // chosen by comparing pictures of the model or of simple shapes
  kAverages,  // averaged normals, like the mips of a renderer, with fitted roughness
  kOneLobe,   // one fitted lobe: fitted normals and roughness
};
inline constexpr Choices<MaterialForm> kMaterialForms = {
    {"auto", MaterialForm::kAuto}, {"averages", MaterialForm::kAverages}, {"one-lobe", MaterialForm::kOneLobe}};

/// for: the engine that will load the files (host/foundation/parameters/engine_presets.h). When `form` is auto, the
/// pictures imitate this engine (host/delivery/forms/engine_filter.h).
enum class Engine { kThree, kBabylon, kPlayCanvas, kFilament, kGodot, kUnity, kUnityHdrp, kUnreal, kO3de, kBlender };
inline constexpr Choices<Engine> kEngines = {
    {"three", Engine::kThree},          {"babylon", Engine::kBabylon}, {"playcanvas", Engine::kPlayCanvas},
    {"filament", Engine::kFilament},    {"godot", Engine::kGodot},     {"unity", Engine::kUnity},
    {"unity-hdrp", Engine::kUnityHdrp}, {"unreal", Engine::kUnreal},   {"o3de", Engine::kO3de},
    {"blender", Engine::kBlender}};

/// packing of an export: how roughness, occlusion and metalness are divided into textures.
enum class MaterialPacking {
  kOrm,         // one texture: occlusion in red, roughness in green, metalness in blue
  kMask,        // one texture: metalness in red, occlusion in green, 1 in blue, smoothness in alpha
  kSeparate,    // a texture of one channel for each of roughness, occlusion and metalness that the material has
  kSmoothness,  // like kSeparate, with smoothness instead of roughness
};
inline constexpr Choices<MaterialPacking> kMaterialPackings = {{"orm", MaterialPacking::kOrm},
                                                               {"mask", MaterialPacking::kMask},
                                                               {"separate", MaterialPacking::kSeparate},
                                                               {"smoothness", MaterialPacking::kSmoothness}};

/// names of an export: whose names the textures have (host/delivery/export/engines/texture_names.h).
enum class TextureNames { kPlain, kUnreal, kUnity };
inline constexpr Choices<TextureNames> kTextureNames = {
    {"plain", TextureNames::kPlain}, {"unreal", TextureNames::kUnreal}, {"unity", TextureNames::kUnity}};

/// sides of an export: the widths and heights of maps that an engine loads with all their levels.
enum class SideRule { kAny, kMultiplesOf4, kPowersOf2 };
inline constexpr Choices<SideRule> kSideRules = {
    {"any", SideRule::kAny}, {"multiples-of-4", SideRule::kMultiplesOf4}, {"powers-of-2", SideRule::kPowersOf2}};

/// pyramid of `multum pack`: how the samples of a chunk are divided into images.
enum class PyramidChoice {
  kAdaptive,  // the best of several pyramids and learnt bases
  kGreedy,    // the search described in the paper, with only the first of the available coders
  kPlain,     // the pyramid that plain_levels specifies
  kNone,      // every sample is a separate image
};
inline constexpr Choices<PyramidChoice> kPyramidChoices = {{"adaptive", PyramidChoice::kAdaptive},
                                                           {"greedy", PyramidChoice::kGreedy},
                                                           {"plain", PyramidChoice::kPlain},
                                                           {"none", PyramidChoice::kNone}};

/// context: the source of the GL context (runtime_gl/context/headless_context.h).
enum class ContextBackend { kAuto, kOsmesa, kEgl };
inline constexpr Choices<ContextBackend> kContextBackends = {
    {"auto", ContextBackend::kAuto}, {"osmesa", ContextBackend::kOsmesa}, {"egl", ContextBackend::kEgl}};

}  // namespace multum
