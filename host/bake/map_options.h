// SPDX-License-Identifier: Apache-2.0
// What a person says of one map's bake: the options of `multum bake` that a manifest has for each map too, under the
// same names. Both fill this, so that both make the same job of the same words.
#pragma once

#include <optional>
#include <string>

#include "host/bake/bake_job.h"
#include "host/base/choices.h"
#include "host/image/reading_options.h"

namespace multum {

inline const Choices<FitOrder> kFitOrders = {{"colour", FitOrder::kColour}, {"scanline", FitOrder::kScanline}};
inline const Choices<CoarseNormals> kCoarseNormals = {{"condensed", CoarseNormals::kCondensed},
                                                      {"all", CoarseNormals::kAll}};
inline const Choices<StorageEncoding> kStorageEncodings = {
    {"snorm16", StorageEncoding::kSnorm16}, {"half", StorageEncoding::kHalf}, {"float", StorageEncoding::kFloat}};
inline const Choices<WrapMode> kWrapModes = {{"black", WrapMode::kBlack},
                                             {"clamp", WrapMode::kClamp},
                                             {"periodic", WrapMode::kPeriodic},
                                             {"mirror", WrapMode::kMirror}};
/// Of a map to bake: a wrap mode, or what the map itself shows, periodic where it tiles and clamp elsewhere.
enum class MapWrap { kAuto, kBlack, kClamp, kPeriodic, kMirror };
inline const Choices<MapWrap> kMapWraps = {{"auto", MapWrap::kAuto},
                                           {"black", MapWrap::kBlack},
                                           {"clamp", MapWrap::kClamp},
                                           {"periodic", MapWrap::kPeriodic},
                                           {"mirror", MapWrap::kMirror}};

inline const Choices<Representation> kNdfs = [] {
  Choices<Representation> choices;
  for (const RepresentationInfo& info : representations()) choices.emplace_back(info.option, info.representation);
  return choices;
}();

/// Unset: not said, as the job has it.
struct MapOptions {
  ReadingOptions reading;
  bool check_nan = false;
  std::optional<MapWrap> wrap, wrap_s, wrap_t;  // of both directions, of s alone, of t alone
  std::optional<std::string> albedo, roughness, gloss, weights;
  std::optional<Representation> ndf;
  std::optional<int> lobes, iterations, sweeps, first_level, sh_order;
  std::optional<float> alignment, kappa_cap;
  bool reference = false;     // make_reference(), before the other options of the fit
  bool no_rehearsal = false;  // MovmfSettings::rehearse_start
  bool unaligned = false;     // make_unaligned(), before --align and --sweeps
  std::optional<FitOrder> order;
  std::optional<CoarseNormals> coarse_normals;
  std::optional<StorageEncoding> data_format;
  std::optional<std::string> compression;
};

void apply(const MapOptions& options, BakeJob& job);
/// Along s and along t.
void set_wrap_s(MapWrap wrap, NormalMapSettings& settings);
void set_wrap_t(MapWrap wrap, NormalMapSettings& settings);

/// The option, as "--lobes", that says what a target chooses; null: there is none.
const char* option_of_target(const MapOptions& options);
/// Without any.
MapOptions without_options_of_target(MapOptions options);

/// What they say of the representation, the fit and the storage, as `multum bake` takes it: "--ndf vmf --lobes 3".
std::string options_text(const MapOptions& options);

/// Throws Error(kUsage) for an option of one representation, as those that say how lobes are fitted, where another is
/// baked.
void check_options_of_ndf(const MapOptions& options);

}  // namespace multum
