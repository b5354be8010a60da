// SPDX-License-Identifier: Apache-2.0
// Replaces api_field.cpp in a library without fields (CMake option MULTUM_FIELDS).
#include "host/api/api_error.h"

namespace multum {
namespace {

multum_status refuse_fields(multum_error** error) {
  return guarded(error, [] {
    throw Error(ErrorCode::kEnvironment,
                "this library was built without fields, expected a library built with the CMake option MULTUM_FIELDS");
  });
}

}  // namespace
}  // namespace multum

multum_status multum_infer(multum_device*, const char*, const multum_values*, const char*, const multum_callbacks*,
                           multum_text**, multum_error** error) {
  return multum::refuse_fields(error);
}

multum_status multum_pack(multum_device*, const char*, const multum_values*, const char*, const multum_callbacks*,
                          multum_text**, multum_error** error) {
  return multum::refuse_fields(error);
}

multum_status multum_publish_field(const char*, const char*, multum_error** error) {
  return multum::refuse_fields(error);
}

multum_status multum_field_open(const char*, multum_field**, multum_error** error) {
  return multum::refuse_fields(error);
}

void multum_field_free(multum_field*) {}

const char* multum_field_text(const multum_field*) { return ""; }

multum_status multum_field_texture(multum_field*, int, const double*, multum_view*, float*, multum_error** error) {
  return multum::refuse_fields(error);
}

multum_status multum_field_play(multum_field*, const double*, int, int, const multum_callbacks*, float*,
                                multum_error** error) {
  return multum::refuse_fields(error);
}
