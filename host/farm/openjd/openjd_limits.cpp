// SPDX-License-Identifier: Apache-2.0
#include "host/farm/openjd/openjd_limits.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <vector>

#include "host/foundation/base/error.h"
#include "host/foundation/base/shown_text.h"

namespace multum {
namespace {

using Json = nlohmann::ordered_json;

// The limits, each with its section of the specification. Lengths are in Unicode characters.
constexpr std::size_t kJobNameMax = 128;         // 1.1.1
constexpr std::size_t kExtensionNameMax = 128;   // 1.1.2, where the minimum is 3
constexpr std::size_t kValueMax = 1024;          // 2.5
constexpr std::size_t kStepNameMax = 64;         // 3.1
constexpr std::size_t kRequirementsMax = 50;     // 3.3
constexpr std::size_t kCapabilityNameMax = 100;  // 3.3.1.1
constexpr std::size_t kTaskParametersMax = 16;   // 3.4
constexpr std::size_t kRangeElementsMax = 1024;  // section 3.4.1.1: elements of a list
constexpr std::int64_t kNoticeSecondsMax = 600;  // 5.3.2
constexpr std::size_t kIdentifierMax = 64;       // 7.1
constexpr std::size_t kDescriptionMax = 2048;    // 7.2

[[noreturn]] void refuse(const std::string& what, const std::string& found, const std::string& expected) {
  throw Error(ErrorCode::kUsage,
              fmt::format("{}: {}, expected {} (Open Job Description 2023-09)", what, found, expected));
}

// Returns the characters of a UTF-8 text, or nullopt if the text is not UTF-8.
std::optional<std::u32string> characters_of(const std::string& text) {
  std::u32string characters;
  for (std::size_t at = 0, length = 0; at < text.size(); at += length) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[at + i]); };
    length = character_length(text, at);
    if (length == 0) return std::nullopt;
    char32_t value = length == 1 ? byte(0) : byte(0) & (0xffu >> (length + 1));
    for (std::size_t i = 1; i < length; ++i) value = value << 6 | (byte(i) & 0x3fu);
    characters += value;
  }
  return characters;
}

// Unicode's category Cc, which consists of C0, DEL and C1 (section 9).
bool is_control(char32_t c) { return c < 0x20 || (c >= 0x7f && c < 0xa0); }

// The rules that one kind of text must follow.
struct TextRule {
  std::size_t least = 1;
  std::size_t most = std::string::npos;
  bool has_lines = false;  // allows newline, carriage return and tab
  bool is_any = false;     // allows any character
};

void check_text(const std::string& what, const std::string& text, const TextRule& rule) {
  const std::optional<std::u32string> characters = characters_of(text);
  if (!characters) refuse(what, "is not UTF-8", "UTF-8 text: give it another name");
  if (characters->size() < rule.least) refuse(what, "is empty", fmt::format("at least {} character", rule.least));
  if (characters->size() > rule.most)
    refuse(what, fmt::format("has {} characters", characters->size()), fmt::format("at most {}", rule.most));
  for (const char32_t c : *characters) {
    const bool is_line = c == '\n' || c == '\r' || c == '\t';
    if (!rule.is_any && is_control(c) && !(rule.has_lines && is_line))
      refuse(what, fmt::format("holds the control character U+{:04X}", static_cast<std::uint32_t>(c)),
             "no control character: give it another name");
  }
}

void check_identifier(const std::string& what, const std::string& name) {
  static const std::regex kForm("[A-Za-z_][A-Za-z0-9_]*");
  check_text(what, name, {1, kIdentifierMax});
  if (!std::regex_match(name, kForm)) refuse(what, "is " + name, "letters, digits and _, not beginning with a digit");
}

void check_count(const std::string& what, std::size_t count, std::size_t least, std::size_t most) {
  if (count < least || count > most)
    refuse(what, fmt::format("has {} elements", count), fmt::format("{} to {}", least, most));
}

void check_choice(const std::string& what, const std::string& value, const std::set<std::string>& choices) {
  if (!choices.contains(value)) refuse(what, "is " + value, "a value of the specification");
}

// Section 7.3: {{ opens a reference and }} closes it. Neither can be escaped. `values` holds the values of the
// references.
std::string resolved(const std::string& what, const std::string& text,
                     const std::map<std::string, std::string>& values) {
  std::string result;
  for (std::size_t at = 0;;) {
    const std::size_t opens = text.find("{{", at), closes = text.find("}}", at);
    if (opens == std::string::npos && closes == std::string::npos) return result + text.substr(at);
    if (opens == std::string::npos || closes == std::string::npos || closes < opens)
      refuse(what, "holds {{ or }}, which mark a reference: " + text, "another name");
    std::string name = text.substr(opens + 2, closes - opens - 2);
    name.erase(0, name.find_first_not_of(' '));
    name.erase(name.find_last_not_of(' ') + 1);
    const auto found = values.find(name);
    if (found == values.end()) refuse(what, "refers to '" + name + "', which is not defined: " + text, "another name");
    result += text.substr(at, opens - at) + found->second;
    at = closes + 2;
  }
}

