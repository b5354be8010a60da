// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/pipeline/inference_pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "host/fields/inference/mapping/forward_mapping.h"
#include "host/fields/inference/pipeline/inference_pieces.h"
#include "host/fields/inference/pipeline/inference_rows.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

// A linear system and its inputs.
struct ObjectSystem {
  std::string key;
  std::vector<FilterMatrix> matrices;
  std::vector<InferenceView> views;
  std::unique_ptr<TextureInference> inference;
};

class InferencePipeline {
 public:
  InferencePipeline(const ParameterizedScene& field, const AnimationInferSettings& settings,
                    const ObjectMappings& mappings, const std::vector<InferencePiece>& pieces, Progress* progress)
      : field_(field),
        job_(field.job()),
        settings_(settings),
        pieces_(pieces.begin(), pieces.end()),
        progress_(progress),
        device_(device_of(settings)),
        probe_(field, mappings_of(pieces, mappings),
               {settings.viewer, settings.context, settings.output + "/matrices", settings.threads}) {}

  AnimationInferResult run() {
    result_.device = device_.info().name;
    result_.nan_depths = field_.nan_depths();
    std::uint64_t units = probe_.unit_count();
    for (std::size_t l = 0; l < job_.layers.size(); ++l)
      for (const ParameterPoint& point : field_.grid().points(job_.layers[l]))
        if (has_any(l, point.block)) units += point.samples.size() + job_.objects.size();
    progress_start(progress_, units);
    {
      const ScopedStopwatch watch(result_.seconds.probing);
      probe_.run(progress_);
    }
    result_.matrices_measured = probe_.measured;
    for (std::size_t l = 0; l < job_.layers.size(); ++l) infer_layer(l);
    return std::move(result_);
  }

 private:
  // Finds the mappings that the pieces need. All other objects count as invisible.
  static ObjectMappings mappings_of(const std::vector<InferencePiece>& pieces, ObjectMappings mappings) {
    std::set<std::pair<std::size_t, int>> needed;
    for (const InferencePiece& piece : pieces) needed.insert({piece.object, piece.block});
    for (std::size_t k = 0; k < mappings.size(); ++k)
      for (std::size_t block = 0; block < mappings[k].size(); ++block)
        if (!needed.contains({k, static_cast<int>(block)})) mappings[k][block].width = 0;
    return mappings;
  }

  bool has_any(std::size_t l, int block) const {
    return std::any_of(pieces_.begin(), pieces_.end(),
                       [&](const InferencePiece& piece) { return piece.layer == l && piece.block == block; });
  }

