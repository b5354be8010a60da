// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/http/job_request.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "host/farm/service/http/http_reply.h"
#include "host/farm/service/ledger/job_fields.h"
#include "host/farm/service/workers/job_types.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

using Json = nlohmann::json;

void only_keys(const Json& object, const std::vector<std::string>& keys, const char* what) {
  if (!object.is_object()) throw Refusal{400, "usage", fmt::format("{} is not a JSON object", what)};
  for (const auto& [key, value] : object.items())
    if (std::find(keys.begin(), keys.end(), key) == keys.end())
      throw Refusal{
          400, "usage",
          fmt::format("unknown key \"{}\" of {}, expected one of {}", key.substr(0, 60), what, fmt::join(keys, ", "))};
}

template <typename Value, typename Is>
Value value_of(const Json& object, const char* key, Value fallback, const Is& is, const char* expected) {
  const auto found = object.find(key);
  if (found == object.end()) return fallback;
  if (!is(*found)) {
    throw Refusal{400, "usage", fmt::format("{} is {}, expected {}", key, shortened(*found), expected)};
  }
  return found->get<Value>();
}

auto integer_between(std::int64_t least, std::int64_t most) {
  return [=](const Json& value) {
    if (!value.is_number_integer()) return false;
    if (value.is_number_unsigned() && value.get<std::uint64_t>() > static_cast<std::uint64_t>(INT64_MAX)) return false;
    return value.get<std::int64_t>() >= least && value.get<std::int64_t>() <= most;
  };
}

bool is_plain(const Json& value) { return value.is_string() && is_plain_text(value.get_ref<const std::string&>()); }

bool is_id_list(const Json& value) {
  return value.is_array() && value.size() <= 1000 &&
         std::all_of(value.begin(), value.end(), integer_between(1, INT64_MAX));
}

template <typename Value>
void read_field(const Json& json, const JobField& field, TimeMs now, Value& value) {
  if (!json.contains(field.asked_as)) return;
  const auto taken = [&](const auto& is) { return value_of<Value>(json, field.asked_as, value, is, field.expected); };
  if constexpr (std::is_same_v<Value, std::string>) value = taken(is_plain);
  else if constexpr (std::is_same_v<Value, std::vector<std::int64_t>>) value = taken(is_id_list);
  else if constexpr (std::is_same_v<Value, std::optional<TimeMs>>)
    value = now + 1000 * value_of<std::int64_t>(json, field.asked_as, 0, integer_between(field.low, field.high),
                                                field.expected);
  else if constexpr (std::is_arithmetic_v<Value>) value = taken(integer_between(field.low, field.high));
  else MULTUM_CHECK(false);  // clients cannot set fields of this type
}

// A relative name is placed in the folder of downloadable results, and must stay there.
std::string output_of(const std::string& named, const JobRoots& roots) {
  if (named.starts_with('/')) return roots.outputs.output(named);
  return roots.results.output(roots.results.roots().front() + "/" + named);
}

// Valid names and texts contain no NUL. C functions would stop at it.
void refuse_nul(const Json& json) {
  const auto check = [](const std::string& text) {
    if (text.find('\0') != std::string::npos)
      throw Refusal{400, "usage", fmt::format("{} holds a NUL, expected a string without NUL", shortened(text))};
  };
  if (json.is_string()) check(json.get_ref<const std::string&>());
  if (json.is_object())
    for (const auto& [key, value] : json.items()) check(key);
  if (json.is_structured())
    for (const Json& child : json) refuse_nul(child);
}

// JSON Schema counts 4.0 as an integer.
void make_integers(Json& json) {
  if (json.is_number_float()) {
    const double value = json.get<double>();
    if (std::abs(value) <= 9007199254740992.0 && value == std::floor(value)) json = static_cast<std::int64_t>(value);
  } else if (json.is_structured()) {
    for (Json& child : json) make_integers(child);
  }
}

}  // namespace

std::optional<std::int64_t> parse_integer(const std::string& text) {
  std::int64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end && !text.empty() ? std::optional(value) : std::nullopt;
}