std::string text_of(const Json& object, const char* key) { return object.at(key).get<std::string>(); }

// The bundle's parameters with their values, by reference name.
class Checker {
 public:
  Checker(const Json& job, const Json& values) : job_(job), values_(values) {}

  void run() {
    check_choice("specificationVersion", text_of(job_, "specificationVersion"), {"jobtemplate-2023-09"});
    if (job_.contains("extensions")) check_extensions();
    check_description("template", job_);
    check_parameters();
    check_values();
    // The name must not contain a path parameter, because only a running task knows the parameter's value.
    check_text("the job's name (--name)", resolved("the job's name (--name)", text_of(job_, "name"), {}),
               {1, kJobNameMax});
    const Json& steps = job_.at("steps");
    check_count("steps", steps.size(), 1, std::string::npos);
    for (const Json& step : steps) check_step(step);
  }

 private:
  void check_extensions() {
    static const std::regex kForm("[A-Z_0-9]*");
    check_count("extensions", job_.at("extensions").size(), 1, std::string::npos);
    for (const Json& extension : job_.at("extensions")) {
      const std::string name = extension.get<std::string>();
      check_text("an extension's name", name, {3, kExtensionNameMax});
      if (!std::regex_match(name, kForm)) refuse("an extension's name", "is " + name, "capitals, digits and _");
      extensions_.insert(name);
    }
  }

  void check_description(const std::string& what, const Json& of) {
    if (of.contains("description"))
      check_text(what + ": description", text_of(of, "description"), {1, kDescriptionMax, true});
  }

  void check_parameters() {
    if (!job_.contains("parameterDefinitions")) return;
    const Json& parameters = job_.at("parameterDefinitions");
    check_count("parameterDefinitions", parameters.size(), 1, kOpenJdParametersMax);
    for (const Json& parameter : parameters) {
      const std::string name = text_of(parameter, "name"), what = "parameter " + name;
      check_identifier(what, name);
      check_choice(what + ": type", text_of(parameter, "type"), {"PATH", "STRING"});
      check_description(what, parameter);
      if (parameter.contains("objectType"))
        check_choice(what + ": objectType", text_of(parameter, "objectType"), {"FILE", "DIRECTORY"});
      if (parameter.contains("dataFlow"))
        check_choice(what + ": dataFlow", text_of(parameter, "dataFlow"), {"NONE", "IN", "OUT", "INOUT"});
      const std::string value = parameter.contains("default") ? text_of(parameter, "default") : "";
      check_text(what + ": default", value, {0, kValueMax, false, true});
      if (!references_.emplace("Param." + name, value).second) refuse(what, "occurs twice", "a name of its own");
      if (!parameter.contains("default")) without_value_.insert(name);
    }
  }

  void check_values() {
    for (const Json& one : values_.at("parameterValues")) {
      const std::string name = text_of(one, "name"), value = text_of(one, "value");
      const auto found = references_.find("Param." + name);
      if (found == references_.end())
        refuse("value of " + name, "belongs to an unknown parameter", "a parameter of the template");
      check_text(value, value, {0, kValueMax, false, true});
      found->second = value;
      without_value_.erase(name);
    }
    if (!without_value_.empty()) refuse("parameter " + *without_value_.begin(), "has no value", "a value");
  }

  void check_step(const Json& step) {
    const std::string name = text_of(step, "name"), what = "step " + name;
    check_text("a step's name", name, {1, kStepNameMax});
    check_description(what, step);
    if (step.contains("dependencies")) {
      check_count(what + ": dependencies", step.at("dependencies").size(), 1, std::string::npos);
      // In templates of multum, a step depends only on earlier steps, so there are no cycles.
      for (const Json& one : step.at("dependencies"))
        if (!steps_.contains(text_of(one, "dependsOn")))
          refuse(what, "depends on " + text_of(one, "dependsOn"), "a step before it");
    }
    if (!steps_.insert(name).second) refuse(what, "occurs twice", "a name of its own");
    if (step.contains("hostRequirements")) check_requirements(what, step.at("hostRequirements"));
    std::map<std::string, std::string> references = references_;
    if (step.contains("parameterSpace")) add_task_parameters(what, step.at("parameterSpace"), references);
    check_action(what, step.at("script").at("actions").at("onRun"), references);
  }

