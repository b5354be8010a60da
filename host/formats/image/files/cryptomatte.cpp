// SPDX-License-Identifier: Apache-2.0
// Cryptomatte specification 1.2.0 (Psyop). The metadata of a file are
//   cryptomatte/KEY/name          name of the Cryptomatte, such as ViewLayer.CryptoObject; KEY is the start of its hash
//   cryptomatte/KEY/hash          MurmurHash3_32
//   cryptomatte/KEY/conversion    uint32_to_float32: an identifier is the bits of a float
//   cryptomatte/KEY/manifest      JSON: {"name": "identifier in hexadecimal", ...}
// and its channels hold ranks of (identifier, coverage) per pixel, largest coverage first:
//   NAME00.r .g | NAME00.b .a | NAME01.r .g | NAME01.b .a | ...
// Departures from the specification: some renderers, and programs that repack files, write R, red or Red for r. Such
// programs omit the view layer from the name in the metadata or from the channel names, or add it. Such programs also
// lose the metadata, or truncate manifests. Therefore the channels identify the layer, metadata are matched to the
// channels by name or by KEY, and names that are missing in a manifest are matched by their hash. A manifest in a
// separate file (manif_file) is not read, because hashing the names gives the same identifiers.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/formats/image/files/exr_file.h"
#include "host/formats/image/files/exr_layers.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"

