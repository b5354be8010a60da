// SPDX-License-Identifier: Apache-2.0
// Maps of a material in addition to normals and colours: roughness, and linear blend weights of basis BRDFs (Han et al.
// 2007, section 7.3). The values are data, never sRGB. Integers stand for 0 to 1, floats are used unchanged, and values
// outside 0 to 1 are rejected.
//
// Roughness becomes the length of normals. A normal n with a BRDF of half vectors around it is a lobe with mean vector
// c n, where c is the mean cosine of those half vectors. Averages of c n over a texel then hold the spread of normals
// and BRDFs together, because mean cosines multiply under convolution. Perceptual roughness r stands for alpha = r^2
// and a lobe with the mean cosine
//
//     c = 1 - alpha^2 / 2        kappa = 2 / alpha^2 where c > 0.9
//
// This is normalised Blinn-Phong with s = 2 / alpha^2 - 2, the exponent that matches the peaks of Beckmann and GGX (c
// = (s + 1) / (s + 2)). Beckmann's slopes have the variance alpha^2 / 2 = 1 - c in each direction. GGX's own mean
// cosine is 1 / (1 + alpha^2 atanh(b) / b) with b^2 = 1 - alpha^2. This value is not used, because GGX's long tail,
// which a single lobe cannot represent, would widen the peak. At alpha = 0.1, c is 0.971 and kappa is 34, but the peak
// has a kappa of 200. At alpha = 1, both mean cosines are 1/2, the value of the uniform hemisphere.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/formats/image/plane_store.h"
#include "host/foundation/base/files/spill_policy.h"

namespace multum {

/// Returns c(roughness), from 1 to 1/2, for perceptual roughness from 0 to 1.
double mean_cosine_of_roughness(double roughness);

/// One channel of a file. `channel` is R, G, B, A or the name of the channel. If `channel` is empty, the only channel
/// is used, or G if there are several channels (as in glTF).
struct ChannelFile {
  std::string path;
  std::string channel;
  bool is_gloss = false;  // true if a roughness map holds gloss: roughness = 1 - value
};
/// Parses "FILE" or "FILE:CHANNEL". If the whole text names an existing file, it is a path, even with colons.
ChannelFile parse_channel_file(const std::string& text);

/// Statistics of a roughness map. All of them are in perceptual roughness.
struct RoughnessReport {
  double mean_cosine = 1.0;                    // the mean of c
  double least = 0.0, mean = 0.0, most = 0.0;  // 0 for a map without texels
  double share_zero = 0.0, share_one = 0.0;    // shares of texels with roughness 0 and with roughness 1
  double share_mirror = 0.0;                   // share of texels below kMirrorRoughness
  std::vector<std::string> warnings;           // reasons why the map may not be a roughness map, with the file's name
  /// Returns a text such as "perceptual roughness 0.08 to 1, mean 0.68; 0 % at 0, 1.2 % at 1".
  std::string to_text() const;
};

/// The kind of map that the words of a file name state, as in "bricks_gloss.png", "bricks_s.png" and
/// "BricksRoughness2K.png". If several words state a kind, the last one counts. Metalness counts only if no other kind
/// is named, because metalness is often packed together with other maps.
enum class NamedMap { kUnknown, kRoughness, kGloss, kSpecular, kMetalness };
NamedMap map_by_name(const std::string& path);

/// Below this roughness, where alpha is 0.01, a surface is a mirror whose blur is seldom visible.
constexpr double kMirrorRoughness = 0.1;
/// The largest share of mirror texels in a roughness map. Specular maps are dark where a surface is dull, so most of
/// their texels would be mirrors if they were read as roughness. In the three roughness maps of shared/data, less than
/// 0.1 % of the texels are below kMirrorRoughness. In its six specular maps, 23 to 82 % are.
constexpr double kMirrorShareMax = 0.1;
/// The same limit for a file whose name agrees with its use. The limit is higher here, because polished surfaces exist.
/// In pc_seaside-rocks01-gloss.jpg, the only gloss map of shared/data, 48 % of the texels are below kMirrorRoughness.
constexpr double kMirrorShareMaxNamed = 0.75;
/// The largest share of texels with roughness 1 that a gloss map may have. The gloss map of shared/data has 0 %, and
/// three specular maps have 15 to 32 %.
constexpr double kDullShareMax = 0.1;
/// The limits for the colours of a picture. The channels of a picture differ, but are correlated, whereas occlusion,
/// roughness and metalness have little in common. In six colour maps of shared/data, the lowest correlation of green
/// with red and blue is 0.84 to 0.99. In its three packed maps, it is at most 0.2. The mean difference of channels is
/// at least 0.016 in colour maps, and 0 in grey maps.
constexpr double kColourCorrelationMin = 0.6;
constexpr double kColourDifferenceMin = 0.01;

/// Multiplies each unit normal by c(roughness) from the roughness map, which must have the same size as the normals.
/// Throws Error(kInput), which names the file, what was found and what was expected.
RoughnessReport shorten_by_roughness(PlaneStore& normals, const ChannelFile& file, const SpillPolicy& spill,
                                     int threads);

/// The maps of a material that has one lobe per texel. An empty path means no map. The default channels are the same as
/// in glTF: red of an occlusion map, green of a roughness map, and blue of a metalness map.
struct LobeMaterialFiles {
  ChannelFile roughness, occlusion, metalness;
};

struct LobeMaterial {
  PlaneStore planes;  // alpha^2 = roughness^4, occlusion, metalness; 1 if there is no map
  std::optional<RoughnessReport> roughness = std::nullopt;
  std::vector<std::string> warnings = {};  // warnings about the other maps, with the files' names
};

/// Reads the maps, which must have this size. Throws like shorten_by_roughness().
LobeMaterial read_lobe_material(const LobeMaterialFiles& files, int width, int height, const SpillPolicy& spill,
                                int threads);

/// Weights of 1 to 4 basis BRDFs.
struct WeightMap {
  int count = 0;
  std::vector<PlaneStore> rgb_planes;  // stores of three planes, as few as hold the weights; unused planes are 0
  std::vector<std::string> warnings;   // warnings with the file's name
};

/// Reads all channels of a file with 1 to 4 channels. Throws like shorten_by_roughness().
WeightMap read_weight_map(const std::string& path, int width, int height, const SpillPolicy& spill, int threads);

}  // namespace multum
