// SPDX-License-Identifier: Apache-2.0
// Reads named channels of multilayer EXR files that renderers write. Also reads Cryptomatte coverage (Cryptomatte
// specification 1.2.0, Psyop), which consists of ranked pairs of (identifier, coverage), and a manifest that maps names
// to identifiers.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace multum {

/// Planes of width * height floats, with row 0 at the top.
struct ExrLayers {
  int width = 0, height = 0;
  std::map<std::string, std::vector<float>> channels;
};

/// Reads these channels from any part of the file. Throws Error(kInput), which names the file, if a channel is missing
/// (the message lists the existing ones), the file is damaged, or the data window differs from the display window.
ExrLayers read_exr_channels(const std::string& path, const std::vector<std::string>& channels);

/// Returns the names of all channels of all parts, in the file's order.
std::vector<std::string> exr_channel_names(const std::string& path);

/// For each of `names`, in order, returns the share (0..1) of each pixel that the named object covers. The result has
/// width
/// * height floats, with row 0 at the top. `layer` is the name of the Cryptomatte, such as "CryptoObject", with or
/// without the view layer. Names that are missing in the manifest are matched by their MurmurHash3. Without a readable
/// manifest or metadata, all names are matched in this way. Throws Error(kInput) if the file has no such Cryptomatte,
/// or several.
std::vector<std::vector<float>> read_cryptomatte_coverage(const std::string& path, const std::string& layer,
                                                          const std::vector<std::string>& names);

struct CryptomatteNames {
  std::vector<std::string> manifest;  // in alphabetical order
  std::vector<std::string> unseen;    // wanted names that are missing in the manifest and whose hash is in no pixel
  std::vector<std::string> warnings;  // names matched by hash, with the reason; without the file's name
};

/// Searches for names in the Cryptomatte of a file. Matches and throws like read_cryptomatte_coverage().
CryptomatteNames find_cryptomatte_names(const std::string& path, const std::string& layer,
                                        const std::vector<std::string>& wanted);

}  // namespace multum
