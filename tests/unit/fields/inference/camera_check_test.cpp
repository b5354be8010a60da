// SPDX-License-Identifier: Apache-2.0
// Tests that cameras which fit their depths pass, and that other cameras are refused. The expected counts have closed
// forms.
#include "host/fields/inference/mapping/camera_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/ext/matrix_transform.hpp>

#include "host/formats/image/files/exr_layers.h"
#include "tests/unit/fields/inference/animation_test_scene.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

// The picture has 40 x 20 pixels and extends 1/8 to each side at a distance of 2 from a triangle that fills it. The
// projection is skewed, so that every entry matters.
struct CheckScene {
  AnimationJob job;
  AnimationSample sample;
  std::vector<ObjectMesh> objects;
  std::vector<float> depth;

  CheckScene() {
    job.path = "animation.toml";
    job.width = 40;
    job.height = 20;
    AnimationCamera camera;
    camera.name = "left";
    camera.world_to_camera = glm::translate(glm::dmat4(1.0), glm::dvec3(-0.25, -0.25, -2.0));
    camera.projection = glm::dmat4(0.0);
    camera.projection[0][0] = camera.projection[1][1] = 16.0;
    camera.projection[2][0] = 0.125;
    camera.projection[2][2] = -1.02020202;
    camera.projection[3][2] = -0.202020202;
    camera.projection[2][3] = -1.0;
    job.cameras = {camera};
    sample.name = "v00_p00";
    ObjectMesh thing;
    thing.name = "thing";
    thing.positions = {{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}};
    thing.indices = {0, 1, 2};
    objects = {thing};
    depth.assign(800, 2.0f);
  }
  CameraCheck check(const std::vector<float>& coverage = {}) const {
    return check_camera(job, sample, objects, depth, coverage);
  }
  void expect_refused(const std::vector<std::string>& parts) const {
    expect_error(ErrorCode::kInput, parts, [&] { check(); });
  }
};

TEST(CameraCheck, DepthsOnTheObjectPass) {
  const CameraCheck check = CheckScene().check();
  EXPECT_EQ(check.tested, 512);
  EXPECT_EQ(check.off, 0);
  EXPECT_LT(check.distance_median, 1e-12);
  EXPECT_EQ(check.nan_depths, 0);
}

TEST(CameraCheck, DepthsOffTheObjectAreRefusedByTheirDistance) {
  CheckScene scene;
  scene.depth.assign(800, 2.25f);
  scene.expect_refused({"animation.toml", "v00_p00", "left", "100 %", "512", "0.01", "0.25", "10 %"});
  scene.job.depth_tolerance = 0.112;  // 0.25 is 0.111 of 2.25
  EXPECT_NEAR(scene.check().distance_median, 0.25, 1e-12);
  // The camera looks past the triangle, so that the whole picture is outside it.
  scene.job.depth_tolerance = 1.0;
  scene.depth.assign(800, 2.0f);
  for (glm::vec3& p : scene.objects[0].positions) p.x += 1000.0f;
  scene.expect_refused({"100 %", "512"});
}

TEST(CameraCheck, AWrongCameraIsRefused) {
  CheckScene scene;
  scene.job.cameras[0].world_to_camera = glm::rotate(scene.job.cameras[0].world_to_camera, 1.0, glm::dvec3(0, 1, 0));
  scene.expect_refused({"camera left"});
}

TEST(CameraCheck, ObjectsThatMoveAreWhereTheSampleSays) {
  CheckScene scene;
  scene.objects[0].object_to_world = glm::translate(glm::dmat4(1.0), glm::dvec3(0.0, 0.0, -1.0));
  scene.expect_refused({"median", "1"});
  scene.sample.object_to_world["thing"] = glm::dmat4(1.0);
  EXPECT_EQ(scene.check().off, 0);
}

TEST(CameraCheck, ATenthMayBeOff) {
  CheckScene scene;
  scene.job.width = 20;
  scene.job.height = 5;
  scene.depth.assign(100, 2.0f);
  for (std::size_t i = 0; i < 10; ++i) scene.depth[i] = 3.0f;
  const CameraCheck check = scene.check();
  EXPECT_EQ(check.tested, 100);
  EXPECT_EQ(check.off, 10);
  scene.depth[10] = 3.0f;
  scene.expect_refused({"11 % of 100 pixels"});
}

TEST(CameraCheck, WhatIsNoDepthIsLeftOut) {
  CheckScene scene;
  scene.depth.assign(800, NAN);
  EXPECT_EQ(scene.check().tested, 0);
  EXPECT_EQ(scene.check().nan_depths, 800);
  for (const float value : {0.0f, -2.0f, HUGE_VALF, 1e10f, 10.5f}) {  // the far plane is at 10
    scene.depth.assign(800, value);
    scene.depth[7] = 2.0f;
    scene.depth[8] = NAN;
    const CameraCheck check = scene.check();
    EXPECT_EQ(check.tested, 1) << value;
    EXPECT_EQ(check.off, 0) << value;
    EXPECT_EQ(check.nan_depths, 1) << value;
  }
  scene.depth.assign(800, 9.5f);  // this depth is in front of the far plane, so it is tested, and it is wrong
  scene.expect_refused({"100 % of 512"});
  std::vector<float> coverage(800, 0.5f);
  coverage[3] = 1.0f;
  scene.depth[3] = 2.0f;
  EXPECT_EQ(scene.check(coverage).tested, 1);
}

TEST(CameraCheck, AProjectionWithoutFarPlaneSeesAllDepths) {
  CheckScene scene;
  scene.job.cameras[0].projection[2][2] = -1.0;
  scene.objects[0].positions = {{-1e6f, -1e6f, -1e5f}, {1e6f, -1e6f, -1e5f}, {0.0f, 1e6f, -1e5f}};
  scene.depth.assign(800, 1e5f + 2.0f);
  EXPECT_EQ(scene.check().tested, 512);
}

// Every camera of the real field fits its own depths, in both scene files, and no camera fits its neighbour's depths.
TEST(CameraCheck, CamerasOfTheRealFieldFit) {
  if (shared_field().empty()) GTEST_SKIP() << "MULTUM_SHARED_DATA names no folder with field_demo1";
  const AnimationJob job = job_for_folder(shared_field());
  for (const char* geometry : {"/geometry.glb", "/geometry.obj"}) {
    const std::vector<ObjectMesh> objects = read_object_meshes(shared_field() + geometry, 0);
    for (std::size_t i = 0; i < job.samples.size(); i += 8) {
      AnimationSample sample = job.samples[i];
      const std::vector<float> depth = read_exr_channels(sample.geometry, {job.depth}).channels.at(job.depth);
      const CameraCheck check = check_camera(job, sample, objects, depth, {});
      EXPECT_EQ(check.tested, 512) << sample.name;
      EXPECT_LT(check.off, 3) << sample.name;
      EXPECT_LT(check.distance_median, 1e-4) << sample.name;
      sample.camera = (sample.camera + 1) % static_cast<int>(job.cameras.size());
      expect_error(ErrorCode::kInput, {sample.name}, [&] { check_camera(job, sample, objects, depth, {}); });
    }
  }
}

}  // namespace
}  // namespace multum::testing
