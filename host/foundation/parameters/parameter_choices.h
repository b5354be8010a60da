// SPDX-License-Identifier: Apache-2.0
// The values of choices with their names: what a row says may be given, what jobs hold, and what files, reports and
// hashed settings call it. A value more is one here.
#pragma once

#include "host/foundation/base/choices.h"

namespace multum {

/// ndf: representations of the normals under a texel (host/formats/asset/representation.h).
enum class Representation {
  kMovmf,    // mixtures of von Mises-Fisher lobes (host/formats/asset/lobes/movmf_mipmap.h)
  kGmm,      // mixtures of planar Gaussians, lobes too (the same file, host/formats/asset/lobes/gmm_quantize.h)
  kMoments,  // first and second moments of slopes, and the mean normal (host/formats/asset/averages/moment_mipmap.h)
  kSh,       // spherical harmonics of the normals, to an order (host/formats/asset/averages/sh_mipmap.h)
};
inline constexpr Choices<Representation> kRepresentations = {{"vmf", Representation::kMovmf},
                                                             {"moments", Representation::kMoments},
                                                             {"gmm", Representation::kGmm},
                                                             {"sh", Representation::kSh}};

/// data_format: rounding of stored channel values; docs/reference/file_format.md states what each loses.
enum class StorageEncoding {
  kSnorm16,  // multiples of 1/32767 in a float channel: RGBA16_SNORM on the GPU
  kHalf,     // 16-bit floats: RGBA16F on the GPU
  kFloat,    // 32-bit floats: RGBA32F on the GPU
};
inline constexpr Choices<StorageEncoding> kStorageEncodings = {
    {"snorm16", StorageEncoding::kSnorm16}, {"half", StorageEncoding::kHalf}, {"float", StorageEncoding::kFloat}};

enum class FitOrder { kColour, kScanline };
inline constexpr Choices<FitOrder> kFitOrders = {{"colour", FitOrder::kColour}, {"scanline", FitOrder::kScanline}};

/// Samples that EM takes of a texel that covers more than kSamplesUnchunkedMax normals: bins of normals that point the
/// same way (movmf_binning.cl), or every normal, which costs each level as much as the finest.
enum class CoarseNormals { kBinned, kAll };
inline constexpr Choices<CoarseNormals> kCoarseNormals = {{"binned", CoarseNormals::kBinned},
                                                          {"all", CoarseNormals::kAll}};
/// As files state it: the first by a former name, so that they keep their hash.
inline constexpr Choices<CoarseNormals> kHashedCoarseNormals = {{"condensed", CoarseNormals::kBinned},
                                                                {"all", CoarseNormals::kAll}};

/// bumpformat: maketx --bumpformat; and heights whose bytes are spread over channels (HeightCoding).
enum class BumpFormat { kAuto, kHeight, kNormal, kPacked16, kPacked24, kTerrarium, kMapbox };
inline constexpr Choices<BumpFormat> kBumpFormats = {
    {"auto", BumpFormat::kAuto},         {"height", BumpFormat::kHeight},     {"normal", BumpFormat::kNormal},
    {"packed16", BumpFormat::kPacked16}, {"packed24", BumpFormat::kPacked24}, {"terrarium", BumpFormat::kTerrarium},
    {"mapbox", BumpFormat::kMapbox}};

/// green and write_green: OpenGL, DirectX.
enum class GreenAxis { kUp, kDown };
inline constexpr Choices<GreenAxis> kGreenAxes = {{"up", GreenAxis::kUp}, {"down", GreenAxis::kDown}};

/// Of what blue stores in 0..1: 2 * blue - 1 as x and y, or blue itself.
enum class ZRange { kSigned, kPositive };
inline constexpr Choices<ZRange> kZRanges = {{"signed", ZRange::kSigned}, {"positive", ZRange::kPositive}};

/// maketx --fixnan: refuse, flat normal, mean of the 3 x 3 neighbours.
enum class FixNan { kNone, kBlack, kBox3 };
inline constexpr Choices<FixNan> kFixNans = {
    {"none", FixNan::kNone}, {"black", FixNan::kBlack}, {"box3", FixNan::kBox3}};

/// surface: what lies between texels: nothing, each is a facet of one normal, or what renderers interpolate
/// (host/formats/image/surface_points.h).
enum class MapSurface { kTexels, kInterpolated };
inline constexpr Choices<MapSurface> kMapSurfaces = {{"texels", MapSurface::kTexels},
                                                     {"interpolated", MapSurface::kInterpolated}};

/// colours of `multum mip`: meaning of an image's numbers.
enum class ColourEncoding {
  kAuto,    // as the albedo's: integers sRGB unless the file says otherwise, floats linear
  kSrgb,    // sRGB, whatever the file says
  kLinear,  // linear, whatever the file says
  kData,    // no colours: numbers that may be negative; integers are 0..1. What is not finite is refused
};
inline constexpr Choices<ColourEncoding> kColourEncodings = {{"auto", ColourEncoding::kAuto},
                                                             {"srgb", ColourEncoding::kSrgb},
                                                             {"linear", ColourEncoding::kLinear},
                                                             {"data", ColourEncoding::kData}};

/// format of exports.
enum class MaterialFormat { kPng, kExr, kKtx2, kDds };
inline constexpr Choices<MaterialFormat> kMaterialFormats = {{"png", MaterialFormat::kPng},
                                                             {"exr", MaterialFormat::kExr},
                                                             {"ktx2", MaterialFormat::kKtx2},
                                                             {"dds", MaterialFormat::kDds}};

/// texels of exports: how they are stored.
enum class MaterialTexels {
  kRgba8,    // normals and directions as 0.5 + 0.5 n
  kRgba16f,  // as they are
  kRg8,      // as kRgba8, but of normals only x and y: a shader has to rebuild z
  kBlocks,   // compressed: of normals x and y as BC5, roughness alone as BC4, all else as BC7
  kUastc,    // Basis Universal's blocks, of KTX2 only
};
inline constexpr Choices<MaterialTexels> kMaterialTexels = {{"rgba8", MaterialTexels::kRgba8},
                                                            {"rgba16f", MaterialTexels::kRgba16f},
                                                            {"rg8", MaterialTexels::kRg8},
                                                            {"bc", MaterialTexels::kBlocks},
                                                            {"uastc", MaterialTexels::kUastc}};

/// texels of exported lobes: how layers store them.
enum class LobeTexels {
  kRgba16f,  // a layer a lobe, half floats
  kRgba8,    // a layer a lobe, 0 to 1
  kBlocks,   // two layers of BC5 a lobe, 0 to 1
};
inline constexpr Choices<LobeTexels> kLobeTexels = {
    {"bc", LobeTexels::kBlocks}, {"rgba8", LobeTexels::kRgba8}, {"rgba16f", LobeTexels::kRgba16f}};

/// format of `multum gltf`: images of the new textures.
enum class GltfTextureFormat {
  kAuto,   // kUastc where that shows little, else kRgba8 with a PNG for loaders that have no KHR_texture_basisu
  kUastc,  // KHR_texture_basisu
  kRgba8,  // KTX2, not compressed: outside of KHR_texture_basisu; host/delivery/export/engine_support.h has who refuses
           // it
  kPng,    // level 0 alone
};
inline constexpr Choices<GltfTextureFormat> kGltfTextureFormats = {{"auto", GltfTextureFormat::kAuto},
                                                                   {"uastc", GltfTextureFormat::kUastc},
                                                                   {"rgba8", GltfTextureFormat::kRgba8},
                                                                   {"png", GltfTextureFormat::kPng}};

/// form of `multum gltf` and exports: what a material's normals become.
enum class MaterialForm {
  kAuto,      // by pictures of the model, or of simple shapes
  kAverages,  // means of normals, as a renderer's own mips, and fitted roughness
  kOneLobe,   // one fitted lobe: both fitted
};
inline constexpr Choices<MaterialForm> kMaterialForms = {
    {"auto", MaterialForm::kAuto}, {"averages", MaterialForm::kAverages}, {"one-lobe", MaterialForm::kOneLobe}};

/// for: the engine whose filter those pictures have (host/delivery/forms/engine_filter.h).
enum class Engine { kThree, kBabylon, kPlayCanvas, kFilament, kGodot, kUnity, kUnreal };
inline constexpr Choices<Engine> kEngines = {{"three", Engine::kThree},           {"babylon", Engine::kBabylon},
                                             {"playcanvas", Engine::kPlayCanvas}, {"filament", Engine::kFilament},
                                             {"godot", Engine::kGodot},           {"unity", Engine::kUnity},
                                             {"unreal", Engine::kUnreal}};

/// pyramid of `multum pack`: images of a chunk.
enum class PyramidChoice {
  kAdaptive,  // the best of a few pyramids and of bases that are learnt
  kGreedy,    // the paper's search, by the first coder
  kPlain,     // plain_levels
  kNone,      // every sample by itself
};
inline constexpr Choices<PyramidChoice> kPyramidChoices = {{"adaptive", PyramidChoice::kAdaptive},
                                                           {"greedy", PyramidChoice::kGreedy},
                                                           {"plain", PyramidChoice::kPlain},
                                                           {"none", PyramidChoice::kNone}};

/// context: who gives the GL context (runtime_gl/context/headless_context.h).
enum class ContextBackend { kAuto, kOsmesa, kEgl };
inline constexpr Choices<ContextBackend> kContextBackends = {
    {"auto", ContextBackend::kAuto}, {"osmesa", ContextBackend::kOsmesa}, {"egl", ContextBackend::kEgl}};

}  // namespace multum
