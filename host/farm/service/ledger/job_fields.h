// SPDX-License-Identifier: Apache-2.0
// The fields of a job, a row each. Their columns in the ledger, their JSON, what a submission may set, the options of
// `multum jobs submit`, the page's rows and the schemas of docs/reference/openapi.json follow from it. To add a field:
// a member of Job, its row, the lines that set it, and the schemas by tools/parameter_documents.
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
    kObject,  // text of a JSON object
    kTime,
    kBytes,
    kJob,  // number of another job
  };
  static constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
  static constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();

  const char* name;  // of its column, and its key in answers
  Member member;
  Form form = Form::kPlain;
  std::int64_t low = kLeast, high = kMost;  // of a number; of a time: seconds from now in a submission
  const char* described = "";               // in answers; null: no answer has it
  const char* label = nullptr;              // of its row on the page; null: it has none

  const char* asked_as = nullptr;    // its key in a submission; null: clients do not set it
  const char* asked_described = "";  // there
  const char* expected = nullptr;    // as refusals say; null: parse_submit() looks at it by itself
  bool has_default = false;          // that of a Job, as its schema says
  const char* option = nullptr;      // of `multum jobs submit`
  const char* option_help = "";

  bool has_column() const { return !std::holds_alternative<std::vector<std::int64_t> Job::*>(member); }
  bool is_number() const { return low != kLeast && form != Form::kTime; }
};

const std::vector<JobField>& job_fields();

/// visit(field, job, [](auto& value) { ... })
template <typename AJob, typename Use>
decltype(auto) with_field(const JobField& field, AJob& job, const Use& use) {
  return std::visit([&](const auto member) -> decltype(auto) { return use(job.*member); }, field.member);
}

}  // namespace multum
