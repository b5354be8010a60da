// SPDX-License-Identifier: Apache-2.0
#include "tests/cli/traced_scene.h"

#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>

#include "host/formats/image/files/png_writer.h"
#include "tests/unit/fields/inference/animation_test_scene.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

constexpr int kSubPixels = 4;  // along each side
constexpr double kNone = std::numeric_limits<double>::infinity();

struct Quad {
  const char* name;
  glm::dvec3 corner, u_edge, v_edge;  // u, v = 0..1 along the edges
  std::uint32_t hash;                 // its Cryptomatte hash
};

const Quad kGround = {"ground", {-1.5, -1.0, 0.0}, {3.0, 0.0, 0.0}, {0.0, 3.0, 0.0}, 0x3f400000u};
const Quad kBoard = {"board", {-0.5, 0.4, 0.0}, {0.9, 0.2, 0.0}, {0.0, 0.0, 0.7}, 0x3e800000u};
const Quad kHidden = {"hidden", {-0.5, -0.5, -1.0}, {0.2, 0.0, 0.0}, {0.0, 0.2, 0.0}, 0x3e400000u};

struct Hit {
  double distance = kNone;  // in lengths of the ray's direction
  double u = 0.0, v = 0.0;
};

Hit intersect(const Quad& quad, const glm::dvec3& eye, const glm::dvec3& direction) {
  const glm::dvec3 normal = glm::cross(quad.u_edge, quad.v_edge);
  const double along = glm::dot(normal, direction);
  if (std::abs(along) < 1e-12) return {};
  const double distance = glm::dot(normal, quad.corner - eye) / along;
  const glm::dvec3 local = eye + distance * direction - quad.corner;
  const double u = glm::dot(local, quad.u_edge) / glm::dot(quad.u_edge, quad.u_edge);
  const double v = glm::dot(local, quad.v_edge) / glm::dot(quad.v_edge, quad.v_edge);
  if (distance <= 0.0 || u < 0.0 || u > 1.0 || v < 0.0 || v > 1.0) return {};
  return {distance, u, v};
}

glm::dmat4 camera_of(int view, double shift) {
  const double angle = 0.1 * view;
  return glm::lookAt(glm::dvec3(2.0 * std::sin(angle) + shift, -2.0 * std::cos(angle), 1.2),
                     glm::dvec3(shift, 0.3, 0.2), glm::dvec3(0.0, 0.0, 1.0));
}

// Returns the radiance of a diffuse surface, which is the same from every direction.
glm::dvec3 diffuse_of(int object, const Hit& hit, int light) {
  const double level = 0.6 + 0.3 * light;
  if (object == 1) return level * glm::dvec3(0.3, 0.3 + 0.1 * hit.v, 0.5);
  const double waves = std::sin(12.0 * std::numbers::pi * hit.u) * std::sin(12.0 * std::numbers::pi * hit.v);
  return level * glm::dvec3(0.35 + 0.25 * waves, 0.3 - 0.1 * waves, 0.25);
}

// Returns the board's soft highlight, which moves with the eye and the light.
glm::dvec3 glossy_of(int object, const Hit& hit, int view, int light) {
  if (object != 1) return glm::dvec3(0.0);
  const double du = hit.u - 0.4 - 0.05 * view, dv = hit.v - 0.5 - 0.1 * light;
  return glm::dvec3(0.3 * std::exp(-25.0 * (du * du + dv * dv)));
}

nlohmann::json matrix_rows(const glm::dmat4& m) {
  nlohmann::json rows = nlohmann::json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({m[0][r], m[1][r], m[2][r], m[3][r]});
  return rows;
}

struct Sub {
  int object = -1;
  Hit hit;
};

// Holds the sub-pixels of one view, row by row.
class View {
 public:
  View(const TracedScene& scene, int number) : scene_(scene), number_(number) {
    projection_ = glm::perspective(0.8, static_cast<double>(scene.width) / scene.height, 0.1, 20.0);
    const glm::dmat4 world_to_camera = camera_of(number, 0.0);
    const glm::dmat4 camera_to_world = glm::inverse(world_to_camera);
    const glm::dvec3 eye(camera_to_world[3]);
    for (int y = 0; y < scene.height * kSubPixels; ++y)
      for (int x = 0; x < scene.width * kSubPixels; ++x) subs_.push_back(trace(eye, camera_to_world, x + 0.5, y + 0.5));
    for (int y = 0; y < scene.height; ++y)
      for (int x = 0; x < scene.width; ++x)
        centres_.push_back(trace(eye, camera_to_world, (x + 0.5) * kSubPixels, (y + 0.5) * kSubPixels));
  }

