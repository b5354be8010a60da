// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/report/surface_study.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "host/delivery/export/accuracy/export_rules.h"
#include "host/delivery/export/export_source.h"
#include "host/delivery/export/report/level_textures.h"
#include "host/delivery/export/report/surface_frames.h"
#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/messages/quiet_log.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr int kLastLevel = 6;
constexpr int kFrameCount = 48;      // frames per motion: two seconds
constexpr double kTurnReach = 0.15;  // slope of the circling half vector
constexpr double kTurnLevel = 4.0;
constexpr double kWhiteShare = 0.98;  // share of the reference's pixels that are darker than white

// Stores level kStudyFirstLevel and coarser levels as a texture of normal, roughness, axis and strength.
class LevelSink : public MaterialSink {
 public:
  LevelSink(int width, int height, bool has_axis) : texture(has_axis ? 7 : 4, kStudyFirstLevel) {
    for (int level = kStudyFirstLevel; level < mip_level_count(width, height); ++level)
      texture.levels().push_back({mip_level_size(width, level), mip_level_size(height, level), {}});
    for (TextureLevel& level : texture.levels())
      level.texels.resize(size_of(level.width) * size_of(level.height) * size_of(texture.channel_count()));
  }

  void add_level(int level, int first_row, MaterialRows rows) override {
    if (level < kStudyFirstLevel) return;
    const std::size_t channels = size_of(texture.channel_count());
    float* to = texture.levels()[size_of(level - kStudyFirstLevel)].texels.data() +
                size_of(first_row) * size_of(rows.width) * channels;
    for (std::size_t i = 0; i < rows.normals.size(); ++i, to += channels) {
      to[0] = rows.normals[i].x, to[1] = rows.normals[i].y, to[2] = rows.normals[i].z, to[3] = rows.roughness[i];
      if (channels > 4) to[4] = rows.anisotropy[i].x, to[5] = rows.anisotropy[i].y, to[6] = rows.anisotropy[i].z;
    }
  }

  LevelTexture texture;
};

// Applies an engine's rule to averages.
SurfaceModel rule_model(const EngineRule& rule, const LevelTexture& averages) {
  SurfaceModel model{rule.id, rule.name, SurfaceModel::Kind::kOneLobe, averages};
  for (TextureLevel& level : model.texture.levels())
    for (std::size_t i = 0; i < level.texels.size(); i += 4) {
      float* const texel = &level.texels[i];
      const GgxLobe lobe = lobe_of_rule(
          rule, {{static_cast<double>(texel[0]), static_cast<double>(texel[1]), static_cast<double>(texel[2])},
                 static_cast<double>(texel[3])});
      for (int c = 0; c < 3; ++c) texel[c] = static_cast<float>(lobe.normal[c]);
      texel[3] = static_cast<float>(std::sqrt(lobe.alpha_wide));
    }
  return model;
}

SurfaceModel fitted_model(const ExportSource& source, const ExportJob& job, bool is_anisotropic,
                          const std::string& scratch_folder, Device& device, Progress* progress) {
  OneLobeSettings settings = job.lobe;
  settings.is_anisotropic = is_anisotropic;
  LevelSink sink(source.map.normals.width(), source.map.normals.height(), is_anisotropic);
  FormSettings form = form_settings(job, scratch_folder);
  if (is_anisotropic) form.form = MaterialForm::kOneLobe;
  fit_formed_material(device, source.inputs(job), settings, form, sink, progress);
  return {is_anisotropic ? "anisotropic" : "isotropic", is_anisotropic ? "export, anisotropic" : "export",
          SurfaceModel::Kind::kOneLobe, std::move(sink.texture)};
}

SurfaceModel baked_model(BakedLobes& lobes) {
  const int level_count = mip_level_count(lobes.width(), lobes.height());
  SurfaceModel model{"baked", lobes.name(), SurfaceModel::Kind::kBakedLobes,
                     LevelTexture(4 * lobes.count(), kStudyFirstLevel)};
  for (int level = kStudyFirstLevel; level < level_count; ++level) {
    const MovmfLevel read = lobes.level(level);
    TextureLevel made{read.width, read.height, {}};
    for (std::size_t i = 0; i < read.lobes[0].size(); ++i)
      for (const std::vector<glm::vec4>& lobe : read.lobes)
        made.texels.insert(made.texels.end(), {lobe[i].x, lobe[i].y, lobe[i].z, lobe[i].w});
    model.texture.levels().push_back(std::move(made));
  }
  return model;
}

// All inputs of the frames.
struct Stage {
  ExportSource source;
  const PlaneStore* material = nullptr;  // set if the map has a roughness
  double alpha_squared = 0.0;
  LevelTexture averages{4, kStudyFirstLevel};
  std::vector<SurfaceModel> models = {};
  int threads = 1;

  // Draws the reference, then each model.
  std::vector<FramePixels> draw(const FrameView& view) const {
    const PlaneStore& normals = source.fitted_normals();
    std::vector<FramePixels> drawn = {draw_reference(normals, material, alpha_squared, view, threads)};
    for (const SurfaceModel& model : models)
      drawn.push_back(draw_model(model, averages, view, normals.width(), normals.height(), threads));
    return drawn;
  }
  FrameView view_of(double level) const {
    return {level, {0.5 * source.map.normals.width(), 0.5 * source.map.normals.height()}, {0.0, 0.0}};
  }
};

