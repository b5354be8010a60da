// SPDX-License-Identifier: Apache-2.0
#include "host/codec/field_packing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "host/base/error.h"
#include "host/base/files/atomic_file.h"
#include "host/base/files/output_file.h"
#include "host/base/files/output_paths.h"
#include "host/base/processes/machine.h"
#include "host/base/version.h"
#include "host/codec/field_coder.h"

namespace multum {
namespace {

constexpr int kRoundsMax = 12;
constexpr double kNearEnough = 0.985;  // of the target
constexpr double kDefaultRatio = 384.0;
constexpr double kLambdaFirst = 500.0;
constexpr double kLambdaMin = FieldCoder::kLambdaMin, kLambdaMax = FieldCoder::kLambdaMax;
constexpr int kAlphaPassesMax = 12;  // mostly one or two: each makes the mean smaller, by less and less
/// What the program takes, OpenCL and its buffers of 16 MiB among it, beside textures, weights and what codes them.
constexpr std::uint64_t kProgramBytes = std::uint64_t{240} << 20;

/// The largest file of at most so many bytes, or the smallest of at most so much error: log(bytes) and log(error) are
/// nearly linear in log(lambda), of slopes -0.56 and 0.6 on a field of 64 samples.
template <typename Code>
FieldRound search(double limit, bool is_error, double lambda, const Code& code) {
  const auto excess_of = [&](const FieldRound& round) {
    const double value = is_error ? round.mse : static_cast<double>(round.file.size());
    return std::log(std::max(value, 1e-12) / limit);
  };
  const double slope = is_error ? 0.6 : -0.56, aim = 0.5 * std::log(kNearEnough);
  std::optional<FieldRound> best;
  struct Side {
    double x = 0.0, excess = 0.0;
    bool is_there = false;
  } met, missed;  // the nearest of either kind
  double x = std::log(lambda);
  double least = 0.0;
  for (int i = 0; i < kRoundsMax; ++i) {
    FieldRound round = code(std::exp(x));
    const double excess = excess_of(round);
    least = i == 0 ? excess : std::min(least, excess);
    (excess <= 0.0 ? met : missed) = {x, excess, true};
    if (excess <= 0.0 && (!best || excess > excess_of(*best))) best = std::move(round);
    if (excess <= 0.0 && excess >= 2.0 * aim) break;
    const double edge = std::log(((excess > 0.0) == is_error) ? kLambdaMin : kLambdaMax);
    if (!(met.is_there && missed.is_there) && x == edge) break;
    double next = x + (aim - excess) / slope;
    if (met.is_there && missed.is_there) {
      const double share = std::clamp((aim - met.excess) / (missed.excess - met.excess), 0.1, 0.9);
      next = met.x + share * (missed.x - met.x);
      if (std::abs(met.x - missed.x) < 1e-3) break;
    }
    x = std::clamp(next, std::log(kLambdaMin), std::log(kLambdaMax));
  }
  if (best) return std::move(*best);
  throw Error(ErrorCode::kUsage, is_error
                                     ? fmt::format("an error of {:g} cannot be met: {:.4g} is the least that was found",
                                                   limit, limit * std::exp(least))
                                     : fmt::format("{:.0f} bytes cannot be met: {:.0f} is the least that was found",
                                                   limit, limit * std::exp(least)));
}

void write_packed(const std::vector<std::uint8_t>& bytes, const std::string& path) {
  AtomicFile file(path);
  OutputFile out(file);
  write_or_throw(out, bytes.data(), bytes.size());
  out.close();
  file.commit();
}

/// What the journal's chunks depend on, but for the field and its checksum: a line.
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

/// Codes for the target.
FieldRound coded_for(const FieldTarget& target, double raw_bytes, FieldCoder& coder) {
  const auto code = [&](double lambda) { return coder.code(lambda); };
  const double by_ratio = raw_bytes / target.ratio.value_or(kDefaultRatio);
  const auto met = [&](double first) {
    return target.lambda ? code(*target.lambda)
           : target.mse  ? search(*target.mse, true, first, code)
                         : search(target.bytes.value_or(by_ratio), false, first, code);
  };
  FieldRound round = met(kLambdaFirst);
  // What the objects that are held take, the others are short of: then one more may be above alpha times the mean.
  for (int pass = 0; pass < kAlphaPassesMax && coder.hold(round); ++pass) round = met(round.lambda);
  return round;
}

}  // namespace

FieldPackReport pack_field(const FieldPackSettings& settings, Progress* progress) {
  MULTUM_CHECK(settings.block >= 1 && (settings.alpha == 0.0 || settings.alpha > 1.0));
  if (!settings.output.ends_with(".mpt"))
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: is not a name for a packed field, expected one that ends in .mpt", settings.output));
  check_paths_differ({settings.folder + "/" + kInferredManifestName}, {settings.output});
  check_writable(settings.output);
  progress_start(progress, 0);
  progress_stage(progress, "read");
  const FieldSource source =
      read_field_source({settings.folder, settings.output, settings.has_absolute_geometry, settings.block,
                         settings.stagger, image_coders(settings.coder), settings.threads},
                        progress);
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
    round = coded_for(settings.target, source.values, coder);
  } catch (const Cancelled&) {
    if (settings.resume && journal != nullptr) journal->leave();
    throw;
  }
  write_packed(round.file, settings.output);
  progress_finish(progress);
  FieldPackReport report = report_of(settings, source, coder, round);
  report.description_bytes = description.size();
  return report;
}

}  // namespace multum