  template <typename Value>
  glm::dvec3 mean(int x, int y, const Value& value) const {
    glm::dvec3 sum(0.0);
    for (int sy = 0; sy < kSubPixels; ++sy)
      for (int sx = 0; sx < kSubPixels; ++sx) {
        const Sub& sub =
            subs_[static_cast<std::size_t>((y * kSubPixels + sy) * scene_.width * kSubPixels + x * kSubPixels + sx)];
        if (sub.object >= 0) sum += value(sub);
      }
    return sum / static_cast<double>(kSubPixels * kSubPixels);
  }
  const Sub& middle(int x, int y) const { return centres_[static_cast<std::size_t>(y * scene_.width + x)]; }
  double depth(int x, int y) const { return middle(x, y).object < 0 ? 1e10 : middle(x, y).hit.distance; }
  const glm::dmat4& projection() const { return projection_; }
  int number() const { return number_; }

 private:
  // The ray's direction has length 1 along -z, so the ray distance is the depth.
  Sub trace(const glm::dvec3& eye, const glm::dmat4& camera_to_world, double sub_x, double sub_y) const {
    const double x = 2.0 * sub_x / (scene_.width * kSubPixels) - 1.0,
                 y = 1.0 - 2.0 * sub_y / (scene_.height * kSubPixels);
    const glm::dvec3 direction(camera_to_world * glm::dvec4(x / projection_[0][0], y / projection_[1][1], -1.0, 0.0));
    Sub nearest;
    int object = 0;
    for (const Quad* quad : {&kGround, &kBoard}) {
      const Hit hit = intersect(*quad, eye, direction);
      if (hit.distance < nearest.hit.distance) nearest = {object, hit};
      ++object;
    }
    return nearest;
  }

  const TracedScene& scene_;
  int number_;
  glm::dmat4 projection_;
  std::vector<Sub> subs_, centres_;
};

void write_radiance(const std::string& path, const TracedScene& scene, const View& view, int light) {
  ExrPart part{"", {}, {}, {}};
  const auto add = [&](const std::string& prefix, const auto& value) {
    for (int c = 0; c < 3; ++c) {
      part.channels.push_back((prefix.empty() ? "" : prefix + ".") + "RGB"[c]);
      std::vector<float> plane;
      for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x)
          plane.push_back(static_cast<float>(view.mean(x, y, [&](const Sub& sub) { return value(sub); })[c]));
      part.planes.push_back(plane);
    }
  };
  const auto diffuse = [&](const Sub& sub) { return diffuse_of(sub.object, sub.hit, light); };
  const auto glossy = [&](const Sub& sub) { return glossy_of(sub.object, sub.hit, view.number(), light); };
  add("", [&](const Sub& sub) { return diffuse(sub) + glossy(sub); });
  add("diffuse", diffuse);
  add("glossy", glossy);
  add("transmission", [](const Sub&) { return glm::dvec3(0.0); });
  if (scene.has_bad_pixels) {
    const auto middle = static_cast<std::size_t>((scene.height / 2) * scene.width + scene.width / 2);
    part.planes[3][middle] = std::numeric_limits<float>::quiet_NaN();
    part.planes[4][middle + 1] = std::numeric_limits<float>::infinity();
  }
  write_exr(path, scene.width, scene.height, {part});
}

void write_geometry(const std::string& path, const TracedScene& scene, const View& view) {
  ExrPart part{"", {"Z", "CryptoObject00.r", "CryptoObject00.g", "CryptoObject00.b", "CryptoObject00.a"}, {}, {}};
  part.planes.resize(5);
  for (int y = 0; y < scene.height; ++y)
    for (int x = 0; x < scene.width; ++x) {
      const bool is_hole = scene.has_depth_holes && x % 7 == 0;
      part.planes[0].push_back(is_hole ? std::numeric_limits<float>::quiet_NaN()
                                       : static_cast<float>(view.depth(x, y)));
      const std::array<double, 2> covered = {
          view.mean(x, y, [](const Sub& sub) { return glm::dvec3(sub.object == 0 ? 1.0 : 0.0); }).x,
          view.mean(x, y, [](const Sub& sub) { return glm::dvec3(sub.object == 1 ? 1.0 : 0.0); }).x};
      const std::size_t first = covered[0] >= covered[1] ? 0 : 1;
      for (const std::size_t rank : {std::size_t{0}, std::size_t{1}}) {
        const std::size_t object = rank == 0 ? first : 1 - first;
        const std::uint32_t hash = object == 0 ? kGround.hash : kBoard.hash;
        part.planes[1 + 2 * rank].push_back(covered[object] > 0.0 ? std::bit_cast<float>(hash) : 0.0f);
        part.planes[2 + 2 * rank].push_back(static_cast<float>(covered[object]));
      }
    }
  part.attributes = {
      {"cryptomatte/1234567/name", "ViewLayer.CryptoObject"},
      {"cryptomatte/1234567/hash", "MurmurHash3_32"},
      {"cryptomatte/1234567/conversion", "uint32_to_float32"},
      {"cryptomatte/1234567/manifest", R"({"ground":"3f400000","board":"3e800000","hidden":"3e400000"})"}};
  write_exr(path, scene.width, scene.height, {part});
}