// Returns the number by which values are divided for display, so that most of the reference is below 1.
double white_of(FramePixels reference) {
  const auto place =
      reference.begin() + static_cast<std::ptrdiff_t>(kWhiteShare * static_cast<double>(reference.size()));
  std::nth_element(reference.begin(), place, reference.end());
  return std::max(*place, 1e-9);
}

std::vector<std::uint8_t> grey_of(const FramePixels& pixels, double white) {
  std::vector<std::uint8_t> grey;
  for (const double value : pixels) {
    const double linear = std::clamp(value / white, 0.0, 1.0);
    const double shown = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
    grey.push_back(static_cast<std::uint8_t>(std::lround(255.0 * shown)));
  }
  return grey;
}

double sum_of(const FramePixels& pixels) {
  double sum = 0.0;
  for (const double value : pixels) sum += value;
  return std::max(sum, 1e-12);
}

double difference_of(const FramePixels& a, const FramePixels& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum;
}

// Returns the sum of |(now - before) - (change of the reference)|.
double flicker_of(const FramePixels& now, const FramePixels& before, const FramePixels& reference,
                  const FramePixels& reference_before) {
  double sum = 0.0;
  for (std::size_t i = 0; i < now.size(); ++i)
    sum += std::abs((now[i] - before[i]) - (reference[i] - reference_before[i]));
  return sum;
}

StudyDistance distance_of(const Stage& stage, double level) {
  StudyDistance distance{level, {}};
  const std::vector<FramePixels> drawn = stage.draw(stage.view_of(level));
  const double white = white_of(drawn[0]), total = sum_of(drawn[0]);
  for (const FramePixels& pixels : drawn)
    distance.pictures.push_back(
        {grey_of(pixels, white), difference_of(pixels, drawn[0]) / total, sum_of(pixels) / total});
  return distance;
}

FrameView view_of_frame(const Stage& stage, const std::string& motion, int frame) {
  const double time = static_cast<double>(frame) / kFrameCount;
  if (motion == "zoom") return stage.view_of(kStudyFirstLevel + time * (kLastLevel - kStudyFirstLevel));
  FrameView view = stage.view_of(kTurnLevel);
  view.half_vector = {kTurnReach * std::cos(2.0 * std::numbers::pi * time),
                      kTurnReach * std::sin(2.0 * std::numbers::pi * time)};
  return view;
}

StudyMotion motion_of(const Stage& stage, const std::string& id, Progress* progress) {
  StudyMotion motion{id, kFrameCount, 0.0, std::vector<StudyFlicker>(stage.models.size()), {}};
  std::vector<FramePixels> before;
  double total = 0.0, changed_total = 0.0, white = 0.0;
  for (int frame = 0; frame < kFrameCount; ++frame) {
    progress_advance(progress, 0);
    std::vector<FramePixels> drawn = stage.draw(view_of_frame(stage, id, frame));
    // All frames have the same exposure, so that brief flashes remain visible.
    if (frame == 0) white = white_of(drawn[0]);
    total += sum_of(drawn[0]);
    for (std::size_t m = 0; m < motion.models.size(); ++m) {
      motion.models[m].error += difference_of(drawn[m + 1], drawn[0]);
      if (frame == 0) continue;
      motion.models[m].flicker += flicker_of(drawn[m + 1], before[m + 1], drawn[0], before[0]);
      motion.models[m].change += difference_of(drawn[m + 1], before[m + 1]);
    }
    if (frame > 0) motion.reference_change += difference_of(drawn[0], before[0]), changed_total += sum_of(drawn[0]);
    motion.frames.emplace_back();
    for (const FramePixels& pixels : drawn) motion.frames.back().push_back(grey_of(pixels, white));
    before = std::move(drawn);
  }
  motion.reference_change /= changed_total;
  for (StudyFlicker& model : motion.models)
    model = {model.error / total, model.flicker / changed_total, model.change / changed_total};
  return motion;
}

}  // namespace

SurfaceStudy study_surface(const ExportJob& job, const std::string& scratch_folder, Device& device,
                           Progress* progress) {
  progress_stage(progress, "draw");
  const auto read = [&] {
    const QuietLog quiet;  // the export has already logged its messages about the map
    return read_export_source(job, scratch_folder, progress);
  };
  Stage stage{read()};
  stage.threads = job.threads;
  if (!job.roughness.empty()) stage.material = &stage.source.material->planes;
  stage.alpha_squared = std::pow(job.lobe.base_roughness, 4.0);
  stage.averages =
      averaged_levels(stage.source.fitted_normals(), stage.material, stage.alpha_squared, kStudyFirstLevel);
  for (const EngineRule& rule : engine_rules()) stage.models.push_back(rule_model(rule, stage.averages));
  for (const bool is_anisotropic : {false, true})
    stage.models.push_back(fitted_model(stage.source, job, is_anisotropic, scratch_folder, device, progress));
  if (stage.source.lobes) stage.models.push_back(baked_model(*stage.source.lobes));

  SurfaceStudy study;
  for (const SurfaceModel& model : stage.models) study.ids.push_back(model.id), study.names.push_back(model.name);
  progress_stage(progress, "draw");
  for (const double level : {2.0, 4.0, 6.0}) study.distances.push_back(distance_of(stage, level));
  for (const char* motion : {"zoom", "turn"}) study.motions.push_back(motion_of(stage, motion, progress));
  return study;
}

}  // namespace multum
