// SPDX-License-Identifier: Apache-2.0
// Maps of a material beside its normals and colours: roughness, and linear blend weights of basis BRDFs (Han et al.
// 2007, section 7.3). Their numbers are data, never sRGB: integers stand for 0 to 1, floats for themselves, and what is
// not from 0 to 1 is refused.
//
// Roughness becomes the length of normals. A normal n with a BRDF of half vectors around it is a lobe of mean vector
// c n, c the mean cosine of those half vectors; averages of c n over a texel then hold the spread of normals and of
// BRDFs together, as mean cosines multiply under convolution. Perceptual roughness r stands for alpha = r^2 and a lobe
// whose mean cosine is
//
//     c = 1 - alpha^2 / 2        kappa = 2 / alpha^2 where c > 0.9
//
// That is normalised Blinn-Phong of s = 2 / alpha^2 - 2, the exponent that matches Beckmann's and GGX's peak (c = (s +
// 1) / (s + 2)); Beckmann's slopes have the variance alpha^2 / 2 each way, 1 - c as well. GGX's own mean cosine, 1 / (1
// + alpha^2 atanh(b) / b) with b^2 = 1 - alpha^2, is not taken: its tail, which no single lobe has, would widen the
// peak (alpha 0.1: c = 0.971, kappa 34, where the peak's is 200). At alpha 1 both are 1/2, the uniform hemisphere.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/formats/image/plane_store.h"
#include "host/foundation/base/files/spill_policy.h"

namespace multum {

/// c(roughness) for perceptual roughness of 0 to 1: 1 to 1/2.
double mean_cosine_of_roughness(double roughness);

/// One channel of a file. `channel`: R, G, B, A or the channel's name; empty: the only one, or G of several (glTF's).
struct ChannelFile {
  std::string path;
  std::string channel;
  bool is_gloss = false;  // of a roughness map: roughness = 1 - what it holds
};
/// "FILE" or "FILE:CHANNEL". What names a file that exists is a path, colons and all.
ChannelFile parse_channel_file(const std::string& text);

/// Statistics of a roughness map, all in perceptual roughness.
struct RoughnessReport {
  double mean_cosine = 1.0;                    // the mean of c
  double least = 0.0, mean = 0.0, most = 0.0;  // of a map without texels 0
  double share_zero = 0.0, share_one = 0.0;    // of the texels, those at either end
  double share_mirror = 0.0;                   // below kMirrorRoughness
  std::vector<std::string> warnings;           // why it may be no roughness map; with the file's name
  /// "perceptual roughness 0.08 to 1, mean 0.68; 0 % at 0, 1.2 % at 1".
  std::string to_text() const;
};

/// Kind of map that words of a file's name announce, e.g. "bricks_gloss.png", "bricks_s.png" and
/// "BricksRoughness2K.png". Of several words the last counts, but of metalness beside another the other, as of packed
/// maps.
enum class NamedMap { kUnknown, kRoughness, kGloss, kSpecular, kMetalness };
NamedMap map_by_name(const std::string& path);

/// Smoother is a mirror but for a blur that is seldom seen: alpha is 0.01.
constexpr double kMirrorRoughness = 0.1;
/// Specular maps are dark where a surface is dull, so that as roughness most of them is a mirror. Of shared/data's
/// three roughness maps less than 0.1 % of the texels are below kMirrorRoughness, of its six specular maps 23 to 82 %.
constexpr double kMirrorShareMax = 0.1;
/// The same for a file whose name says what it was taken for: polished surfaces exist. 48 % of the texels of
/// pc_seaside-rocks01-gloss.jpg, the one gloss map of shared/data, are below kMirrorRoughness.
constexpr double kMirrorShareMaxNamed = 0.75;
/// Texels of roughness 1 that a gloss map may have: that one has 0 %, three specular maps 15 to 32 %.
constexpr double kDullShareMax = 0.1;
/// A picture's channels go together and yet differ, where those of occlusion, roughness and metalness have little in
/// common: least correlation of green with red and blue 0.84 to 0.99 in six colour maps of shared/data, at most 0.2 in
/// its three packed maps; the mean of what channels differ by is 0.016 or more in colour maps, and 0 in grey ones.
constexpr double kColourCorrelationMin = 0.6;
constexpr double kColourDifferenceMin = 0.01;

/// Multiplies unit normals by c of the roughness map, which must be of their size. Throws Error(kInput) naming the
/// file, what was found and what was expected.
RoughnessReport shorten_by_roughness(PlaneStore& normals, const ChannelFile& file, const SpillPolicy& spill,
                                     int threads);

/// The maps of a material of one lobe; an empty path: no such map. Channels that are not named are those of glTF: red
/// of an occlusion map, green of a roughness map, blue of a metalness map.
struct LobeMaterialFiles {
  ChannelFile roughness, occlusion, metalness;
};

struct LobeMaterial {
  PlaneStore planes;  // alpha^2 = roughness^4, occlusion, metalness; 1 where there is no map
  std::optional<RoughnessReport> roughness = std::nullopt;
  std::vector<std::string> warnings = {};  // of the other maps, with the file's name
};

/// Reads the maps, which must be of this size. Throws as above.
LobeMaterial read_lobe_material(const LobeMaterialFiles& files, int width, int height, const SpillPolicy& spill,
                                int threads);

/// Weights of 1 to 4 basis BRDFs.
struct WeightMap {
  int count = 0;
  std::vector<PlaneStore> rgb_planes;  // three planes each, as many as hold them; planes that are not used are 0
  std::vector<std::string> warnings;   // with the file's name
};

/// Reads all channels of a file of 1 to 4. Throws as above.
WeightMap read_weight_map(const std::string& path, int width, int height, const SpillPolicy& spill, int threads);

}  // namespace multum
