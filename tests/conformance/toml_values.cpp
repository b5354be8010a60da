// SPDX-License-Identifier: Apache-2.0
// Prints the values of a TOML file as toml-test expects them (github.com/toml-lang/toml-test). The output is JSON, and
// every value is {"type": TYPE, "value": TEXT}. The file is parsed like every TOML file of multum. Usage: toml_values
// FILE. The exit code is 0 if the file was read, and 3 if it was refused.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host/foundation/base/error.h"
#include "host/foundation/toml/strict_toml.h"

namespace multum {
namespace {

template <typename Time>
std::string text_of(const Time& time) {
  std::ostringstream text;
  text << time;
  return text.str();
}

std::string text_of_number(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0.0 ? "inf" : "-inf";
  return fmt::format("{}", value);
}

nlohmann::json tagged(const char* type, const std::string& value) { return {{"type", type}, {"value", value}}; }

nlohmann::json values_of(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table: {
      nlohmann::json table = nlohmann::json::object();
      for (const auto& [key, value] : *node.as_table()) table[std::string(key.str())] = values_of(value);
      return table;
    }
    case toml::node_type::array: {
      nlohmann::json array = nlohmann::json::array();
      for (const toml::node& value : *node.as_array()) array.push_back(values_of(value));
      return array;
    }
    case toml::node_type::string: return tagged("string", node.as_string()->get());
    case toml::node_type::integer: return tagged("integer", std::to_string(node.as_integer()->get()));
    case toml::node_type::floating_point: return tagged("float", text_of_number(node.as_floating_point()->get()));
    case toml::node_type::boolean: return tagged("bool", node.as_boolean()->get() ? "true" : "false");
    case toml::node_type::date: return tagged("date-local", text_of(node.as_date()->get()));
    case toml::node_type::time: return tagged("time-local", text_of(node.as_time()->get()));
    case toml::node_type::date_time: {
      const toml::date_time& time = node.as_date_time()->get();
      return tagged(time.offset ? "datetime" : "datetime-local", text_of(time));
    }
    case toml::node_type::none: break;
  }
  MULTUM_CHECK(false);
}

int run(int argc, char** argv) {
  if (argc != 2) throw Error(ErrorCode::kUsage, "expected the name of one TOML file");
  std::printf("%s\n", values_of(parse_toml(argv[1], "TOML")).dump().c_str());
  return 0;
}

}  // namespace
}  // namespace multum

int main(int argc, char** argv) { return multum::run_guarded("toml_values", multum::run, argc, argv); }
