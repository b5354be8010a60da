// SPDX-License-Identifier: Apache-2.0
// Escapes names and reasons for XML and Markdown. File names may contain any byte except '/' and NUL. XML 1.0 allows
// only valid UTF-8 without most control characters, and punctuation has a meaning in Markdown.
#include "host/bakes/manifest/manifest_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

constexpr char kReplacement[] = "\xEF\xBF\xBD";  // U+FFFD, for invalid characters

// Returns the length of the UTF-8 sequence that begins at `at`, or 0 if it is invalid or not allowed in XML 1.0.
// Overlong forms, surrogates, characters beyond U+10FFFF, U+FFFE and U+FFFF are not allowed.
std::size_t character_length(const std::string& text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const std::uint32_t first = byte(at);
  if (first < 0x80) return first >= 0x20 || first == '\t' || first == '\n' || first == '\r' ? 1 : 0;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : first >= 0xC0 ? 2 : 0;
  if (length == 0 || first > 0xF4) return 0;
  std::uint32_t code = first & (0xFFu >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(at + i) & 0xC0u) != 0x80u) return 0;
    code = code << 6 | (byte(at + i) & 0x3Fu);
  }
  static constexpr std::array<std::uint32_t, 5> kLeast = {0, 0, 0x80, 0x800, 0x10000};
  const bool is_valid = code >= kLeast[length] && code <= 0x10FFFF && !(code >= 0xD800 && code <= 0xDFFF) &&
                        code != 0xFFFE && code != 0xFFFF;
  return is_valid ? length : 0;
}

// Copies characters. `escape` replaces characters of one byte.
template <typename Escape>
std::string escaped(const std::string& name_or_reason, const Escape& escape) {
  const std::string text = text_of_path(name_or_reason);  // without bytes that are not UTF-8
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = character_length(text, at);
    if (length == 0) result += kReplacement;
    else if (length == 1) result += escape(text[at]);
    else result += text.substr(at, length);
    at += std::max<std::size_t>(1, length);
  }
  return result;
}

// Escapes the contents of elements, and attributes in double quotes. In attributes, parsers would convert tabs and line
// ends to spaces.
std::string xml(const std::string& text) {
  return escaped(text, [](char c) -> std::string {
    switch (c) {
      case '&': return "&amp;";
      case '<': return "&lt;";
      case '>': return "&gt;";
      case '"': return "&quot;";
      case '\'': return "&apos;";
      case '\t':
      case '\n':
      case '\r': return fmt::format("&#{};", static_cast<int>(c));
      default: return std::string(1, c);
    }
  });
}

// Escapes one line of a list, or a cell of a table.
std::string markdown(const std::string& text) {
  static const std::string kPunctuation = "\\`*_[]<>|~#&!$";
  return escaped(text, [](char c) -> std::string {
    if (c == '\t' || c == '\n' || c == '\r') return " ";
    return (kPunctuation.find(c) != std::string::npos ? "\\" : "") + std::string(1, c);
  });
}

std::string one_line(const std::string& text) {
  return escaped(text, [](char c) { return std::string(1, c == '\t' || c == '\n' || c == '\r' ? ' ' : c); });
}

std::string percent_or_dash(const std::optional<double>& error) {
  return error ? fmt::format("{:.4g} %", 100.0 * *error) : "-";
}

std::string maps(std::size_t count) { return fmt::format("{} {}", count, count == 1 ? "map" : "maps"); }

std::size_t count_of(const ManifestOutcome& outcome, MapState state) {
  return static_cast<std::size_t>(std::count_if(outcome.results.begin(), outcome.results.end(),
                                                [&](const MapResult& result) { return result.state == state; }));
}