namespace multum {
namespace {

struct Cryptomatte {
  std::string prefix;  // common prefix of the channels: "CryptoObject" for "CryptoObject00.r"
  std::string hash, conversion;
  std::map<std::string, std::uint32_t> manifest;
  std::vector<std::string> warnings;
};

// MurmurHash3_x86_32 (Austin Appleby, public domain), seed 0.
std::uint32_t murmur_hash3(std::string_view text) {
  constexpr std::uint32_t kC1 = 0xcc9e2d51u, kC2 = 0x1b873593u;
  const auto byte = [&](std::size_t i) { return std::uint32_t{static_cast<unsigned char>(text[i])}; };
  std::uint32_t h = 0;
  const std::size_t block_end = text.size() / 4 * 4;
  for (std::size_t i = 0; i < block_end; i += 4) {
    const std::uint32_t k = byte(i) | byte(i + 1) << 8 | byte(i + 2) << 16 | byte(i + 3) << 24;
    h ^= std::rotl(k * kC1, 15) * kC2;
    h = std::rotl(h, 13) * 5 + 0xe6546b64u;
  }
  std::uint32_t tail = 0;
  for (std::size_t i = text.size(); i > block_end; --i) tail = tail << 8 | byte(i - 1);
  h ^= std::rotl(tail * kC1, 15) * kC2;
  h ^= static_cast<std::uint32_t>(text.size());
  h = (h ^ h >> 16) * 0x85ebca6bu;
  h = (h ^ h >> 13) * 0xc2b2ae35u;
  return h ^ h >> 16;
}

// Floats whose exponent bits are all zeros or all ones are denormals, infinities or NaN, which programs may change.
std::uint32_t as_identifier(std::uint32_t hash) {
  const std::uint32_t exponent = hash >> 23 & 255u;
  return exponent == 0 || exponent == 255 ? hash ^ 1u << 23 : hash;
}

// Reads as much of a manifest as possible. Returns a description of the fault, or an empty string.
std::string parse_manifest(const std::string& text, std::map<std::string, std::uint32_t>& manifest) {
  if (holds_nul(text)) return "it contains a NUL";
  std::string name, wrong;
  const auto take = [&](int depth, nlohmann::json::parse_event_t event, nlohmann::json& value) {
    using Event = nlohmann::json::parse_event_t;
    if (event == Event::key) name = value.get<std::string>();
    if (event != Event::value || depth != 1) return true;
    const std::string digits = value.is_string() ? value.get<std::string>() : "";
    if (digits.empty() || digits.size() > 8 || digits.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos)
      wrong = fmt::format("\"{}\" is {}, expected up to 8 hexadecimal digits", name, value.dump());
    else manifest[name] = as_identifier(static_cast<std::uint32_t>(std::stoul(digits, nullptr, 16)));
    return true;
  };
  const auto json = nlohmann::json::parse(text, take, false);
  if (json.is_discarded()) return fmt::format("its {} bytes are incomplete or not JSON", text.size());
  return json.is_object() ? wrong : "it is not a JSON object";
}

// The attributes of each KEY, with the part of their names after "cryptomatte/KEY/".
using Metadata = std::map<std::string, std::map<std::string, std::string>>;

Metadata cryptomatte_metadata(const ExrFile& file) {
  constexpr std::string_view kPrefix = "cryptomatte/";
  Metadata found;
  for (const auto& [name, value] : file.attributes()) {
    const std::size_t slash = name.find('/', kPrefix.size());
    if (!name.starts_with(kPrefix) || slash == std::string::npos) continue;
    found[name.substr(kPrefix.size(), slash - kPrefix.size())][name.substr(slash + 1)] = value;
  }
  return found;
}

// The names that various programs give to the four channels of a level.
constexpr const char* kSuffixes[][4] = {
    {"r", "g", "b", "a"}, {"R", "G", "B", "A"}, {"red", "green", "blue", "alpha"}, {"Red", "Green", "Blue", "Alpha"}};

// Returns the name of channel `index` of the level in this file, or an empty string.
std::string channel_of(const ExrFile& file, const std::string& prefix, int level, std::size_t index) {
  for (const auto& suffixes : kSuffixes)
    if (std::string name = fmt::format("{}{:02}.{}", prefix, level, suffixes[index]); file.has_channel(name))
      return name;
  return "";
}

// Returns the parts of the channel names that precede "00.r".
std::vector<std::string> channel_prefixes(const std::vector<std::string>& channels) {
  std::vector<std::string> prefixes;
  for (const std::string& channel : channels)
    for (const auto& suffixes : kSuffixes)
      if (const std::string end = std::string("00.") + suffixes[0];
          channel.ends_with(end) && channel.size() > end.size())
        prefixes.push_back(channel.substr(0, channel.size() - end.size()));
  return prefixes;
}

std::string last_of(const std::string& name) { return name.substr(name.rfind('.') + 1); }

// Compares names. Returns 0 if they are equal, 1 if one is a suffix of the other, 2 if only the last parts are equal,
// and 3 if they differ.
int distance_of(const std::string& a, const std::string& b) {
  if (a == b) return 0;
  if (a.ends_with("." + b) || b.ends_with("." + a)) return 1;
  return last_of(a) == last_of(b) ? 2 : 3;
}

// Returns the `names` that match `name` best.
std::vector<std::string> nearest_names(const std::vector<std::string>& names, const std::string& name) {
  std::vector<std::string> found;
  int least = 2;
  for (const std::string& one : names) least = std::min(least, distance_of(one, name));
  for (const std::string& one : names)
    if (distance_of(one, name) == least && std::find(found.begin(), found.end(), one) == found.end())
      found.push_back(one);
  return found;
}

std::string metadata_text(const std::map<std::string, std::string>& values, const char* name) {
  const auto found = values.find(name);
  return found == values.end() ? std::string() : found->second;
}

// Finds the metadata of a layer by the name in the metadata.
const std::map<std::string, std::string>* metadata_by_name(const ExrFile& file, const Metadata& metadata,
                                                           const std::string& prefix, const std::string& layer) {
  std::vector<std::string> names;
  for (const auto& [key, values] : metadata)
    if (!metadata_text(values, "name").empty()) names.push_back(metadata_text(values, "name"));
  std::vector<std::string> matches = nearest_names(names, layer);
  if (matches.size() != 1)
    if (const auto closer = nearest_names(matches.empty() ? names : matches, prefix); !closer.empty()) matches = closer;
  if (matches.size() > 1)
    refuse_file(file.path(), fmt::format("has several Cryptomattes \"{}\": {}; give the full name of one", layer,
                                         fmt::join(matches, ", ")));
  for (const auto& [key, values] : metadata)
    if (!matches.empty() && metadata_text(values, "name") == matches.front()) return &values;
  return nullptr;
}

// Finds metadata that have no name, by their KEY.
const std::map<std::string, std::string>* metadata_by_key(const Metadata& metadata,
                                                          const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const std::string key = fmt::format("{:08x}", murmur_hash3(name)).substr(0, 7);
    if (const auto found = metadata.find(key); found != metadata.end()) return &found->second;
  }
  return nullptr;
}

Cryptomatte find_cryptomatte(const ExrFile& file, const std::string& layer) {
  std::vector<std::string> matches = nearest_names(channel_prefixes(file.channels()), layer);
  if (matches.empty()) matches = nearest_names(channel_prefixes(file.all_names()), layer);
  if (matches.empty())
    refuse_file(file.path(), fmt::format("has no channel \"{}00.r\" for Cryptomatte \"{}\"; it has {}", layer, layer,
                                         fmt::join(file.channels(), ", ")));
  if (matches.size() > 1)
    refuse_file(file.path(), fmt::format("has several Cryptomattes \"{}\": {}; give the full name of one", layer,
                                         fmt::join(matches, ", ")));
  Cryptomatte result{matches.front(), "", "", {}, {}};
  const Metadata metadata = cryptomatte_metadata(file);
  const std::map<std::string, std::string>* values = metadata_by_name(file, metadata, result.prefix, layer);
  if (values == nullptr) {
    values = metadata_by_key(metadata, {layer, result.prefix, last_of(result.prefix)});
    result.warnings.push_back(
        values != nullptr
            ? fmt::format(
                  "the metadata of Cryptomatte \"{}\" do not contain its name, but were found by the hash of this name",
                  layer)
            : fmt::format("found no metadata for Cryptomatte \"{}\", so its objects are matched by the MurmurHash3 of "
                          "their names",
                          layer));
  }
  if (values == nullptr) return result;
  result.hash = metadata_text(*values, "hash");
  result.conversion = metadata_text(*values, "conversion");
  if (!result.conversion.empty() && result.conversion != "uint32_to_float32")
    refuse_file(file.path(), fmt::format("Cryptomatte \"{}\" has conversion \"{}\", expected uint32_to_float32", layer,
                                         result.conversion));
  if (const std::string text = metadata_text(*values, "manifest"); !text.empty())
    if (const std::string wrong = parse_manifest(text, result.manifest); !wrong.empty())
      result.warnings.push_back(
          fmt::format("the manifest of Cryptomatte \"{}\" is damaged: {}. {} of its names are usable; other names are "
                      "matched by their hashes",
                      layer, wrong, result.manifest.size()));
  return result;
}

std::uint32_t identifier_of(const ExrFile& file, const Cryptomatte& cryptomatte, const std::string& name) {
  const auto found = cryptomatte.manifest.find(name);
  if (found != cryptomatte.manifest.end()) return found->second;
  if (!cryptomatte.hash.empty() && cryptomatte.hash != "MurmurHash3_32")
    refuse_file(file.path(),
                fmt::format("the Cryptomatte manifest has no \"{}\" and uses the hash \"{}\", expected MurmurHash3_32",
                            name, cryptomatte.hash));
  return as_identifier(murmur_hash3(name));
}

struct Rank {
  std::vector<float> identifiers, coverages;
};

Rank read_rank(ExrFile& file, const std::string& identifier, const std::string& coverage) {
  Rank rank{file.read(identifier), file.read(coverage)};
  if (!file.is_float(identifier))
    refuse_file(
        file.path(),
        fmt::format("channel \"{}\" has half floats, which cannot hold Cryptomatte identifiers; expected 32-bit floats",
                    identifier));
  return rank;
}

void add_rank(const Rank& rank, const std::vector<std::uint32_t>& identifiers,
              std::vector<std::vector<float>>& coverages) {
  for (std::size_t i = 0; i < rank.identifiers.size(); ++i) {
    const float coverage = rank.coverages[i];
    if (!std::isfinite(coverage) || coverage <= 0.0f) continue;
    const auto bits = std::bit_cast<std::uint32_t>(rank.identifiers[i]);
    for (std::size_t k = 0; k < identifiers.size(); ++k)
      if (identifiers[k] == bits) coverages[k][i] = std::min(1.0f, coverages[k][i] + coverage);
  }
}

std::vector<std::vector<float>> coverages_of(ExrFile& file, const Cryptomatte& cryptomatte,
                                             const std::vector<std::string>& names) {
  std::vector<std::uint32_t> identifiers;
  for (const std::string& name : names) identifiers.push_back(identifier_of(file, cryptomatte, name));
  const std::size_t pixel_count = static_cast<std::size_t>(file.width()) * static_cast<std::size_t>(file.height());
  std::vector<std::vector<float>> coverages(names.size(), std::vector<float>(pixel_count, 0.0f));
  for (int level = 0;; ++level) {
    std::array<std::string, 4> channels;
    for (std::size_t i = 0; i < channels.size(); ++i) channels[i] = channel_of(file, cryptomatte.prefix, level, i);
    if (channels[0].empty()) break;
    for (std::size_t i = 0; i < channels.size(); ++i)
      if (channels[i].empty())
        refuse_file(file.path(), fmt::format("has no channel \"{}{:02}.{}\"; it has {}", cryptomatte.prefix, level,
                                             kSuffixes[0][i], fmt::join(file.channels(), ", ")));
    add_rank(read_rank(file, channels[0], channels[1]), identifiers, coverages);
    add_rank(read_rank(file, channels[2], channels[3]), identifiers, coverages);
  }
  return coverages;
}

}  // namespace