  void infer_layer(std::size_t l) {
    const AnimationLayer& layer = job_.layers[l];
    systems_.clear();
    starts_.clear();
    int block = 0;
    const std::vector<ParameterPoint> points = field_.grid().points(layer);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const ParameterPoint& point = points[i];
      if (point.block != block) starts_.clear();  // textures of different blocks have different coordinates
      block = point.block;
      if (!has_any(l, block)) continue;
      progress_stage(progress_, fmt::format("infer {} {}", layer.name, point.name));
      std::vector<std::vector<ObjectLayer>> pictures;  // [sample of the point][object]
      {
        const ScopedStopwatch watch(result_.seconds.segmentation);
        PointReport of_point{l, i, {}};
        for (const int sample : point.samples) {
          SegmentationReport report;
          pictures.push_back(field_.segment(sample, layer, settings_.threads, &report));
          of_point.segmentation.add(report);
          progress_advance(progress_, 1);
        }
        result_.points.push_back(of_point);
      }
      for (std::size_t k = 0; k < job_.objects.size(); ++k) {
        if (pieces_.contains({block, k, l})) infer_texture(k, l, i, point, pictures);
        progress_advance(progress_, 1);
      }
    }
  }

  void infer_texture(std::size_t k, std::size_t l, std::size_t point_number, const ParameterPoint& point,
                     const std::vector<std::vector<ObjectLayer>>& pictures) {
    const AnimationLayer& layer = job_.layers[l];
    TextureResult texture;
    texture.object = k;
    texture.layer = l;
    texture.point = point_number;
    texture.block = point.block;
    texture.samples = point.samples;
    for (const int sample : point.samples)
      texture.is_held_out.push_back(is_held_out(job_, settings_.hold_out, layer, sample));
    const bool is_black = std::none_of(pictures.begin(), pictures.end(), [&](const std::vector<ObjectLayer>& objects) {
      return has_radiance(objects[k], job_.radiance_max);
    });
    if (is_black) {
      starts_.erase(k);
      result_.textures.push_back(texture);
      return;
    }
    ObjectSystem& system = system_of(k, point, pictures, texture.is_held_out);
    const std::vector<float> colours = colours_of(k, system, pictures);
    texture.file = texture_file(job_, k, l, point);
    const std::string path = settings_.output + "/" + texture.file;
    const std::string key = texture_key(k, layer, system, colours);
    std::vector<float> texels = texels_there(path, key);
    texture.was_there = !texels.empty();
    if (!texture.was_there) {
      const ScopedStopwatch watch(result_.seconds.solving);
      InferenceResult solved = system.inference->solve(colours, starts_[k]);
      texture.converged = solved.converged;
      texture.iterations = solved.iterations;
      texture.history = std::move(solved.history);
      texels = std::move(solved.texels);
      for (float& value : texels) value = static_cast<float>(static_cast<double>(value) * job_.radiance_max);
      // Rounds texels to the values in the file, so that a resumed run starts the next texture from the same values.
      round_to_half(texels);
      write_texture(path, k, key, texture, texels);
    }
    divide(texels, job_.radiance_max);
    texture.squared_errors = squared_errors(k, system, pictures, colours, texels, texture.pixel_counts);
    if (settings_.with_baseline) {
      const ScopedStopwatch watch(result_.seconds.baseline);
      texture.forward_squared_errors =
          squared_errors(k, system, pictures, colours, forward_texels(k, point, pictures), texture.pixel_counts);
    }
    starts_[k] = std::move(texels);
    result_.textures.push_back(std::move(texture));
  }

  ObjectSystem& system_of(std::size_t k, const ParameterPoint& point,
                          const std::vector<std::vector<ObjectLayer>>& pictures, const std::vector<bool>& is_held_out) {
    const ScopedStopwatch watch(result_.seconds.systems);
    ObjectSystem& system = systems_[k];
    std::string matrices_key;
    for (const int sample : point.samples) matrices_key += probe_.key(field_.pose_of(sample), k);
    // Reuses the previous system if the same pixels have weights above 0.
    if (system.inference && system.key == matrices_key) {
      bool is_same = true;
      for (std::size_t i = 0; i < point.samples.size() && is_same; ++i)
        is_same = is_held_out[i] ||
                  row_weights(system.matrices[i], pictures[i][k], job_.coverage_min) == system.views[i].row_weights;
      if (is_same) return system;
    }
    system = ObjectSystem{};
    system.key = matrices_key;
    for (const int sample : point.samples) {
      system.matrices.push_back(probe_.matrix(field_.pose_of(sample), k));
      result_.renderer = system.matrices.back().provenance.renderer;
    }
    for (std::size_t i = 0; i < point.samples.size(); ++i) {
      const FilterMatrix& matrix = system.matrices[i];
      if (counted_.insert({field_.pose_of(point.samples[i]), k}).second)
        result_.matrices.push_back({field_.pose_of(point.samples[i]), k, matrix.row_count(), matrix.rows_rejected});
      system.views.push_back({&matrix, is_held_out[i] ? std::vector<float>(matrix.row_count(), 0.0f)
                                                      : row_weights(matrix, pictures[i][k], job_.coverage_min)});
    }
    InferenceSettings inference;
    inference.pyramid_weight = job_.objects[k].texture.pyramid_weight;
    inference.range_weight = job_.objects[k].texture.range_weight;
    inference.gradient_tolerance = settings_.gradient_tolerance;
    inference.iteration_max = settings_.iteration_max;
    system.inference = std::make_unique<TextureInference>(device_, system.views, inference, settings_.threads);
    (system.inference->uses_normal_form() ? result_.systems_normal : result_.systems_matrix) += 1;
    return system;
  }

  // Returns the pixels of all rows, 0..1.
  std::vector<float> colours_of(std::size_t k, const ObjectSystem& system,
                                const std::vector<std::vector<ObjectLayer>>& pictures) const {
    std::vector<float> colours;
    for (std::size_t i = 0; i < system.matrices.size(); ++i)
      append_row_colours(system.matrices[i], pictures[i][k], job_.radiance_max, colours);
    return colours;
  }

  std::string texture_key(std::size_t k, const AnimationLayer& layer, const ObjectSystem& system,
                          const std::vector<float>& colours) const {
    const AnimationTexture& texture = job_.objects[k].texture;
    ContentHash hash;
    hash.update(fmt::format("inference 1 {} {} {} {} {} {} {}", layer.name, system.key, texture.pyramid_weight,
                            texture.range_weight, job_.radiance_max, settings_.gradient_tolerance,
                            settings_.iteration_max));
    for (const InferenceView& view : system.views)
      hash.update(view.row_weights.data(), view.row_weights.size() * sizeof(float));
    hash.update(colours.data(), colours.size() * sizeof(float));
    return hash.finish();
  }

  // Returns the texels of an earlier run with this key. The list is empty if the texture must be inferred.
  std::vector<float> texels_there(const std::string& path, const std::string& key) const {
    if (settings_.force || settings_.damaged.contains(path) || provenance_key(path) != key) return {};
    try {
      return read_inferred_texture(path).texels;
    } catch (const Error& damage) {
      log_named_warning(fmt::format("{}; it is inferred again", damage.what()));
      return {};
    }
  }

  static std::string provenance_key(const std::string& path) {
    const nlohmann::json json = nlohmann::json::parse(read_texture_provenance(path), nullptr, false);
    return json.is_object() && json.contains("key") && json["key"].is_string() ? json["key"].get<std::string>() : "";
  }

  void write_texture(const std::string& path, std::size_t k, const std::string& key, const TextureResult& texture,
                     const std::vector<float>& texels) {
    make_folder(fs::path(path).parent_path().string());
    InferredTexture file;
    file.width = probe_.mapping(k, texture.block).width;
    file.height = probe_.mapping(k, texture.block).height;
    file.texels = texels;
    std::vector<std::string> samples;
    for (std::size_t i = 0; i < texture.samples.size(); ++i)
      if (!texture.is_held_out[i]) samples.push_back(job_.samples[static_cast<std::size_t>(texture.samples[i])].name);
    file.provenance = nlohmann::json{{"key", key},
                                     {"software", std::string("multum ") + MULTUM_VERSION},
                                     {"object", job_.objects[k].name},
                                     {"layer", job_.layers[texture.layer].name},
                                     {"samples", samples},
                                     {"renderer", result_.renderer},
                                     {"radianceMax", job_.radiance_max},
                                     {"pyramidWeight", job_.objects[k].texture.pyramid_weight},
                                     {"rangeWeight", job_.objects[k].texture.range_weight},
                                     {"iterations", texture.iterations},
                                     {"converged", texture.converged}}
                          .dump();
    write_inferred_texture(file, path);
  }

  // Compares A x with the layer's pixels. Returns the mean error of each sample, including held-out ones, over pixels
  // that the object covers wholly.
  std::vector<double> squared_errors(std::size_t k, const ObjectSystem& system,
                                     const std::vector<std::vector<ObjectLayer>>& pictures,
                                     const std::vector<float>& colours, const std::vector<float>& texels,
                                     std::vector<double>& pixel_counts) const {
    std::vector<double> errors;
    pixel_counts.clear();
    std::size_t row = 0;
    for (std::size_t i = 0; i < system.matrices.size(); ++i) {
      const FilterMatrix& m = system.matrices[i];
      double sum = 0.0, count = 0.0;
      for (std::size_t r = 0; r < m.row_count(); ++r, ++row) {
        if (!is_whole_row(m, r, pictures[i][k])) continue;
        sum += squared_error_8bit(filtered(m, r, texels).data(), &colours[3 * row]);
        count += 1.0;
      }
      errors.push_back(count > 0.0 ? sum / count : 0.0);
      pixel_counts.push_back(count);
    }
    return errors;
  }

  // Returns the forward-mapped texels of all samples of the point, 0..1.
  std::vector<float> forward_texels(std::size_t k, const ParameterPoint& point,
                                    const std::vector<std::vector<ObjectLayer>>& pictures) const {
    std::vector<ForwardView> views;
    for (std::size_t i = 0; i < point.samples.size(); ++i)
      views.push_back(field_.forward_view(k, field_.pose_of(point.samples[i]), pictures[i][k]));
    std::vector<float> texels = forward_mapped(field_.meshes()[static_cast<std::size_t>(field_.mesh_of(k))],
                                               probe_.mapping(k, point.block), views);
    divide(texels, job_.radiance_max);
    return texels;
  }

  const ParameterizedScene& field_;
  const AnimationJob& job_;
  const AnimationInferSettings& settings_;
  std::set<InferencePiece> pieces_;
  Progress* progress_;
  AnimationInferResult result_;
  Device device_;
  AnimationProbe probe_;
  std::map<std::size_t, ObjectSystem> systems_;       // systems of the current layer, by object
  std::map<std::size_t, std::vector<float>> starts_;  // the last point's texels, by object
  std::set<std::pair<int, std::size_t>> counted_;     // poses and objects whose rows are in the result
};

}  // namespace

