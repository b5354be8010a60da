// SPDX-License-Identifier: Apache-2.0
// Cryptomatte specification 1.2.0 (Psyop). A file's metadata says
//   cryptomatte/KEY/name          the name of the Cryptomatte, as ViewLayer.CryptoObject
//   cryptomatte/KEY/hash          MurmurHash3_32
//   cryptomatte/KEY/conversion    uint32_to_float32: an identifier is the bits of a float
//   cryptomatte/KEY/manifest      JSON: {"name": "identifier in hexadecimal", ...}
// and its channels hold, for each pixel, ranks of (identifier, coverage), largest coverage first:
//   NAME00.r .g | NAME00.b .a | NAME01.r .g | NAME01.b .a | ...
// Departure: NAME of the channels may lack the view layer that the metadata's has; programs that repack files drop it.
// A manifest in a file of its own (manif_file) is not read: names are hashed then, which gives the same identifiers.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/files/json_file.h"
#include "host/image/files/exr_file.h"
#include "host/image/files/exr_layers.h"

namespace multum {
namespace {

struct Cryptomatte {
  std::string name;  // as the metadata has it
  std::string hash, conversion;
  std::map<std::string, std::uint32_t> manifest;
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

// Exponents of all zeros or ones would be denormals, infinities or NaN, which programs may change on the way.
std::uint32_t as_identifier(std::uint32_t hash) {
  const std::uint32_t exponent = hash >> 23 & 255u;
  return exponent == 0 || exponent == 255 ? hash ^ 1u << 23 : hash;
}

std::map<std::string, std::uint32_t> parse_manifest(const std::string& path, const std::string& text) {
  if (holds_nul(text)) refuse_file(path, "the Cryptomatte manifest is damaged: it holds NUL");
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object()) refuse_file(path, "the Cryptomatte manifest is damaged: it is not a JSON object");
  std::map<std::string, std::uint32_t> manifest;
  for (const auto& [name, value] : json.items()) {
    const std::string digits = value.is_string() ? value.get<std::string>() : "";
    if (digits.empty() || digits.size() > 8 || digits.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos)
      refuse_file(path,
                  fmt::format("the Cryptomatte manifest is damaged: \"{}\" is {}, expected up to 8 hexadecimal digits",
                              name, value.dump()));
    manifest[name] = as_identifier(static_cast<std::uint32_t>(std::stoul(digits, nullptr, 16)));
  }
  return manifest;
}

// The text after "cryptomatte/KEY/", by KEY.
std::map<std::string, std::map<std::string, std::string>> cryptomatte_metadata(const ExrFile& file) {
  constexpr std::string_view kPrefix = "cryptomatte/";
  std::map<std::string, std::map<std::string, std::string>> found;
  for (const auto& [name, value] : file.attributes()) {
    const std::size_t slash = name.find('/', kPrefix.size());
    if (!name.starts_with(kPrefix) || slash == std::string::npos) continue;
    found[name.substr(kPrefix.size(), slash - kPrefix.size())][name.substr(slash + 1)] = value;
  }
  return found;
}

bool is_named(const std::string& full_name, const std::string& layer) {
  return full_name == layer || full_name.ends_with("." + layer);
}

Cryptomatte find_cryptomatte(const ExrFile& file, const std::string& layer) {
  std::vector<std::string> names, matches;
  Cryptomatte result;
  for (const auto& [key, values] : cryptomatte_metadata(file)) {
    const auto value = [&values = values](const char* name) {
      const auto found = values.find(name);
      return found == values.end() ? std::string() : found->second;
    };
    names.push_back(value("name"));
    if (!is_named(names.back(), layer)) continue;
    matches.push_back(names.back());
    result = {names.back(), value("hash"), value("conversion"), {}};
    if (!value("manifest").empty()) result.manifest = parse_manifest(file.path(), value("manifest"));
  }
  if (matches.empty())
    refuse_file(file.path(), fmt::format("has no Cryptomatte \"{}\"; it has {}", layer,
                                         names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
  if (matches.size() > 1)
    refuse_file(file.path(), fmt::format("has several Cryptomattes \"{}\": {}; give one's whole name", layer,
                                         fmt::join(matches, ", ")));
  if (!result.conversion.empty() && result.conversion != "uint32_to_float32")
    refuse_file(file.path(), fmt::format("Cryptomatte \"{}\" has conversion \"{}\", expected uint32_to_float32", layer,
                                         result.conversion));
  return result;
}

std::uint32_t identifier_of(const ExrFile& file, const Cryptomatte& cryptomatte, const std::string& name) {
  const auto found = cryptomatte.manifest.find(name);
  if (found != cryptomatte.manifest.end()) return found->second;
  if (!cryptomatte.hash.empty() && cryptomatte.hash != "MurmurHash3_32")
    refuse_file(file.path(), fmt::format("the Cryptomatte manifest has no \"{}\", and its hash is \"{}\", expected "
                                         "MurmurHash3_32",
                                         name, cryptomatte.hash));
  return as_identifier(murmur_hash3(name));
}

// The channels' prefix: the layer as it was asked for, else as the metadata names it, with or without the view layer.
std::string channel_prefix(const ExrFile& file, const Cryptomatte& cryptomatte, const std::string& layer) {
  for (const std::string& prefix : {layer, cryptomatte.name, cryptomatte.name.substr(cryptomatte.name.rfind('.') + 1)})
    if (file.has_channel(prefix + "00.r")) return prefix;
  refuse_file(file.path(), fmt::format("has no channel \"{}00.r\" of its Cryptomatte; it has {}", layer,
                                       fmt::join(file.channels(), ", ")));
}

struct Rank {
  std::vector<float> identifiers, coverages;
};

Rank read_rank(ExrFile& file, const std::string& identifier, const std::string& coverage) {
  Rank rank{file.read(identifier), file.read(coverage)};
  if (!file.is_float(identifier))
    refuse_file(file.path(),
                fmt::format("channel \"{}\" is of half floats, which hold no Cryptomatte identifiers; expected "
                            "32-bit floats",
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

}  // namespace

std::vector<std::vector<float>> read_cryptomatte_coverage(const std::string& path, const std::string& layer,
                                                          const std::vector<std::string>& names) {
  ExrFile file(path);
  const Cryptomatte cryptomatte = find_cryptomatte(file, layer);
  std::vector<std::uint32_t> identifiers;
  for (const std::string& name : names) identifiers.push_back(identifier_of(file, cryptomatte, name));
  const std::string prefix = channel_prefix(file, cryptomatte, layer);
  const std::size_t pixel_count = static_cast<std::size_t>(file.width()) * static_cast<std::size_t>(file.height());
  std::vector<std::vector<float>> coverages(names.size(), std::vector<float>(pixel_count, 0.0f));
  for (int level = 0;; ++level) {
    const std::string level_name = fmt::format("{}{:02}", prefix, level);
    if (!file.has_channel(level_name + ".r")) break;
    add_rank(read_rank(file, level_name + ".r", level_name + ".g"), identifiers, coverages);
    add_rank(read_rank(file, level_name + ".b", level_name + ".a"), identifiers, coverages);
  }
  return coverages;
}

std::vector<std::string> cryptomatte_names(const std::string& path, const std::string& layer) {
  std::vector<std::string> names;
  for (const auto& [name, identifier] : find_cryptomatte(ExrFile(path), layer).manifest) names.push_back(name);
  return names;
}

}  // namespace multum
