// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/pipeline/inference_share.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "host/fields/inference/pipeline/inference_pieces.h"
#include "host/formats/opencl/program_cache.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/input_hashes.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/share_record.h"
#include "host/foundation/base/stopwatch.h"
#include "host/foundation/base/version.h"

namespace multum {
namespace {

using Json = nlohmann::json;

constexpr std::size_t SegmentationReport::*kCounts[] = {
    &SegmentationReport::not_finite_pixels, &SegmentationReport::negative_pixels, &SegmentationReport::repaired_pixels,
    &SegmentationReport::dropped_pixels,    &SegmentationReport::mixed_pixels,    &SegmentationReport::unguided_pixels,
    &SegmentationReport::clamped_values,    &SegmentationReport::clipped_values};

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorCode::kEnvironment, what); }

// Identifies the point of the piece to which a texture or a report belongs.
using PointName = std::tuple<std::size_t, std::size_t, std::size_t>;  // layer, point, object

// The expected contents of a share, from the job.
struct ShareWork {
  std::vector<InferencePiece> pieces;
  std::map<PointName, ParameterPoint> textures;
  std::set<int> samples;  // the samples whose pictures are read
};

std::vector<ShareWork> divide_work(const ParameterizedScene& field, const ObjectMappings& mappings, int count) {
  std::vector<std::vector<ParameterPoint>> points;  // points of each layer
  for (const AnimationLayer& layer : field.job().layers) points.push_back(field.grid().points(layer));
  std::vector<ShareWork> shares;
  for (std::vector<InferencePiece>& pieces : divide_pieces(field, mappings, count)) {
    ShareWork& work = shares.emplace_back();
    work.pieces = std::move(pieces);
    for (const InferencePiece& piece : work.pieces)
      for (std::size_t i = 0; i < points[piece.layer].size(); ++i) {
        const ParameterPoint& point = points[piece.layer][i];
        if (point.block != piece.block) continue;
        work.textures[{piece.layer, i, piece.object}] = point;
        work.samples.insert(point.samples.begin(), point.samples.end());
      }
  }
  return shares;
}

// Returns everything that determines a share's textures and figures.
std::string key_of(const ParameterizedScene& field, const AnimationInferSettings& settings, const ShareWork& work,
                   InputHashes& hashes) {
  const AnimationJob& job = field.job();
  ContentHash hash;
  hash.update(fmt::format("{} {} {} {} {} {} {} {} {}\n", software_version(), kernel_sources_hash(), settings.context,
                          settings.gradient_tolerance, settings.iteration_max, settings.hold_out,
                          settings.with_baseline, hashes.hash(job.path), hashes.hash(job.geometry_file)));
  for (const int s : work.samples) {
    const AnimationSample& sample = job.samples[static_cast<std::size_t>(s)];
    for (const std::string& file : {sample.radiance, sample.geometry, sample.object_index})
      hash.update(file.empty() ? "-\n" : hashes.hash(file) + "\n");
  }
  return hash.finish();
}

Json texture_json(const TextureResult& texture, const std::string& output) {
  Json history = Json::array();
  for (const InferenceStep& step : texture.history)
    history.push_back({step.iteration, step.objective, step.gradient_ratio, step.held});
  return {{"layer", texture.layer},
          {"point", texture.point},
          {"object", texture.object},
          {"sha256", texture.file.empty() ? "" : hash_file(output + "/" + texture.file)},
          {"errors", texture.squared_errors},
          {"pixels", texture.pixel_counts},
          {"forwardErrors", texture.forward_squared_errors},
          {"wasThere", texture.was_there},
          {"converged", texture.converged},
          {"iterations", texture.iterations},
          {"history", history}};
}

Json content_of(const AnimationInferResult& result, const std::string& output) {
  const StageSeconds& s = result.seconds;
  Json content = {{"device", result.device},
                  {"renderer", result.renderer},
                  {"seconds", {s.mapping, s.probing, s.segmentation, s.systems, s.solving, s.baseline}},
                  {"matricesMeasured", result.matrices_measured},
                  {"systems", {result.systems_normal, result.systems_matrix}},
                  {"points", Json::array()},
                  {"matrices", Json::array()},
                  {"textures", Json::array()}};
  for (const PointReport& point : result.points) {
    Json counts = Json::array();
    for (const auto member : kCounts) counts.push_back(point.segmentation.*member);
    content["points"].push_back({point.layer, point.point, counts});
  }
  for (const MatrixRows& matrix : result.matrices)
    content["matrices"].push_back({matrix.pose, matrix.object, matrix.rows, matrix.rejected});
  for (const TextureResult& texture : result.textures) content["textures"].push_back(texture_json(texture, output));
  return content;
}

