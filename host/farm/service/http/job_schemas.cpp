// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/http/job_schemas.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <type_traits>

#include "host/farm/service/ledger/job_fields.h"
#include "host/farm/service/workers/job_types.h"

namespace multum {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson reference_to(const std::string& name) { return {{"$ref", "#/components/schemas/" + name}}; }

std::string parameters_name(const JobType& type) {
  std::string name = type.name + "Parameters";
  name[0] = static_cast<char>(name[0] - 'a' + 'A');
  return name;
}

void add_limits(OrderedJson& schema, const JobField& field) {
  if (field.low != JobField::kLeast) schema["minimum"] = field.low;
  if (field.high != JobField::kMost) schema["maximum"] = field.high;
}

// Returns the schema of a field's values in answers.
template <typename Value>
OrderedJson answered_schema(const JobField& field, const Value&) {
  constexpr bool kMayLack =
      std::is_same_v<Value, std::optional<int>> || std::is_same_v<Value, std::optional<std::int64_t>>;
  const auto typed = [](const char* name) {
    return OrderedJson{{"type", kMayLack ? OrderedJson{name, "null"} : OrderedJson(name)}};
  };
  if constexpr (std::is_same_v<Value, JobState>) return reference_to("JobState");
  else if constexpr (std::is_same_v<Value, std::string>)
    return typed(field.form == JobField::Form::kObject ? "object" : "string");
  OrderedJson schema = typed("integer");
  if (field.form == JobField::Form::kTime) {
    schema = typed("string");
    schema["format"] = "date-time";
  } else {
    add_limits(schema, field);
  }
  if constexpr (std::is_same_v<Value, std::vector<std::int64_t>>) return {{"type", "array"}, {"items", schema}};
  return schema;
}

template <typename Value>
OrderedJson asked_schema(const JobField& field, const Value&) {
  if constexpr (std::is_same_v<Value, std::string>) {
    if (field.form == JobField::Form::kObject) return {{"type", "object"}};
    return {{"type", "string"}, {"maxLength", 1000}, {"pattern", kPlainPattern}};
  } else if constexpr (std::is_same_v<Value, std::vector<std::int64_t>>) {
    return {{"type", "array"},
            {"maxItems", 1000},
            {"items", {{"type", "integer"}, {"minimum", field.low}, {"maximum", field.high}}}};
  }
  OrderedJson schema = {{"type", "integer"}};
  add_limits(schema, field);
  return schema;
}

OrderedJson default_of(const JobField& field) {
  static const Job kNone;
  return with_field(field, kNone, [&](const auto& value) -> OrderedJson {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, std::string>)
      return field.form == JobField::Form::kObject ? OrderedJson::parse(value) : OrderedJson(value);
    else if constexpr (std::is_arithmetic_v<Value>) return value;
    else return nullptr;
  });
}

OrderedJson object_schema(const OrderedJson& properties, const OrderedJson& required) {
  return {{"type", "object"}, {"properties", properties}, {"required", required}, {"additionalProperties", false}};
}

OrderedJson submission_schema() {
  static const Job kNone;
  OrderedJson properties, types = OrderedJson::array(), rules = OrderedJson::array();
  for (const JobType& type : job_types()) {
    types.push_back(type.name);
    OrderedJson then = {{"properties", {{"parameters", reference_to(parameters_name(type))}}}};
    then["required"] = type.needs_output ? OrderedJson{"parameters", "output"} : OrderedJson{"parameters"};
    rules.push_back(
        {{"if", {{"properties", {{"type", {{"const", type.name}}}}}, {"required", {"type"}}}}, {"then", then}});
  }
  for (const JobField& field : job_fields()) {
    if (field.asked_as == nullptr) continue;
    OrderedJson& schema = properties[field.asked_as];
    schema = with_field(field, kNone, [&](const auto& value) { return asked_schema(field, value); });
    if (field.has_default) schema["default"] = default_of(field);
    if (*field.asked_described != '\0') schema["description"] = field.asked_described;
  }
  properties["type"] = {{"enum", types}};
  properties["again"] = {
      {"type", "boolean"}, {"default", false}, {"description", "Runs the job even if its result exists."}};
  OrderedJson schema = object_schema(properties, {"type"});
  schema["allOf"] = rules;
  return schema;
}

OrderedJson job_schema(const OrderedJson& more) {
  static const Job kNone;
  OrderedJson properties, required = OrderedJson::array();
  for (const JobField& field : job_fields()) {
    if (field.described == nullptr) continue;
    OrderedJson& schema = properties[field.name];
    schema = with_field(field, kNone, [&](const auto& value) { return answered_schema(field, value); });
    if (*field.described != '\0') schema["description"] = field.described;
  }
  for (const auto& [name, schema] : more.items()) properties[name] = schema;
  for (const auto& [name, schema] : properties.items()) required.push_back(name);
  return object_schema(properties, required);
}

OrderedJson list_of(const char* name) { return {{"type", "array"}, {"items", reference_to(name)}}; }

}  // namespace

OrderedJson job_schemas() {
  const OrderedJson progress = {{"oneOf", {reference_to("Progress"), {{"type", "null"}}}}};
  OrderedJson parts = list_of("Part");
  parts["description"] = "The parts that were sent to Slurm, for all attempts of the job.";
  OrderedJson schemas = {{"Submission", submission_schema()}};
  for (const JobType& type : job_types()) schemas[parameters_name(type)] = OrderedJson(parameters_schema(type));
  schemas["Job"] = job_schema(OrderedJson::object());
  schemas["ListedJob"] = job_schema({{"progress", progress}});
  schemas["JobDetail"] = job_schema({{"attempts", list_of("Attempt")}, {"parts", parts}, {"progress", progress}});
  return schemas;
}

}  // namespace multum
