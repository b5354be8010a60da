// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/brdf_families/brdf_forms.h"

#include <fmt/format.h>

#include <vector>

namespace multum {
namespace {

// Returns the families that have a text form other than a file.
std::vector<const BrdfFamily*> named_families() {
  std::vector<const BrdfFamily*> families;
  for (const BrdfFamily& family : brdf_families())
    if (!family.is_file) families.push_back(&family);
  return families;
}

std::string form_of(const BrdfFamily& family, bool with_f0) {
  std::string text(family.name);
  if (family.has_width()) text += fmt::format(":{}", family.members[0].symbol);
  return text + (with_f0 && family.has_f0() ? fmt::format("[,{}]", family.members.back().symbol) : "");
}

}  // namespace

std::string brdf_forms(std::string_view last, bool with_f0) {
  const std::vector<const BrdfFamily*> families = named_families();
  std::string text;
  for (const BrdfFamily* family : families) {
    if (!text.empty()) text += family == families.back() && !last.empty() ? fmt::format(" {} ", last) : ", ";
    text += form_of(*family, with_f0);
  }
  return text;
}

std::string expected_brdf() {
  std::string text;
  for (const BrdfFamily* family : named_families()) {
    text += form_of(*family, true);
    if (family->has_width()) {
      const BrdfMember& width = family->members[0];
      text += fmt::format(" with {} {:g}..{}{}{}", width.symbol, width.low, width.high, width.unit.empty() ? "" : " ",
                          width.unit);
    }
    text += ", ";
  }
  return text + "or the file of a measured BRDF (F0 0..1, grey or r,g,b)";
}

std::string range_text(const BrdfMember& member) {
  return fmt::format("{} from {:g} to {:g}", member.unit.empty() ? "a number" : member.unit, member.low, member.high);
}

const std::string& brdf_pattern() {
  static const std::string pattern = [] {
    std::string names, with_numbers;
    for (const BrdfFamily* family : named_families()) {
      std::string& text = family->has_width() ? with_numbers : names;
      text += fmt::format("{}{}", text.empty() ? "" : "|", family->name);
    }
    return fmt::format("^({}|({}):[0-9.,eE+-]{{1,60}})$", names, with_numbers);
  }();
  return pattern;
}

}  // namespace multum