std::vector<std::vector<float>> read_cryptomatte_coverage(const std::string& path, const std::string& layer,
                                                          const std::vector<std::string>& names) {
  ExrFile file(path);
  return coverages_of(file, find_cryptomatte(file, layer), names);
}

CryptomatteNames find_cryptomatte_names(const std::string& path, const std::string& layer,
                                        const std::vector<std::string>& wanted) {
  ExrFile file(path);
  const Cryptomatte cryptomatte = find_cryptomatte(file, layer);
  CryptomatteNames found{{}, {}, cryptomatte.warnings};
  for (const auto& [name, identifier] : cryptomatte.manifest) found.manifest.push_back(name);
  std::vector<std::string> others;
  for (const std::string& name : wanted)
    if (!cryptomatte.manifest.contains(name)) others.push_back(name);
  if (others.empty()) return found;
  const std::vector<std::vector<float>> coverages = coverages_of(file, cryptomatte, others);
  for (std::size_t i = 0; i < others.size(); ++i) {
    const bool is_seen = std::any_of(coverages[i].begin(), coverages[i].end(), [](float c) { return c > 0.0f; });
    if (!is_seen) found.unseen.push_back(others[i]);
    else if (!cryptomatte.manifest.empty())
      found.warnings.push_back(fmt::format(
          "the manifest of Cryptomatte \"{}\" has no \"{}\"; the name was matched by its hash", layer, others[i]));
  }
  return found;
}

}  // namespace multum
