// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/packing/field_packing.h"

#include <fmt/format.h>

#include <optional>

#include "host/fields/codec/packing/field_coder.h"
#include "host/fields/inferred/inference_error.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/version.h"

namespace multum {
namespace {

constexpr double kLambdaFirst = 500.0;
constexpr int kAlphaPassesMax = 12;  // one or two passes are usual; each pass lowers the mean less than the previous
                                     // pass
/// The memory of the program with OpenCL and its buffers of 16 MiB. Textures, weights and their coding are not
/// included.
constexpr std::uint64_t kProgramBytes = std::uint64_t{240} << 20;

void write_packed(const std::vector<std::uint8_t>& bytes, const std::string& path) {
  AtomicFile file(path);
  OutputFile out(file);
  write_or_throw(out, bytes.data(), bytes.size());
  out.close();
  file.commit();
}

/// Returns the mean squared error of the textures over all pixels of all frames, in 8-bit sRGB units.
std::optional<double> inferred_mse_of(const std::string& folder, const FieldSource& source) {
  const std::optional<double> sum = inference_error_sum(folder);
  if (!sum) return {};
  return 3.0 * *sum / source.values;
}

/// Returns one line with everything that determines the journal's chunks, except for the field and its checksum.
std::string journal_key(const FieldPackSettings& settings, const FieldSource& source) {
  const std::string coder = settings.coder ? fmt::format("{}", static_cast<int>(*settings.coder)) : "any";
  return fmt::format("{}: pack, field {}, pyramid {}, coder {}, open loop {}, block {}, stagger {}, device {}",
                     software_version(), source.checksum, static_cast<int>(settings.pyramid), coder, settings.open_loop,
                     settings.block, settings.stagger, settings.transforms != nullptr);
}

std::uint64_t weight_bytes(const FieldSource& source) {
  std::uint64_t bytes = 0;
  for (const auto& weights : source.weights)
    for (const auto& [coder, energies] : weights->energies) bytes += energies.bytes();
  for (const ChunkToCode& chunk : source.chunks) bytes += chunk.texel_weights.size() * sizeof(float);
  return bytes;
}

FieldPackReport report_of(const FieldPackSettings& settings, const FieldSource& source, const FieldCoder& coder,
                          const FieldRound& round) {
  FieldPackReport report;
  report.bytes = round.file.size();
  report.raw_bytes = static_cast<std::uint64_t>(source.values);
  report.lambda = round.lambda;
  report.mse = round.mse;
  report.rounds = coder.rounds();
  report.chunks_resumed = coder.chunks_resumed();
  report.mse_covered = round.mse_covered;
  for (std::size_t k = 0; k < source.weights.size(); ++k) {
    if (!(source.weights[k]->pixels > 0.0)) continue;
    report.objects.push_back({source.description.field.objects[k].name, source.weights[k]->pixels, round.object_mse[k],
                              coder.lambda_of(k, round.lambda)});
    if (settings.alpha > 0.0 && round.object_mse[k] > settings.alpha * round.mse_covered) report.is_alpha_met = false;
  }
  for (std::size_t c = 0; c < source.chunks.size(); ++c) {
    const PackedLayer& layer = source.description.layers[source.chunks[c].layer];
    report.chunks.push_back({source.description.field.objects[layer.object].name, layer.name, source.chunks[c].block,
                             round.chunks[c].bytes.size(), round.chunks[c].error / source.values});
  }
  return report;
}

/// Codes the field for the target, and limits the errors of objects by alpha.
FieldRound coded_field(const FieldTarget& target, const FieldMeasure& measure, FieldCoder& coder) {
  FieldRound round = coded_for(target, measure, kLambdaFirst, coder);
  // Additional bytes for limited objects are taken from the other objects. Another object may then exceed alpha times
  // the mean.
  for (int pass = 0; pass < kAlphaPassesMax && coder.hold(round); ++pass)
    round = coded_for(target, measure, round.lambda, coder);
  return round;
}

}  // namespace

FieldPackReport pack_field(const FieldPackSettings& settings, Progress* progress) {
  MULTUM_CHECK(settings.block >= 1 && (settings.alpha == 0.0 || settings.alpha > 1.0));
  if (!settings.output.ends_with(".mpt"))
    throw Error(
        ErrorCode::kUsage,
        fmt::format("{}: is not a valid name for a packed field, expected a name that ends in .mpt", settings.output));
  check_paths_differ({settings.folder + "/" + kInferredManifestName}, {settings.output});
  check_writable(settings.output);
  progress_start(progress, 0);
  progress_stage(progress, "read");
  const FieldSource source =
      read_field_source({settings.folder, settings.output, settings.has_absolute_geometry, settings.block,
                         settings.stagger, image_coders(settings.coder), settings.threads},
                        progress);
  const std::optional<double> inferred_mse = inferred_mse_of(settings.folder, source);
  FieldMeasure measure{source.values, {}};
  if (inferred_mse) measure.mse_max = error_limit(*inferred_mse);
  const std::vector<std::uint8_t> description = encode_description(source.description);
  const std::uint64_t memory = settings.memory_bytes > 0 ? settings.memory_bytes : machine_memory_bytes() / 4;
  const std::uint64_t beside = kProgramBytes + weight_bytes(source);
  const auto journal = PackingJournal::open(settings.output, journal_key(settings, source), settings.resume);
  progress_start(progress, source.chunks.size() * (settings.target.lambda ? 1u : 4u));
  FieldCoder coder(source, description,
                   {settings.pyramid, settings.coder, settings.open_loop, settings.alpha, settings.threads,
                    memory > beside ? memory - beside : 0, settings.transforms, journal.get()},
                   progress);
  FieldRound round;
  try {
    round = coded_field(settings.target, measure, coder);
  } catch (const Cancelled&) {
    if (settings.resume && journal != nullptr) journal->leave();
    throw;
  }
  write_packed(round.file, settings.output);
  progress_finish(progress);
  FieldPackReport report = report_of(settings, source, coder, round);
  report.description_bytes = description.size();
  report.inferred_mse = inferred_mse;
  report.is_error_large = measure.mse_max && !settings.target.mse && round.mse > *measure.mse_max;
  report.has_given_way =
      settings.target.is_default() && kDefaultRatio * static_cast<double>(report.bytes) > source.values;
  return report;
}

}  // namespace multum