// Counts maps by state, as in "1 stale, 1 worse". Counts either the maps that are in place or the other maps.
std::string counts(const ManifestOutcome& outcome, bool in_place) {
  std::vector<std::string> parts;
  for (int s = 0; s < kMapStateCount; ++s) {
    const auto state = static_cast<MapState>(s);
    const std::size_t count = count_of(outcome, state);
    if (count > 0 && is_in_place(state) == in_place)
      parts.push_back(fmt::format("{} {}", count, map_state_name(state)));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::size_t failure_count(const ManifestOutcome& outcome) {
  return outcome.results.size() - count_of(outcome, MapState::kUnchanged) - count_of(outcome, MapState::kBaked);
}

std::string properties_xml(const MapResult& result) {
  std::string text;
  const auto add = [&](const char* name, const std::string& value) {
    text += fmt::format("        <property name=\"{}\" value=\"{}\"/>\n", name, value);
  };
  add("state", map_state_name(result.state));
  if (result.error) add("error_measured", fmt::format("{:.6g}", *result.error));
  if (result.stated) add("error_stated", fmt::format("{:.6g}", *result.stated));
  if (result.allowed) add("error_max", fmt::format("{:.6g}", *result.allowed));
  add("bytes", fmt::format("{}", result.bytes));
  return "      <properties>\n" + text + "      </properties>\n";
}

std::string case_xml(const ManifestOutcome& outcome, const MapResult& result) {
  std::string text = fmt::format("    <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\">\n", xml(outcome.manifest),
                                 xml(result.name), result.seconds);
  text += properties_xml(result);
  if (!is_in_place(result.state)) {
    const char* element = result.state == MapState::kFailed ? "error" : "failure";
    text += fmt::format("      <{0} type=\"{1}\" message=\"{2}\">{3}: {2}</{0}>\n", element,
                        map_state_name(result.state), xml(result.why), xml(result.name));
  }
  return text + "    </testcase>\n";
}

}  // namespace

std::string manifest_verdict(const ManifestOutcome& outcome) {
  const std::string command = std::string("multum bake") + (outcome.settings.check ? " --check" : "");
  const std::size_t failures = failure_count(outcome);
  if (failures == 0)
    return fmt::format("{}: passed, {} in place: {}", command, maps(outcome.results.size()), counts(outcome, true));
  return fmt::format("{}: FAILED for {} of {}: {}", command, failures, maps(outcome.results.size()),
                     counts(outcome, false));
}

std::string manifest_failures(const ManifestOutcome& outcome) {
  if (failure_count(outcome) == 0) return "";
  std::string text = manifest_verdict(outcome) + "\n";
  for (const MapResult& result : outcome.results)
    if (!is_in_place(result.state))
      text +=
          fmt::format("  {:<8} {}: {}\n", map_state_name(result.state), one_line(result.name), one_line(result.why));
  return text;
}

std::string manifest_junit(const ManifestOutcome& outcome) {
  const std::size_t errors = count_of(outcome, MapState::kFailed), failures = failure_count(outcome) - errors;
  const std::string figures = fmt::format("tests=\"{}\" failures=\"{}\" errors=\"{}\" time=\"{:.3f}\"",
                                          outcome.results.size(), failures, errors, outcome.seconds);
  std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  text += fmt::format("<testsuites name=\"multum bake\" {}>\n", figures);
  text += fmt::format("  <testsuite name=\"{}\" {} skipped=\"0\">\n", xml(outcome.manifest), figures);
  for (const MapResult& result : outcome.results) text += case_xml(outcome, result);
  return text + "  </testsuite>\n</testsuites>\n";
}

std::string manifest_summary(const ManifestOutcome& outcome) {
  std::string text = fmt::format("**{}**\n\n", markdown(manifest_verdict(outcome)));
  text += "| map | state | error | stated | allowed | seconds | bytes |\n|---|---|---:|---:|---:|---:|---:|\n";
  for (const MapResult& result : outcome.results)
    text +=
        fmt::format("| {} | {} | {} | {} | {} | {:.2f} | {} |\n", markdown(result.name), map_state_name(result.state),
                    percent_or_dash(result.error), percent_or_dash(result.stated), percent_or_dash(result.allowed),
                    result.seconds, result.bytes > 0 ? fmt::format("{}", result.bytes) : "-");
  text += "\nErrors are relative L1 errors of pixels. Each error is the highest of all BRDFs.\n";
  if (failure_count(outcome) > 0) text += "\n";
  for (const MapResult& result : outcome.results)
    if (!is_in_place(result.state))
      text += fmt::format("- {}: {}: {}\n", map_state_name(result.state), markdown(result.name), markdown(result.why));
  return text;
}

int manifest_exit_code(const ManifestOutcome& outcome) {
  for (const MapResult& result : outcome.results)
    if (result.state == MapState::kFailed) return exit_code(result.failure);
  return failure_count(outcome) > 0 ? exit_code(ErrorCode::kVerification) : 0;
}

}  // namespace multum