std::vector<std::string> split_path(const std::string& path) {
  std::vector<std::string> parts;
  std::size_t begin = 1;
  while (begin <= path.size()) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    parts.push_back(path.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

Json parse_body(const HttpRequest& request) {
  if (request.body.empty()) return Json::object();
  // This depth exceeds any valid request. The limit prevents clients from exhausting the parser's stack.
  int depth = 0, deepest = 0;
  for (const char c : request.body) {
    depth += c == '[' || c == '{' ? 1 : c == ']' || c == '}' ? -1 : 0;
    deepest = std::max(deepest, depth);
  }
  Json json = deepest <= 64 ? Json::parse(request.body, nullptr, false) : Json(Json::value_t::discarded);
  if (json.is_discarded()) throw Refusal{400, "usage", "the body is not valid JSON"};
  refuse_nul(json);
  make_integers(json);
  return json;
}

SubmitRequest parse_submit(const Json& json, const JobRoots& roots, const ClaimLimits& limits, TimeMs now) {
  std::vector<std::string> keys;
  for (const JobField& field : job_fields())
    if (field.asked_as != nullptr) keys.emplace_back(field.asked_as);
  keys.emplace_back("again");
  only_keys(json, keys, "the job");
  SubmitRequest request;
  JobSubmission& s = request.job;
  const auto is_text = [](const Json& value) { return is_plain(value); };
  if (!json.contains("type")) throw Refusal{400, "usage", "type is missing"};
  s.type = value_of<std::string>(json, "type", "", is_text, "a string");
  const JobType& type = find_job_type(s.type);
  Json& parameters = request.parameters = json.value("parameters", Json::object());
  check_parameters(type, parameters);
  for (const Parameter& parameter : type.table->rows())
    if (parameter.kind == ParameterKind::kFile && parameters.contains(parameter.name))
      parameters[parameter.name] =
          text_of_path(roots.inputs.input(path_of_text(parameters[parameter.name].get<std::string>())));
  check_input(type, parameters);
  s.parameters = parameters.dump();
  s.output = value_of<std::string>(json, "output", "", is_text, "a path");
  if (s.output.empty() && type.needs_output) throw Refusal{400, "usage", "output is missing, expected a path"};
  if (!s.output.empty()) s.output = output_of(path_of_text(s.output), roots);
  if (!s.output.ends_with(type.output_extension))
    throw Refusal{400, "usage",
                  fmt::format("output is {}, expected a name ending in {}", s.output, type.output_extension)};
  for (const std::string& extension : type.refused_extensions)
    if (s.output.ends_with(extension))
      throw Refusal{400, "usage", fmt::format("output is {}, expected the name of a folder", s.output)};
  s.queue = value_of<std::string>(json, "queue", "default", is_text, "the name of a queue");
  if (!limits.queues.contains(s.queue)) {
    std::vector<std::string> names;
    for (const auto& [name, of_queue] : limits.queues) names.push_back(name);
    throw Refusal{400, "usage", fmt::format("queue is \"{}\", expected one of {}", s.queue, fmt::join(names, ", "))};
  }
  s.memory_bytes = type.memory_bytes;
  Job asked;
  static_cast<JobSubmission&>(asked) = s;
  for (const JobField& field : job_fields())
    if (field.expected != nullptr) with_field(field, asked, [&](auto& value) { read_field(json, field, now, value); });
  s = asked;
  request.again = value_of<bool>(
      json, "again", false, [](const Json& v) { return v.is_boolean(); }, "true or false");
  return request;
}

JobFilter parse_filter(const HttpRequest& request) {
  JobFilter filter;
  for (const auto& [name, value] : request.query) {
    if (name == "state") {
      filter.state = parse_job_state(value);
      if (!filter.state) throw Refusal{400, "usage", "unknown state"};
    } else if (name == "queue") {
      filter.queue = value;
    } else if (name == "before" || name == "limit") {
      const std::optional<std::int64_t> number = parse_integer(value);
      if (!number || *number < 1 || (name == "limit" && *number > 1000))
        throw Refusal{400, "usage", name + " is not an integer from 1" + (name == "limit" ? " to 1000" : "")};
      if (name == "before") filter.before = *number;
      else filter.limit = static_cast<int>(*number);
    } else {
      throw Refusal{400, "usage", "expected state, queue, before or limit in the query"};
    }
  }
  return filter;
}

std::string parse_cancel(const Json& json) {
  only_keys(json, {"part"}, "the request");
  return value_of<std::string>(json, "part", "", is_plain, "a part's name, e.g. 3/8");
}

void check_is_on_nodes(const SubmitRequest& request, const JobRoots& roots) {
  const JobSubmission& job = request.job;
  const auto check = [&](const std::string& what, const std::string& path) {
    if (roots.outputs.is_inside(path) && !roots.results.is_inside(path)) return;
    throw Refusal{
        400, "usage",
        fmt::format("{} is {}, a path of the service itself: queue {} goes to Slurm, whose nodes see only the "
                    "roots; expected a path below a root",
                    what, path, job.queue)};
  };
  if (!job.output.empty()) check("output", job.output);
  const Json& parameters = request.parameters;
  for (const Parameter& parameter : find_job_type(job.type).table->rows())
    if (parameter.kind == ParameterKind::kFile && parameters.contains(parameter.name))
      check("parameters." + parameter.name, path_of_text(parameters[parameter.name].get<std::string>()));
}

std::string parse_retry(const Json& json) {
  only_keys(json, {"queue"}, "the request");
  return value_of<std::string>(json, "queue", "", is_plain, "the name of a queue");
}

PurgeRequest parse_purge(const Json& json) {
  only_keys(json, {"jobs", "finished_before_s"}, "the request");
  if (json.contains("jobs") == json.contains("finished_before_s"))
    throw Refusal{400, "usage", "expected either jobs or finished_before_s"};
  PurgeRequest request;
  request.jobs = value_of<std::vector<std::int64_t>>(json, "jobs", {}, is_id_list, "a list of up to 1000 job numbers");
  const auto age = value_of<std::int64_t>(json, "finished_before_s", -1, integer_between(0, 10000000000), "seconds");
  if (age >= 0) request.finished_before_s = age;
  return request;
}

void check_upload_name(const std::string& name) {
  const bool is_name =
      !name.empty() && name.size() <= 100 && name.front() != '.' && std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '_' ||
               c == '-';
      });
  if (!is_name)
    throw Refusal{400, "usage", "expected a file name of up to 100 letters, digits, dots, dashes and underscores"};
}

}  // namespace multum
