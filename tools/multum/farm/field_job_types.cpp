// SPDX-License-Identifier: Apache-2.0
// Lists the job types of host/fields.
#include "host/fields/inference/job/animation_job_reading.h"
#include "host/fields/inferred/field_files.h"
#include "host/foundation/parameters/infer_parameters.h"
#include "host/foundation/parameters/pack_parameters.h"
#include "tools/multum/farm/multum_job_types.h"

namespace multum {
namespace {

constexpr std::int64_t kFieldJobBytes = std::int64_t{2048} << 20;

JobType infer_type() {
  return {.name = "infer",
          .summary = "infer textures from ray-traced pictures",
          .command = "infer",
          .input = "job",
          .output_is_folder = true,
          .files_of_input = animation_job_files,
          .fixed_options = {"--absolute-geometry"},
          .memory_bytes = kFieldJobBytes,
          .table = &infer_parameters(),
          .views = {{.files = {"render.png"},
                     .program = "multum-view",
                     .words = {"thumbnails", "--context=osmesa"},
                     .writes_folder = true,
                     .shown = {{"render.png", "its first frame"}}}},
          .no_other_view = "it has only a picture of its first frame"};
}

JobType pack_type() {
  return {.name = "pack",
          .summary = "compress inferred textures to one file",
          .command = "pack",
          .input = "manifest",
          .files_of_input = inferred_field_files,
          .output_extension = ".mpt",
          .fixed_options = {"--absolute-geometry"},
          .memory_bytes = kFieldJobBytes,
          .table = &pack_parameters(),
          .views = {{.files = {"player.html"},
                     .words = {"player", "-q"},
                     .takes_roots = true,
                     .shown = {{"player.html", "Play it", "Save a player"}}}},
          .no_other_view = "it has a player, but no pictures"};
}

}  // namespace

std::vector<JobType> field_job_types() { return {infer_type(), pack_type()}; }

}  // namespace multum