  void check_requirements(const std::string& what, const Json& requirements) {
    static const std::regex kForm("([A-Za-z_][A-Za-z0-9_]*:)?amount(\\.[A-Za-z_][A-Za-z0-9_]*)+");
    const Json& amounts = requirements.at("amounts");
    check_count(what + ": hostRequirements", amounts.size(), 1, kRequirementsMax);
    std::set<std::string> names;
    for (const Json& amount : amounts) {
      const std::string name = text_of(amount, "name");
      check_text(what + ": " + name, name, {1, kCapabilityNameMax});
      if (!std::regex_match(name, kForm) || !names.insert(name).second)
        refuse(what, "requires " + name, "amount.NAME.NAME, each once");
      const double least = name == "amount.worker.vcpu" ? 1.0 : 0.0;
      if (!amount.contains("min") || !std::isfinite(amount.at("min").get<double>()) ||
          amount.at("min").get<double>() < least)
        refuse(what + ": " + name, "has an invalid minimum", fmt::format("a number from {:g}", least));
    }
  }

  void add_task_parameters(const std::string& what, const Json& space, std::map<std::string, std::string>& references) {
    const Json& parameters = space.at("taskParameterDefinitions");
    check_count(what + ": taskParameterDefinitions", parameters.size(), 1, kTaskParametersMax);
    std::size_t chunked = 0;
    for (const Json& parameter : parameters) {
      const std::string name = text_of(parameter, "name"), type = text_of(parameter, "type"), own = what + ": " + name;
      check_identifier(own, name);
      check_choice(own + ": type", type, {"INT", "CHUNK[INT]"});
      const std::string first = check_range(own, parameter.at("range"));
      if (type == "CHUNK[INT]") check_chunks(own, parameter.at("chunks"), ++chunked);
      if (!references.emplace("Task.Param." + name, first).second) refuse(own, "occurs twice", "a name of its own");
    }
  }

  // Returns the first value. Expressions are separated by commas and must not overlap (section 3.4.1.1.1).
  std::string check_range(const std::string& what, const Json& range) {
    if (range.is_array()) {
      check_count(what + ": range", range.size(), 1, kRangeElementsMax);
      return range.front().dump();
    }
    static const std::regex kForm("(\\d{1,9})(-(\\d{1,9}))?");
    std::smatch found;
    const std::string text = range.get<std::string>();
    if (!std::regex_match(text, found, kForm) || (found[3].matched && std::stol(found[1]) > std::stol(found[3])))
      refuse(what + ": range", "is " + text, "FIRST-LAST");
    return found[1];
  }

  void check_chunks(const std::string& what, const Json& chunks, std::size_t number) {
    if (!extensions_.contains("TASK_CHUNKING")) refuse(what, "has chunks", "the extension TASK_CHUNKING");
    if (number > 1) refuse(what, "is the second parameter with chunks", "one per step");
    if (chunks.at("defaultTaskCount").get<std::int64_t>() < 1)
      refuse(what + ": defaultTaskCount", "is " + chunks.at("defaultTaskCount").dump(), "1 or more");
    if (chunks.contains("targetRuntimeSeconds") && chunks.at("targetRuntimeSeconds").get<std::int64_t>() < 0)
      refuse(what + ": targetRuntimeSeconds", "is " + chunks.at("targetRuntimeSeconds").dump(), "0 or more");
    check_choice(what + ": rangeConstraint", text_of(chunks, "rangeConstraint"), {"CONTIGUOUS", "NONCONTIGUOUS"});
  }

  // Sections 5.1 and 5.2: a command and its words must not contain control characters, even after parameters are
  // inserted.
  void check_action(const std::string& what, const Json& action, const std::map<std::string, std::string>& references) {
    check_text(what + ": command", resolved(what + ": command", text_of(action, "command"), references), {});
    if (action.contains("args"))
      for (const Json& word : action.at("args")) {
        const std::string text = word.get<std::string>(), with_values = resolved(text, text, references);
        check_text(with_values, with_values, {0});
      }
    if (action.contains("timeout") && action.at("timeout").get<std::int64_t>() < 1)
      refuse(what + ": timeout", "is " + action.at("timeout").dump(), "1 or more");
    if (!action.contains("cancelation")) return;
    const Json& cancelation = action.at("cancelation");
    check_choice(what + ": mode", text_of(cancelation, "mode"), {"TERMINATE", "NOTIFY_THEN_TERMINATE"});
    if (!cancelation.contains("notifyPeriodInSeconds")) return;
    const auto seconds = cancelation.at("notifyPeriodInSeconds").get<std::int64_t>();
    if (seconds < 1 || seconds > kNoticeSecondsMax)
      refuse(what + ": notifyPeriodInSeconds", fmt::format("is {}", seconds),
             fmt::format("1 to {}", kNoticeSecondsMax));
  }

  const Json& job_;
  const Json& values_;
  std::set<std::string> extensions_, steps_, without_value_;
  std::map<std::string, std::string> references_;
};

}  // namespace

void check_openjd_text(const std::string& what, const std::string& text) {
  check_text(what, text, {0, std::string::npos, false, true});
}

void check_openjd_limits(const Json& job_template, const Json& parameter_values) {
  Checker(job_template, parameter_values).run();
}

}  // namespace multum
