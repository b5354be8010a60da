// SPDX-License-Identifier: Apache-2.0
// Reads the attributes from the bytes of the file, not through OpenEXR. The hash therefore also covers types that
// OpenEXR does not know and bits that OpenEXR ignores.
#include "host/formats/asset/header_hash.h"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/foundation/base/files/byte_file.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/exr_survey.h"

namespace multum {
namespace {

constexpr std::size_t kDigitsOfOne = 8;  // number of digits per attribute that show which attribute has changed

struct HeaderAttribute {
  int part;
  std::string name, type, value;
};

// Returns the attributes sorted by part, then by name. Attributes with equal names stay in the order of the file, but
// no writer makes such attributes.
std::vector<HeaderAttribute> header_attributes(const std::string& path) {
  ByteFile file(path);
  std::vector<HeaderAttribute> attributes;
  walk_exr_headers(path, file, [&](const ExrAttribute& found) {
    attributes.push_back({found.part, found.name, found.type, file.bytes(found.position, found.size, "an EXR header")});
  });
  std::stable_sort(attributes.begin(), attributes.end(), [](const HeaderAttribute& a, const HeaderAttribute& b) {
    return a.part != b.part ? a.part < b.part : a.name < b.name;
  });
  return attributes;
}

// Compression changes no value. The header checksum does not cover it, so it remains valid for a recompressed file,
// like the checksum of the pixels.
bool is_covered(const HeaderAttribute& attribute) {
  return attribute.name != "compression" && (attribute.part > 0 || attribute.name != kHeaderHashAttribute);
}

// Adds "PART 0 NAME 0 TYPE 0 SIZE 0 VALUE". Numbers are written as decimal text, so that different attributes give
// different bytes.
void add(const HeaderAttribute& attribute, ContentHash& hash) {
  hash.update(fmt::format("{}{}{}{}{}{}{}{}", attribute.part, '\0', attribute.name, '\0', attribute.type, '\0',
                          attribute.value.size(), '\0'));
  hash.update(attribute.value);
}

std::string hash_text_of(const std::vector<HeaderAttribute>& attributes) {
  ContentHash all;
  std::map<std::string, ContentHash> by_name;
  for (const HeaderAttribute& attribute : attributes) {
    if (!is_covered(attribute)) continue;
    add(attribute, all);
    add(attribute, by_name[attribute.name]);
  }
  std::string text = all.finish();
  for (auto& [name, hash] : by_name) text += fmt::format(" {}={}", name, hash.finish().substr(0, kDigitsOfOne));
  return text;
}

// Returns the names whose digests differ between the two texts.
std::set<std::string> differing_names(const std::string& found, const std::string& stated) {
  const auto entries = [](const std::string& text) {
    std::istringstream words(text);
    std::set<std::string> all;
    for (std::string word; words >> word;)
      if (word.find('=') != std::string::npos) all.insert(word);
    return all;
  };
  const std::set<std::string> here = entries(found), there = entries(stated);
  std::set<std::string> names;
  for (const auto& [one, other] : {std::pair(&here, &there), std::pair(&there, &here)})
    for (const std::string& entry : *one)
      if (!other->contains(entry)) names.insert(entry.substr(0, entry.rfind('=')));
  return names;
}

// Recognizes the checksum even if its name or type is damaged. Otherwise the file would count as a file without a
// checksum. No other attribute holds such text.
bool looks_like_it(const HeaderAttribute& attribute) {
  return attribute.name == kHeaderHashAttribute || attribute.value.find(" multum:representation=") != std::string::npos;
}

}  // namespace

std::string header_hash_text(const std::string& path) { return hash_text_of(header_attributes(path)); }

VerifyFinding header_finding(const std::string& path) {
  const std::vector<HeaderAttribute> attributes = header_attributes(path);
  const auto stated = std::find_if(attributes.begin(), attributes.end(), looks_like_it);
  if (stated == attributes.end())
    return {"header", true,
            fmt::format("the file has no {}, which older programs do not write, so its attributes cannot be checked",
                        kHeaderHashAttribute)};
  if (stated->part != 0 || stated->name != kHeaderHashAttribute || stated->type != "string")
    return {"header", false,
            fmt::format("checksum '{}' is in part {} (type {}), expected {} in part 0 (type string)", stated->name,
                        stated->part, stated->type, kHeaderHashAttribute)};
  const std::string found = hash_text_of(attributes);
  const std::string expected = stated->value.substr(0, stated->value.find_last_not_of(' ') + 1);
  if (found == expected) return {"header", true, found.substr(0, found.find(' '))};
  const std::set<std::string> names = differing_names(found, expected);
  if (names.empty()) return {"header", false, fmt::format("{} itself was changed", kHeaderHashAttribute)};
  return {"header", false,
          fmt::format("changed attributes: {}; they no longer match {}", fmt::join(names, ", "), kHeaderHashAttribute)};
}

}  // namespace multum
