// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/pipeline/parameterized_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "host/fields/inference/mapping/camera_check.h"
#include "host/fields/inference/mapping/texture_coordinates.h"
#include "host/formats/image/files/exr_layers.h"
#include "host/formats/image/object_index.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/log.h"

namespace multum {
namespace {

std::string channel(const std::string& pass, char colour) {
  return pass.empty() ? std::string(1, colour) : pass + "." + colour;
}

}  // namespace

void check_size(const AnimationJob& job, const std::string& path, const ExrLayers& layers) {
  if (layers.width != job.width || layers.height != job.height)
    throw Error(ErrorCode::kInput, fmt::format("{}: is {} x {} pixels, {} says {} x {}", path, layers.width,
                                               layers.height, job.path, job.width, job.height));
}

ParameterizedScene::ParameterizedScene(AnimationJob job)
    : job_(std::move(job)), grid_(job_), meshes_(read_object_meshes(job_.geometry_file, job_.uv_set)) {
  for (const AnimationObject& object : job_.objects) {
    const auto found =
        std::find_if(meshes_.begin(), meshes_.end(), [&](const ObjectMesh& mesh) { return mesh.name == object.mesh; });
    MULTUM_CHECK(found != meshes_.end());  // the job was validated against the same file
    mesh_of_object_.push_back(static_cast<int>(found - meshes_.begin()));
  }
  draw_items();
  check_cameras();
}

void ParameterizedScene::draw_items() {
  for (int p = 0; p < static_cast<int>(poses().size()); ++p)
    items_.push_back(draw_item_buffer(placed(p), camera(p).projection, job_.width, job_.height));
}

std::vector<PlacedObject> ParameterizedScene::placed(int pose) const {
  std::vector<PlacedObject> placed;
  for (std::size_t m = 0; m < meshes_.size(); ++m)
    placed.push_back({&meshes_[m], object_to_camera(static_cast<int>(m), pose)});
  return placed;
}

void ParameterizedScene::check_cameras() {
  if (job_.depth.empty()) return;
  for (const AnimationPose& pose : poses()) {
    const auto with_depth = std::find_if(pose.samples.begin(), pose.samples.end(), [&](int s) {
      return !job_.samples[static_cast<std::size_t>(s)].geometry.empty();
    });
    if (with_depth == pose.samples.end()) continue;
    const AnimationSample& sample = job_.samples[static_cast<std::size_t>(*with_depth)];
    ExrLayers layers = read_exr_channels(sample.geometry, {job_.depth});
    check_size(job_, sample.geometry, layers);
    const CameraCheck check = check_camera(job_, sample, meshes_, layers.channels[job_.depth], {});
    nan_depths_ += check.nan_depths;
    if (check.tested == 0)
      log_warning(sample.geometry, fmt::format("has no usable depth, so camera '{}' is not checked",
                                               job_.cameras[static_cast<std::size_t>(sample.camera)].name));
  }
}

const AnimationCamera& ParameterizedScene::camera(int pose) const {
  return job_.cameras[static_cast<std::size_t>(poses()[static_cast<std::size_t>(pose)].camera)];
}

glm::dmat4 ParameterizedScene::object_to_camera(int mesh, int pose) const {
  return camera(pose).world_to_camera *
         object_place(meshes_[static_cast<std::size_t>(mesh)], poses()[static_cast<std::size_t>(pose)].object_to_world);
}

glm::dmat4 ParameterizedScene::world_to_clip(int pose) const {
  return camera(pose).projection * camera(pose).world_to_camera;
}

ForwardView ParameterizedScene::forward_view(std::size_t object, int pose, const ObjectLayer& layer) const {
  const int mesh = mesh_of(object);
  return {camera(pose).projection * object_to_camera(mesh, pose), &items(pose), mesh, &layer};
}

TextureMapping ParameterizedScene::find_mapping(std::size_t object, int block) const {
  std::vector<MappingView> views;
  for (std::size_t p = 0; p < poses().size(); ++p) {
    if (poses()[p].block != block) continue;
    const int mesh = mesh_of(object), pose = static_cast<int>(p);
    views.push_back({object_to_camera(mesh, pose), camera(pose).projection, &items_[p], mesh});
  }
  return optimise_texture_mapping(meshes_[static_cast<std::size_t>(mesh_of(object))], views,
                                  job_.objects[object].texture);
}

std::vector<std::vector<float>> ParameterizedScene::coverages(int number) const {
  const AnimationSample& sample = job_.samples[static_cast<std::size_t>(number)];
  if (!sample.object_index.empty()) {
    std::vector<int> indices;
    for (const AnimationObject& object : job_.objects) indices.push_back(object.index);
    auto coverages = read_object_index_coverage(sample.object_index, job_.width, job_.height, indices);
    unmix_silhouettes(pose_of(number), coverages);
    return coverages;
  }
  std::vector<std::string> names;
  for (const AnimationObject& object : job_.objects) names.push_back(object.cryptomatte);
  auto coverages = read_cryptomatte_coverage(sample.geometry, job_.cryptomatte, names);
  const std::size_t pixel_count = static_cast<std::size_t>(job_.width) * static_cast<std::size_t>(job_.height);
  for (const auto& coverage : coverages)
    if (coverage.size() != pixel_count)
      throw Error(ErrorCode::kInput, fmt::format("{}: its Cryptomatte does not have {} x {} pixels as in {}",
                                                 sample.geometry, job_.width, job_.height, job_.path));
  return coverages;
}

// In an object-index image, each pixel has the number of the object at its middle. If the geometry also shows this
// object in the pixel, each object's share of the pixel is computed from the geometry. Otherwise, for example for
// displaced or unlisted objects, the whole pixel belongs to the object in the image.
void ParameterizedScene::unmix_silhouettes(int pose, std::vector<std::vector<float>>& coverages) const {
  constexpr int kSubPixels = 4;  // sub-pixels along a pixel's side, so that shares have steps of 1/16
  const int factor = std::clamp(kItemBufferSideMax / std::max(job_.width, job_.height), 1, kSubPixels);
  const std::vector<std::vector<float>> drawn =
      item_coverage(draw_item_buffer(placed(pose), camera(pose).projection, factor * job_.width, factor * job_.height),
                    factor, static_cast<int>(meshes_.size()));
  for (std::size_t i = 0; i < drawn.front().size(); ++i)
    for (std::size_t k = 0; k < coverages.size(); ++k) {
      if (!(coverages[k][i] > 0.0f) || !(drawn[static_cast<std::size_t>(mesh_of(k))][i] > 0.0f)) continue;
      for (std::size_t other = 0; other < coverages.size(); ++other)
        coverages[other][i] = drawn[static_cast<std::size_t>(mesh_of(other))][i];
      break;
    }
}

std::vector<float> ParameterizedScene::layer_picture(int number, const AnimationLayer& layer) const {
  const AnimationSample& sample = job_.samples[static_cast<std::size_t>(number)];
  std::vector<std::string> names;
  for (const std::string& pass : layer.passes)
    for (const char colour : {'R', 'G', 'B'}) names.push_back(channel(pass, colour));
  const ExrLayers layers = read_exr_channels(sample.radiance, names);
  check_size(job_, sample.radiance, layers);
  std::vector<float> picture(3u * static_cast<std::size_t>(job_.width) * static_cast<std::size_t>(job_.height), 0.0f);
  for (std::size_t k = 0; k < names.size(); ++k) {
    const std::vector<float>& plane = layers.channels.at(names[k]);
    for (std::size_t i = 0; i < plane.size(); ++i) picture[3 * i + k % 3] += plane[i];
  }
  return picture;
}

std::vector<ObjectLayer> ParameterizedScene::segment(int sample, const AnimationLayer& layer, int threads,
                                                     SegmentationReport* report) const {
  const std::vector<std::vector<float>> covered = coverages(sample);
  const std::vector<float> picture = layer_picture(sample, layer);
  SegmentationSettings settings;
  settings.radiance_max = job_.radiance_max;
  settings.coverage_min = job_.coverage_min;
  settings.threads = threads;
  return segment_layer({job_.width, job_.height, picture, {covered.begin(), covered.end()}}, settings, report);
}

}  // namespace multum