// Returns one figure per sample. A null value stands for NaN.
std::vector<double> figures_from(const Json& json, std::size_t count) {
  std::vector<double> figures;
  for (const Json& one : json)
    figures.push_back(one.is_null() ? std::numeric_limits<double>::quiet_NaN() : one.get<double>());
  if (!json.is_array() || figures.size() != count)
    refuse(fmt::format("has {} values for the samples of a texture, expected {}", figures.size(), count));
  return figures;
}

int count_from(const Json& json) { return static_cast<int>(json_integer_of(json, "a count", 0, 1'000'000'000)); }

std::size_t size_from(const Json& json) {
  return static_cast<std::size_t>(json_integer_of(json, "a count", 0, INT64_MAX));
}

TextureResult texture_from(const Json& json, const PointName& name, const ParameterPoint& point,
                           const AnimationInferSettings& settings, const AnimationJob& job) {
  TextureResult texture;
  std::tie(texture.layer, texture.point, texture.object) = name;
  texture.block = point.block;
  texture.samples = point.samples;
  for (const int sample : point.samples)
    texture.is_held_out.push_back(is_held_out(job, settings.hold_out, job.layers[texture.layer], sample));
  if (json.at("sha256").get<std::string>().empty()) return texture;  // the layer is black
  texture.file = texture_file(job, texture.object, texture.layer, point);
  texture.squared_errors = figures_from(json.at("errors"), point.samples.size());
  texture.pixel_counts = figures_from(json.at("pixels"), point.samples.size());
  const Json& forward = json.at("forwardErrors");
  if (!forward.empty()) texture.forward_squared_errors = figures_from(forward, point.samples.size());
  texture.was_there = json.at("wasThere").get<bool>();
  texture.converged = json.at("converged").get<bool>();
  texture.iterations = count_from(json.at("iterations"));
  for (const Json& step : json.at("history")) {
    const std::vector<double> values = figures_from({step.at(1), step.at(2)}, 2);
    texture.history.push_back({count_from(step.at(0)), values[0], values[1], size_from(step.at(3))});
  }
  return texture;
}

// A checked record, and the textures that do not match it.
struct CheckedShare {
  AnimationInferResult result;
  std::set<std::string> damaged;  // paths of damaged textures
  std::string why;                // fault of the first damaged texture; empty if all are intact
};

class RecordReader {
 public:
  RecordReader(const ParameterizedScene& field, const AnimationInferSettings& settings, const ShareWork& work)
      : field_(field), settings_(settings), work_(work) {}

  // Throws Error(kEnvironment), which names the record and the command that makes it again.
  CheckedShare read(const ShareName& name, const std::string& key) const {
    const Json content = read_share_record(name, key);
    try {
      return checked(content);
    } catch (const Json::exception& error) {
      refuse(fmt::format("{}: is not a record of inferred textures: {}{}", name.path(), error.what(), name.remedy()));
    } catch (const Error& error) {
      refuse(fmt::format("{}: {}{}", name.path(), error.what(), name.remedy()));
    }
  }

 private:
  CheckedShare checked(const Json& content) const {
    CheckedShare share;
    AnimationInferResult& result = share.result;
    result.device = content.at("device").get<std::string>();
    result.renderer = content.at("renderer").get<std::string>();
    const auto seconds = content.at("seconds").get<std::array<double, 6>>();
    result.seconds = {seconds[0], seconds[1], seconds[2], seconds[3], seconds[4], seconds[5], 0.0};
    result.matrices_measured = count_from(content.at("matricesMeasured"));
    result.systems_normal = count_from(content.at("systems").at(0));
    result.systems_matrix = count_from(content.at("systems").at(1));
    for (const Json& point : content.at("points")) result.points.push_back(point_from(point));
    for (const Json& matrix : content.at("matrices")) result.matrices.push_back(matrix_from(matrix));
    std::set<PointName> found;
    for (const Json& json : content.at("textures")) {
      const PointName name = {size_from(json.at("layer")), size_from(json.at("point")), size_from(json.at("object"))};
      const auto wanted = work_.textures.find(name);
      if (wanted == work_.textures.end() || !found.insert(name).second)
        refuse("lists a texture twice, or a texture that belongs to another share");
      result.textures.push_back(texture_from(json, name, wanted->second, settings_, field_.job()));
      check_file(result.textures.back().file, json.at("sha256").get<std::string>(), share);
    }
    if (found.size() != work_.textures.size())
      refuse(fmt::format("has {} textures, expected {}", found.size(), work_.textures.size()));
    return share;
  }

  void check_file(const std::string& file, const std::string& expected, CheckedShare& share) const {
    if (file.empty()) return;
    const std::string path = settings_.output + "/" + file;
    std::error_code ignored;
    const bool is_there = std::filesystem::is_regular_file(path, ignored);
    if (is_there && hash_file(path) == expected) return;
    share.damaged.insert(path);
    if (share.why.empty()) share.why = path + (is_there ? ": is damaged, or belongs to another run" : ": is missing");
  }

  PointReport point_from(const Json& json) const {
    PointReport point{size_from(json.at(0)), size_from(json.at(1)), {}};
    const Json& counts = json.at(2);
    for (std::size_t i = 0; i < std::size(kCounts); ++i) point.segmentation.*kCounts[i] = size_from(counts.at(i));
    return point;
  }

  MatrixRows matrix_from(const Json& json) const {
    return {count_from(json.at(0)), size_from(json.at(1)), size_from(json.at(2)), size_from(json.at(3))};
  }

  const ParameterizedScene& field_;
  const AnimationInferSettings& settings_;
  const ShareWork& work_;
};

ShareName name_of(const AnimationInferSettings& settings, const InferenceShare& share) {
  return {settings.output, "inference", share.index, share.count};
}

void add_times(const StageSeconds& from, StageSeconds& to) {
  for (const auto member : {&StageSeconds::mapping, &StageSeconds::probing, &StageSeconds::segmentation,
                            &StageSeconds::systems, &StageSeconds::solving, &StageSeconds::baseline})
    to.*member += from.*member;
}

// Counts points and matrices only once, even if several shares used them.
void add_result(AnimationInferResult&& from, AnimationInferResult& to) {
  if (to.renderer.empty()) to.renderer = from.renderer;
  if (to.device.empty()) to.device = from.device;
  add_times(from.seconds, to.seconds);
  to.matrices_measured += from.matrices_measured;
  to.systems_normal += from.systems_normal;
  to.systems_matrix += from.systems_matrix;
  to.points.insert(to.points.end(), from.points.begin(), from.points.end());
  to.matrices.insert(to.matrices.end(), from.matrices.begin(), from.matrices.end());
  std::move(from.textures.begin(), from.textures.end(), std::back_inserter(to.textures));
}

void put_in_order(AnimationInferResult& result) {
  const auto once = [](auto& list, auto name) {
    std::stable_sort(list.begin(), list.end(), [&](const auto& a, const auto& b) { return name(a) < name(b); });
    list.erase(std::unique(list.begin(), list.end(), [&](const auto& a, const auto& b) { return name(a) == name(b); }),
               list.end());
  };
  once(result.points, [](const PointReport& one) { return std::pair(one.layer, one.point); });
  once(result.matrices, [](const MatrixRows& one) { return std::pair(one.pose, one.object); });
  once(result.textures, [](const TextureResult& one) { return PointName(one.layer, one.point, one.object); });
}

}  // namespace

InferenceShareResult infer_share(const ParameterizedScene& field, const AnimationInferSettings& settings,
                                 const InferenceShare& share, Progress* progress) {
  double mapping_seconds = 0.0;
  ObjectMappings mappings;
  {
    const ScopedStopwatch watch(mapping_seconds);
    mappings = find_object_mappings(field);
  }
  const ShareWork work = divide_work(field, mappings, share.count)[static_cast<std::size_t>(share.index - 1)];
  const auto textures = static_cast<int>(work.textures.size());
  InputHashes hashes;
  const std::string key = key_of(field, settings, work, hashes);
  const ShareName name = name_of(settings, share);
  AnimationInferSettings own = settings;
  try {
    const CheckedShare there = RecordReader(field, settings, work).read(name, key);
    if (there.damaged.empty() && !settings.force) return {true, textures};
    own.damaged = there.damaged;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kEnvironment) throw;
  }
  AnimationInferResult result;
  if (!work.pieces.empty()) result = infer_pieces(field, own, mappings, work.pieces, progress);
  result.seconds.mapping = mapping_seconds;
  write_share_record(name, key, content_of(result, settings.output));
  return {false, textures};
}

AnimationInferResult merge_inference(const ParameterizedScene& field, const AnimationInferSettings& settings, int count,
                                     Progress* progress) {
  const ObjectMappings mappings = find_object_mappings(field);
  progress_stage(progress, "check shares");
  progress_start(progress, static_cast<std::uint64_t>(count));
  AnimationInferResult merged;
  std::string missing;
  InputHashes hashes;
  const std::vector<ShareWork> shares = divide_work(field, mappings, count);
  for (int i = 1; i <= count; ++i) {
    const ShareName name = name_of(settings, {i, count});
    const ShareWork& work = shares[static_cast<std::size_t>(i - 1)];
    const std::string key = key_of(field, settings, work, hashes);
    const auto miss = [&](const std::string& why) { missing += (missing.empty() ? "" : "\n  ") + why; };
    try {
      CheckedShare checked = RecordReader(field, settings, work).read(name, key);
      if (!checked.why.empty()) miss(checked.why + name.remedy());
      add_result(std::move(checked.result), merged);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kEnvironment) throw;
      miss(error.what());
    }
    progress_advance(progress, 1);
  }
  if (!missing.empty()) throw Error(ErrorCode::kEnvironment, missing);
  put_in_order(merged);
  merged.nan_depths = field.nan_depths();
  finish_inference(field, settings, mappings, merged);
  return merged;
}

}  // namespace multum
