// SPDX-License-Identifier: Apache-2.0
#include "host/formats/brdf/brdf_text.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <vector>

#include "host/formats/brdf/measured_file.h"
#include "host/foundation/base/error.h"
#include "host/foundation/brdf_families/brdf_forms.h"

namespace multum {
namespace {

// Returns the numbers in `text`, or an empty list if a word is not a number.
std::vector<float> numbers_of(std::string_view text) {
  std::vector<float> numbers;
  for (;;) {
    const std::string_view word = text.substr(0, text.find(','));
    float value = 0.0f;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) return {};
    numbers.push_back(value);
    if (word.size() == text.size()) return numbers;
    text.remove_prefix(word.size() + 1);
  }
}

// Reads the width of the family, then F0 if the family has it. Returns false if the text does not match.
bool read_members(const BrdfFamily& family, std::string_view text, Brdf& brdf) {
  const BrdfMember& width = family.members[0];
  const std::vector<float> n = numbers_of(text);
  if (n.empty() || !(n[0] >= static_cast<float>(width.low) && n[0] <= static_cast<float>(width.high))) return false;
  if (n.size() != 1 && !(family.has_f0() && (n.size() == 2 || n.size() == 4))) return false;
  width_of(family, brdf) = n[0];
  if (n.size() == 1) return true;
  brdf.f0 = n.size() == 2 ? glm::vec3(n[1]) : glm::vec3(n[1], n[2], n[3]);
  for (int i = 0; i < 3; ++i)
    if (!(brdf.f0[i] >= 0.0f && brdf.f0[i] <= 1.0f)) return false;
  return true;
}

// Returns the family that a text names. The text is either only the name, or "NAME:" and members.
const BrdfFamily* family_of_text(std::string_view text) {
  const std::size_t name = text.find(':');
  const BrdfFamily* const family = find_brdf_family(text.substr(0, name));
  const bool is_named = family != nullptr && !family->is_file && family->has_width() == (name != text.npos);
  return is_named ? family : nullptr;
}

std::string colour_text(const glm::vec3& c) { return fmt::format("{:.6g},{:.6g},{:.6g}", c.x, c.y, c.z); }

}  // namespace

bool is_brdf_file(const std::string& text) { return family_of_text(text) == nullptr; }

std::string measuring_refusal(const Brdf& brdf) {
  const BrdfFamily& family = family_of(brdf);
  if (!is_vmf_sum(brdf) || width_of(brdf) >= static_cast<float>(family.sum_from)) return "";
  return fmt::format(
      "found {}, whose highlight cannot be fitted by a sum of vMFs, so errors cannot be measured; expected {} of at "
      "least {:g}",
      brdf_text(brdf, ""), family.members[0].symbol, family.sum_from);
}

std::string environment_refusal(const Brdf& brdf) {
  if (!family_of(brdf).lights_alone) return "";
  return fmt::format("found {} with an environment: expected only lights, or another BRDF", brdf_text(brdf, ""));
}

void set_family(const BrdfFamily& family, Brdf& brdf) {
  brdf.kind = family.kind;
  brdf.specular = glm::vec3(family.specular);
}

void set_measured(const std::string& path, Brdf& brdf) {
  brdf.measured = std::make_shared<const MeasuredBrdf>(read_measured_brdf(path));
  brdf.diffuse = glm::vec3(brdf.measured->diffuse);
}

Brdf parse_brdf(const std::string& option, const std::string& text, int term_count) {
  Brdf brdf;
  brdf.term_count = term_count;
  const auto refuse = [&] {
    throw Error(ErrorCode::kUsage, fmt::format("{} '{}': expected {}", option, text, expected_brdf()));
  };
  if (const BrdfFamily* family = family_of_text(text)) {
    set_family(*family, brdf);
    if (family->has_width() && !read_members(*family, std::string_view(text).substr(family->name.size() + 1), brdf))
      refuse();
  } else if (std::filesystem::exists(text)) {
    set_family(brdf_family(BrdfKind::kMeasured), brdf);
    set_measured(text, brdf);
  } else {
    refuse();
  }
  return brdf;
}

std::string brdf_text(const Brdf& brdf, const std::string& measured_file) {
  const BrdfFamily& family = family_of(brdf);
  if (family.is_file) return measured_file;
  std::string text(family.name);
  if (family.has_width()) text += fmt::format(":{:.7g}", width_of(brdf));
  return text + (family.has_f0() ? "," + colour_text(brdf.f0) : "");
}

}  // namespace multum
