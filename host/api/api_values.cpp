// SPDX-License-Identifier: Apache-2.0
#include "host/api/api_values.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <string>

#include "host/api/api_error.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/parameters/parameter_tables.h"

namespace multum {
namespace {

constexpr std::array kCommands = {"bake", "export", "gltf", "infer", "pack"};
constexpr char kThreads[] = "threads";
constexpr int kThreadsMax = 1024;
// Command-line parameters that have another form in the library. These are positional arguments and the device.
constexpr std::array kArguments = {"input", "output", "device", "scalar", "runstats"};

bool is_argument(const std::string& name) {
  for (const char* argument : kArguments)
    if (name == argument) return true;
  return false;
}

const ParameterTable* find_table(const char* command) {
  for (const char* known : kCommands)
    if (command != nullptr && std::strcmp(command, known) == 0) return find_parameter_table(command);
  return nullptr;
}

const Parameter& row_of(const multum_values& values, const char* name) {
  require(name, "multum_values_set", "name", "the name of a setting");
  const ParameterTable& table = values.values.table();
  if (const Parameter* row = table.find(name); row != nullptr && !is_argument(name)) return *row;
  std::string names;
  for (const Parameter& row : table.rows())
    if (!is_argument(row.name)) names += (names.empty() ? "" : ", ") + row.name;
  throw Error(ErrorCode::kUsage, std::string("setting '") + name + "' is unknown for " + table.command() +
                                     ", expected " + kThreads + ", " + names);
}

[[noreturn]] void refuse(const Parameter& row, const std::string& found) {
  throw Error(ErrorCode::kUsage, row.name + " is " + found + ", expected " + expected_text(row));
}

// Returns the number, or 0 for any other text.
double number_of(const char* text) {
  double number = 0.0;
  const char* const end = text + std::strlen(text);
  const auto [rest, error] = std::from_chars(text, end, number);
  return error == std::errc() && rest == end ? number : 0.0;
}

void set_threads(multum_values& values, double count, const std::string& found) {
  if (!(count >= 1 && count <= kThreadsMax) || count != std::floor(count))
    throw Error(ErrorCode::kUsage,
                std::string("threads is ") + found + ", expected an integer from 1 to " + std::to_string(kThreadsMax));
  values.threads = static_cast<int>(count);
}

void set_number(multum_values& values, const char* name, double number) {
  if (std::strcmp(name, kThreads) == 0) return set_threads(values, number, std::to_string(number));
  const Parameter& row = row_of(values, name);
  const bool is_whole = row.kind == ParameterKind::kInteger || row.kind == ParameterKind::kBytes;
  if (!row.is_numeric() || (is_whole && (number != std::floor(number) || std::fabs(number) > 9e15)))
    refuse(row, value_text(number));
  values.values.set(name, is_whole ? ParameterValue(static_cast<std::int64_t>(number)) : ParameterValue(number));
}

void set_text(multum_values& values, const char* name, const char* text) {
  if (std::strcmp(name, kThreads) == 0) return set_threads(values, number_of(text), text);
  const Parameter& row = row_of(values, name);
  if (row.kind == ParameterKind::kFlag) {
    if (std::strcmp(text, "true") != 0 && std::strcmp(text, "false") != 0) refuse(row, text);
    return values.values.set(name, std::strcmp(text, "true") == 0);
  }
  const std::optional<ParameterValue> value = parse_value(row, text);
  if (!value) refuse(row, text);
  values.values.set(name, *value);
}

}  // namespace

ParameterValues values_of(const multum_values* values, const ParameterTable& table) {
  if (values == nullptr) return ParameterValues(table);
  if (&values->values.table() != &table)
    throw Error(ErrorCode::kUsage, "values are settings of " + values->values.table().command() +
                                       ", expected those of " + table.command());
  return values->values;
}

int threads_of(const multum_values* values) {
  return values != nullptr && values->threads ? *values->threads : processor_count();
}

}  // namespace multum

using multum::guarded;

multum_status multum_values_new(const char* command, multum_values** values, multum_error** error) {
  return guarded(error, [&] {
    multum::require(values, "multum_values_new", "values", "a place for the result");
    const multum::ParameterTable* const table = multum::find_table(command);
    if (table == nullptr)
      throw multum::Error(multum::ErrorCode::kUsage, std::string("command is '") + (command == nullptr ? "" : command) +
                                                         "', expected bake, export, gltf, infer or pack");
    *values = new multum_values{multum::ParameterValues(*table), std::nullopt};
  });
}

void multum_values_free(multum_values* values) { delete values; }

multum_status multum_values_set_text(multum_values* values, const char* name, const char* value, multum_error** error) {
  return guarded(error, [&] {
    multum::require(values, "multum_values_set_text", "values", "values of multum_values_new()");
    multum::require(name, "multum_values_set_text", "name", "the name of a setting");
    multum::require(value, "multum_values_set_text", "value", "a text");
    multum::set_text(*values, name, value);
  });
}

multum_status multum_values_set_number(multum_values* values, const char* name, double value, multum_error** error) {
  return guarded(error, [&] {
    multum::require(values, "multum_values_set_number", "values", "values of multum_values_new()");
    multum::require(name, "multum_values_set_number", "name", "the name of a setting");
    multum::set_number(*values, name, value);
  });
}

multum_status multum_values_set_flag(multum_values* values, const char* name, int value, multum_error** error) {
  return guarded(error, [&] {
    multum::require(values, "multum_values_set_flag", "values", "values of multum_values_new()");
    const multum::Parameter& row = multum::row_of(*values, name);
    if (row.kind != multum::ParameterKind::kFlag) multum::refuse(row, value != 0 ? "true" : "false");
    values->values.set(name, value != 0);
  });
}

namespace multum {
namespace {

struct ParameterTexts {
  std::string name, help, values;
};

// The texts of all settings. They are made at the first call and never changed, so that callers may keep the pointers.
const std::vector<ParameterTexts>& parameter_texts(const ParameterTable& table) {
  static std::mutex mutex;
  static std::map<const ParameterTable*, std::vector<ParameterTexts>> all;
  const std::lock_guard lock(mutex);
  if (const auto found = all.find(&table); found != all.end()) return found->second;
  std::vector<ParameterTexts> texts;
  for (const Parameter& row : table.rows())
    if (!is_argument(row.name)) texts.push_back({row.name, row.help, values_text(row)});
  texts.push_back({kThreads, "work with this many threads", "an integer from 1 to 1024, default: all cores"});
  return all.emplace(&table, std::move(texts)).first->second;
}

}  // namespace
}  // namespace multum

int multum_parameter_count(const char* command) {
  int count = 0;
  guarded(nullptr, [&] {
    if (const multum::ParameterTable* table = multum::find_table(command))
      count = static_cast<int>(multum::parameter_texts(*table).size());
  });
  return count;
}

multum_parameter multum_parameter_at(const char* command, int index) {
  multum_parameter result = {"", "", ""};
  guarded(nullptr, [&] {
    const multum::ParameterTable* const table = multum::find_table(command);
    if (table == nullptr || index < 0) return;
    const auto& texts = multum::parameter_texts(*table);
    if (static_cast<std::size_t>(index) >= texts.size()) return;
    const auto& text = texts[static_cast<std::size_t>(index)];
    result = {text.name.c_str(), text.help.c_str(), text.values.c_str()};
  });
  return result;
}
