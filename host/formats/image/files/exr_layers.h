// SPDX-License-Identifier: Apache-2.0
// Named channels of multilayer EXR files, as renderers write them, and Cryptomatte coverage (Cryptomatte specification
// 1.2.0, Psyop): ranked pairs of (identifier, coverage) with a manifest from names to identifiers.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace multum {

/// Planes of width * height floats, row 0 at the top.
struct ExrLayers {
  int width = 0, height = 0;
  std::map<std::string, std::vector<float>> channels;
};

/// Reads these channels of any part of the file. Throws Error(kInput) naming the file, the channel that is missing and
/// those that are there; for a damaged file; for a data window that is not the display window.
ExrLayers read_exr_channels(const std::string& path, const std::vector<std::string>& channels);

/// The names of all channels of all parts, in the file's order.
std::vector<std::string> exr_channel_names(const std::string& path);

/// Share of each pixel that each of `names` covers, 0..1, in the order of `names`: width * height floats, row 0 at the
/// top. `layer`: the Cryptomatte's name, as "CryptoObject", with or without the view layer. Names that the manifest
/// lacks, and all where it or the metadata cannot be read, are looked for by their MurmurHash3. Throws Error(kInput):
/// no such Cryptomatte in the file, or several.
std::vector<std::vector<float>> read_cryptomatte_coverage(const std::string& path, const std::string& layer,
                                                          const std::vector<std::string>& names);

struct CryptomatteNames {
  std::vector<std::string> manifest;  // in alphabetical order
  std::vector<std::string> unseen;    // of those that were wanted: not in the manifest, and in no pixel by their hash
  std::vector<std::string> warnings;  // what was matched by hash, and why; without the file's name
};

/// Looks for names in a file's Cryptomatte, as read_cryptomatte_coverage() does, and throws as it does.
CryptomatteNames find_cryptomatte_names(const std::string& path, const std::string& layer,
                                        const std::vector<std::string>& wanted);

}  // namespace multum
