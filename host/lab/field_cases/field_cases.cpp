// SPDX-License-Identifier: Apache-2.0
#include "host/lab/field_cases/field_cases.h"

#include "host/lab/field_cases/field_case_lists.h"
#include "host/lab/selftest/selftest.h"

namespace multum {

void register_field_cases() {
  register_numerical_cases(inference_cases);
  register_numerical_cases(transform_cases);
}

}  // namespace multum