std::string texture_file(const AnimationJob& job, std::size_t object, std::size_t layer, const ParameterPoint& point) {
  return fmt::format("textures/{}/{}_{}.exr", job.objects[object].name, job.layers[layer].name, point.name);
}

bool is_held_out(const AnimationJob& job, int hold_out, const AnimationLayer& layer, int sample) {
  if (hold_out < 2) return false;
  for (std::size_t d = 0; d < job.parameters.size(); ++d)
    if (job.parameters[d].is_view &&
        std::find(layer.depends_on.begin(), layer.depends_on.end(), job.parameters[d].name) == layer.depends_on.end())
      return job.samples[static_cast<std::size_t>(sample)].at[d] % hold_out == hold_out - 1;
  return false;
}

AnimationInferResult infer_pieces(const ParameterizedScene& field, const AnimationInferSettings& settings,
                                  const ObjectMappings& mappings, const std::vector<InferencePiece>& pieces,
                                  Progress* progress) {
  return InferencePipeline(field, settings, mappings, pieces, progress).run();
}

void finish_inference(const ParameterizedScene& field, const AnimationInferSettings& settings,
                      const ObjectMappings& mappings, AnimationInferResult& result) {
  result.mappings = mappings;
  for (int block = 0; block < field.grid().block_count(); ++block)
    result.blocks.push_back(field.grid().block_name(block));
  for (const PointReport& point : result.points) result.segmentation.add(point.segmentation);
  for (const MatrixRows& matrix : result.matrices) {
    result.rows += matrix.rows;
    result.rows_rejected += matrix.rejected;
  }
  result.manifest = manifest_of(field, settings, mappings, hash_file(field.job().geometry_file), result.textures);
  write_inferred_manifest(result.manifest, settings.output + "/" + kInferredManifestName);
}

Device device_of(const AnimationInferSettings& settings) {
  return settings.opened.is_open() ? settings.opened : Device::open(settings.device);
}

AnimationInferResult infer_animation(const ParameterizedScene& field, const AnimationInferSettings& settings,
                                     Progress* progress) {
  double mapping_seconds = 0.0;
  ObjectMappings mappings;
  {
    const ScopedStopwatch watch(mapping_seconds);
    mappings = find_object_mappings(field);
  }
  AnimationInferResult result = infer_pieces(field, settings, mappings, inference_pieces(field, mappings), progress);
  result.seconds.mapping = mapping_seconds;
  finish_inference(field, settings, mappings, result);
  return result;
}

}  // namespace multum
