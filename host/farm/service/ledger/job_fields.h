// SPDX-License-Identifier: Apache-2.0
// The table of a job's fields, with one row per field. The table determines the ledger's columns, the JSON of jobs, the
// fields of a submission, the options of `multum jobs submit`, the rows of the page, and schemas of
// docs/reference/openapi.json. To add a field, add a member of Job, its row, and the code that sets it, and update the
// schemas with tools/parameter_documents.
#pragma once

#include <limits>
#include <variant>

#include "host/farm/service/ledger/job.h"

namespace multum {

struct JobField {
  using Member = std::variant<std::string Job::*, int Job::*, std::int64_t Job::*, std::optional<int> Job::*,
                              std::optional<std::int64_t> Job::*, JobState Job::*, std::vector<std::int64_t> Job::*>;
  enum class Form {
    kPlain,
    kPath,
    kObject,  // the text of a JSON object
    kTime,
    kBytes,
    kJob,  // number of another job
  };
  static constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
  static constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();

  const char* name;  // the name of its column, and its key in answers
  Member member;
  Form form = Form::kPlain;
  std::int64_t low = kLeast, high = kMost;  // range of a number; for a time in a submission, in seconds from now
  const char* described = "";               // description in answers; null if it is not in answers
  const char* label = nullptr;              // label of its row on the page; null if it has no row

  const char* asked_as = nullptr;    // the field's key in a submission; null if clients cannot set it
  const char* asked_described = "";  // description in a submission
  const char* expected = nullptr;    // text for error messages; null if parse_submit() checks the field separately
  bool has_default = false;          // the schema also gives the default of Job
  const char* option = nullptr;      // option of `multum jobs submit`
  const char* option_help = "";

  bool has_column() const { return !std::holds_alternative<std::vector<std::int64_t> Job::*>(member); }
  bool is_number() const { return low != kLeast && form != Form::kTime; }
};

const std::vector<JobField>& job_fields();

/// Calls `use` with the member of `job` that the field describes.
template <typename AJob, typename Use>
decltype(auto) with_field(const JobField& field, AJob& job, const Use& use) {
  return std::visit([&](const auto member) -> decltype(auto) { return use(job.*member); }, field.member);
}

}  // namespace multum
