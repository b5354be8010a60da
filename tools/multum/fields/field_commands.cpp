// SPDX-License-Identifier: Apache-2.0
#include "tools/multum/fields/field_commands.h"

#include "host/fields/codec/field_unpacking.h"
#include "host/fields/inference/job/animation_job_reading.h"
#include "host/lab/field_cases/field_cases.h"
#include "tools/multum/fields/commands.h"

namespace multum {

void add_field_commands(CLI::App& app, int* exit_code) {
  register_field_cases();
  add_animation_command(app, exit_code);
  add_infer_command(app, exit_code);
  add_pack_commands(app, exit_code);
  add_player_command(app, exit_code);
}

std::optional<std::string> packed_field_info(const std::string& path) {
  if (!is_packed_field(path)) return std::nullopt;
  return packed_field_text(path);
}

std::optional<OrderedJson> packed_field_json(const std::string& path) {
  if (!is_packed_field(path)) return std::nullopt;
  return parsed(packed_field_facts(PackedFieldFile(path)));
}

std::optional<std::vector<VerifyFinding>> packed_field_findings(const std::string& path) {
  if (!is_packed_field(path)) return std::nullopt;
  std::vector<VerifyFinding> findings;
  for (const PackedFinding& finding : verify_packed_field(path))
    findings.push_back({finding.section, finding.passed, finding.detail});
  return findings;
}

std::vector<std::string> files_of_inference(const std::string& path) {
  const AnimationJob job = read_animation_job(path);
  std::vector<std::string> files = {job.geometry_file};
  for (const AnimationSample& sample : job.samples)
    for (const std::string& file : {sample.radiance, sample.geometry, sample.object_index})
      if (!file.empty()) files.push_back(file);
  return files;
}

}  // namespace multum
