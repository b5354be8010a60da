// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/report/inference_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "host/fields/inference/mapping/forward_mapping.h"
#include "host/fields/inference/pipeline/inference_rows.h"

namespace multum {
namespace {

struct Variant {
  std::string name;
  bool is_forward;
  bool has_mips;
  double anisotropy;
  double pyramid_weight;
};

// The variants of the paper's fig. 6, and their baselines with the same sampler.
const std::vector<Variant> kVariants = {{"forward mapping, trilinear", true, true, 1.0, 0.0},
                                        {"bilinear", false, false, 1.0, 0.0},
                                        {"trilinear", false, true, 1.0, 0.0},
                                        {"trilinear, regularisation 0.1", false, true, 1.0, 0.1},
                                        {"trilinear, regularisation 0.5", false, true, 1.0, 0.5},
                                        {"forward mapping, anisotropic", true, true, 4.0, 0.0},
                                        {"anisotropic", false, true, 4.0, 0.0},
                                        {"anisotropic, regularisation 0.1", false, true, 4.0, 0.1},
                                        {"anisotropic, regularisation 0.5", false, true, 4.0, 0.5}};

// Returns the job with only one sample.
AnimationJob at_sample(AnimationJob job, int sample) {
  job.samples = {job.samples[static_cast<std::size_t>(sample)]};
  for (int& index : job.samples.front().at) index = 0;
  for (AnimationParameter& parameter : job.parameters) parameter.count = 1;
  job.depth.clear();  // the cameras are checked already
  return job;
}

class Comparer {
 public:
  Comparer(const ParameterizedScene& field, const ObjectMappings& mappings, const AnimationInferSettings& settings,
           Progress* progress)
      : field_(field), mappings_(mappings), settings_(settings), progress_(progress), device_(device_of(settings)) {
    for (const AnimationLayer& layer : field.job().layers)
      layers_.push_back(field.segment(0, layer, settings.threads, nullptr));
  }

  // Groups variants by sampler, so that each sampler's matrices are measured once.
  void append_rows(int supersampling, InferenceComparison& comparison) {
    std::unique_ptr<AnimationProbe> probe;
    const Variant* last = nullptr;
    for (const Variant& variant : kVariants) {
      if (variant.anisotropy > 1.0 && supersampling > 1) continue;
      if (last == nullptr || last->has_mips != variant.has_mips || last->anisotropy != variant.anisotropy)
        probe = probe_of(variant, supersampling);
      last = &variant;
      const std::string sub_pixels =
          supersampling > 1 ? fmt::format(", {0} x {0} sub-pixels", supersampling) : ", one sample per pixel";
      comparison.rows.push_back({variant.name + sub_pixels, errors_of(variant, *probe, comparison.pixel_counts)});
    }
  }

 private:
  std::unique_ptr<AnimationProbe> probe_of(const Variant& variant, int supersampling) {
    progress_stage(progress_, "compare " + variant.name);
    auto probe = std::make_unique<AnimationProbe>(
        field_, mappings_,
        ProbeSettings{settings_.viewer, settings_.context,
                      fmt::format("{}/comparison/{}_{}_{}", settings_.output, supersampling,
                                  variant.has_mips ? "mips" : "finest", variant.anisotropy),
                      settings_.threads, variant.has_mips, supersampling, variant.anisotropy});
    probe->run(nullptr);
    return probe;
  }

  // Returns the errors of every object, with all its layers added.
  std::vector<double> errors_of(const Variant& variant, const AnimationProbe& probe,
                                std::vector<double>& pixel_counts) {
    std::vector<double> errors;
    pixel_counts.clear();
    for (std::size_t k = 0; k < field_.job().objects.size(); ++k) {
      pixel_counts.push_back(0.0);
      errors.push_back(probe.is_seen(k, 0) ? error_of(variant, probe, k, pixel_counts.back()) : -1.0);
    }
    return errors;
  }

  double error_of(const Variant& variant, const AnimationProbe& probe, std::size_t k, double& pixel_count) {
    const FilterMatrix matrix = probe.matrix(0, k);
    const std::vector<float> weights = row_weights(matrix, layers_[0][k], field_.job().coverage_min);
    if (std::none_of(weights.begin(), weights.end(), [](float w) { return w > 0.0f; })) return -1.0;
    std::vector<float> expected(3 * matrix.row_count(), 0.0f), found(expected);
    for (const std::vector<ObjectLayer>& layer : layers_) {
      if (!has_radiance(layer[k], field_.job().radiance_max)) continue;
      std::vector<float> colours;
      append_row_colours(matrix, layer[k], field_.job().radiance_max, colours);
      const std::vector<float> texels =
          variant.is_forward ? forward_texels(probe, k, layer[k]) : inferred_texels(variant, matrix, weights, colours);
      for (std::size_t r = 0; r < matrix.row_count(); ++r) {
        const std::array<float, 3> value = filtered(matrix, r, texels);
        for (std::size_t c = 0; c < 3; ++c) {
          found[3 * r + c] += value[c];
          expected[3 * r + c] += colours[3 * r + c];
        }
      }
    }
    double sum = 0.0;
    for (std::size_t r = 0; r < matrix.row_count(); ++r) {
      if (!is_whole_row(matrix, r, layers_[0][k])) continue;
      sum += squared_error_8bit(&found[3 * r], &expected[3 * r]);
      pixel_count += 1.0;
    }
    return pixel_count > 0.0 ? sum / pixel_count : -1.0;
  }

  std::vector<float> inferred_texels(const Variant& variant, const FilterMatrix& matrix,
                                     const std::vector<float>& weights, const std::vector<float>& colours) {
    InferenceSettings inference;
    inference.pyramid_weight = variant.pyramid_weight;
    inference.gradient_tolerance = settings_.gradient_tolerance;
    inference.iteration_max = settings_.iteration_max;
    return TextureInference(device_, {{&matrix, weights}}, inference, settings_.threads).solve(colours, {}).texels;
  }

  std::vector<float> forward_texels(const AnimationProbe& probe, std::size_t k, const ObjectLayer& layer) const {
    std::vector<float> texels = forward_mapped(field_.meshes()[static_cast<std::size_t>(field_.mesh_of(k))],
                                               probe.mapping(k, 0), {field_.forward_view(k, 0, layer)});
    divide(texels, field_.job().radiance_max);
    return texels;
  }

  const ParameterizedScene& field_;
  const ObjectMappings& mappings_;
  const AnimationInferSettings& settings_;
  Progress* progress_;
  Device device_;
  std::vector<std::vector<ObjectLayer>> layers_;  // [layer][object]
};

}  // namespace

InferenceComparison compare_inference(const ParameterizedScene& field, int sample, const ObjectMappings& mappings,
                                      const AnimationInferSettings& settings, Progress* progress) {
  const AnimationJob& job = field.job();
  InferenceComparison comparison;
  comparison.sample = job.samples[static_cast<std::size_t>(sample)].name;
  comparison.supersampling = job.supersampling;
  const auto block = static_cast<std::size_t>(field.grid().block_of(sample));
  ObjectMappings mappings_there;
  for (const std::vector<TextureMapping>& of_blocks : mappings) mappings_there.push_back({of_blocks[block]});
  const ParameterizedScene field_there(at_sample(job, sample));
  Comparer comparer(field_there, mappings_there, settings, progress);
  comparer.append_rows(1, comparison);
  if (job.supersampling > 1) comparer.append_rows(job.supersampling, comparison);
  return comparison;
}

}  // namespace multum
