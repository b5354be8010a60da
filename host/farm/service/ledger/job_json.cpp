// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/ledger/job_json.h"

#include <fmt/format.h>

#include <ctime>

#include "host/farm/service/ledger/job_fields.h"
#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

nlohmann::json time_or_null(const std::optional<TimeMs>& time) {
  return time ? nlohmann::json(time_text(*time)) : nlohmann::json(nullptr);
}

template <typename Value>
nlohmann::json or_null(const std::optional<Value>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

template <typename Value>
nlohmann::json value_json(const JobField& field, const Value& value) {
  using Form = JobField::Form;
  if constexpr (std::is_same_v<Value, JobState>) return job_state_name(value);
  else if constexpr (std::is_same_v<Value, std::int64_t>)
    return field.form == Form::kTime ? nlohmann::json(time_text(value)) : nlohmann::json(value);
  else if constexpr (std::is_same_v<Value, std::optional<std::int64_t>>)
    return field.form == Form::kTime ? time_or_null(value) : or_null(value);
  else if constexpr (std::is_same_v<Value, std::optional<int>>) return or_null(value);
  else if constexpr (std::is_same_v<Value, std::string>)
    return field.form == Form::kObject ? nlohmann::json::parse(value)
                                       : nlohmann::json(field.form == Form::kPath ? text_of_path(value) : value);
  else return value;
}

}  // namespace

std::string time_text(TimeMs time) {
  const std::time_t seconds = static_cast<std::time_t>(time / 1000);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", parts.tm_year + 1900, parts.tm_mon + 1,
                     parts.tm_mday, parts.tm_hour, parts.tm_min, parts.tm_sec, time % 1000);
}

nlohmann::json job_json(const Job& job) {
  nlohmann::json json;
  for (const JobField& field : job_fields())
    if (field.described != nullptr)
      json[field.name] = with_field(field, job, [&](const auto& value) { return value_json(field, value); });
  return json;
}

std::string job_text(const Job& job) { return job_json(job).dump(); }

nlohmann::json part_json(const SlurmPart& part) {
  return {{"part", part.share},
          {"attempt", part.attempt},
          {"round", part.round},
          {"batch", part.batch},
          {"item", part.item},
          {"state", slurm_part_state_name(part.state)},
          {"slurm_job", or_null(part.slurm_job)},
          {"slurm_state", ""},
          {"node", part.node},
          {"exit_code", or_null(part.exit_code)},
          {"message", part.message},
          {"progress", nullptr}};
}

nlohmann::json attempt_json(const JobAttempt& attempt) {
  return {{"number", attempt.number},
          {"outcome", attempt_outcome_name(attempt.outcome)},
          {"started", time_text(attempt.started)},
          {"ended", time_or_null(attempt.ended)},
          {"exit_code", or_null(attempt.exit_code)},
          {"message", attempt.message}};
}

}  // namespace multum