// Writes the object at the centre of each pixel. scene.json has the objects in alphabetical order: 1 board, 2 ground.
void write_object_index(const std::string& path, const TracedScene& scene, const View& view) {
  Png8Image image{scene.width, scene.height, 1, {}};
  for (int y = 0; y < scene.height; ++y)
    for (int x = 0; x < scene.width; ++x)
      image.interleaved.push_back(
          static_cast<std::uint8_t>(view.middle(x, y).object < 0 ? 0 : 2 - view.middle(x, y).object));
  write_png8(path, image);
}

void append_quad(const Quad& quad, int number, std::string& obj) {
  obj += std::string("o ") + quad.name + "_Mesh\n";
  for (const auto& [u, v] : {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)}) {
    const glm::dvec3 p = quad.corner + static_cast<double>(u) * quad.u_edge + static_cast<double>(v) * quad.v_edge;
    obj += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
    obj += "vt " + std::to_string(u) + " " + std::to_string(v) + "\n";
  }
  const auto corner = [&](int k) {
    return " " + std::to_string(4 * number + k) + "/" + std::to_string(4 * number + k);
  };
  obj += "f" + corner(1) + corner(2) + corner(3) + "\nf" + corner(1) + corner(3) + corner(4) + "\n";
}

}  // namespace

void write_traced_folder(const std::string& folder, const TracedScene& scene) {
  nlohmann::json json = {{"mode", "demo1"},
                         {"width", scene.width},
                         {"height", scene.height},
                         {"views", scene.views},
                         {"params", scene.lights}};
  std::string obj;
  int number = 0;
  for (const Quad* quad : {&kGround, &kBoard, &kHidden}) {
    if (quad == &kHidden && !scene.has_hidden_object) continue;
    append_quad(*quad, number++, obj);
    json["objects"][quad->name] = {{"triangles", 2}, {"object_to_world", matrix_rows(glm::dmat4(1.0))}};
  }
  for (int v = 0; v < scene.views; ++v) {
    const View view(scene, v);
    const glm::dmat4 world_to_camera = camera_of(v, scene.camera_shift);
    for (int p = 0; p < scene.lights; ++p) {
      const std::string name = "v0" + std::to_string(v) + "_p0" + std::to_string(p);
      json["samples"].push_back({{"index", v * scene.lights + p},
                                 {"view", v},
                                 {"param", p},
                                 {"name", name},
                                 {"light_swing_deg", 30.0 * p},
                                 {"world_to_camera", matrix_rows(world_to_camera)},
                                 {"projection", matrix_rows(view.projection())},
                                 {"world_to_clip", matrix_rows(view.projection() * world_to_camera)}});
      write_radiance(folder + "/rad_" + name + ".exr", scene, view, p);
      if (scene.has_object_index) write_object_index(folder + "/id_" + name + ".png", scene, view);
    }
    write_geometry(folder + "/geom_v0" + std::to_string(v) + ".exr", scene, view);
  }
  write_bytes(folder + "/scene.json", json.dump(1));
  write_bytes(folder + "/geometry.obj", obj);
}

void TracedSceneTest::write_scene(const TracedScene& scene) {
  std::filesystem::create_directory(path("renders"));
  write_traced_folder(path("renders"), scene);
  const ProgramResult result = multum({"animation", path("renders"), "-o", path("animation.toml")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
}

ProgramResult TracedSceneTest::infer(std::vector<std::string> more) const {
  std::vector<std::string> arguments = {"infer", path("animation.toml"), "-o", path("out"), "--context", "osmesa"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return multum(arguments);
}

void TracedSceneTest::infer_scene(const TracedScene& scene) {
  write_scene(scene);
  const ProgramResult result = infer({"--no-frames", "--no-comparison"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
}

}  // namespace multum::testing
