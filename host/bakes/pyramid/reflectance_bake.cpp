// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/pyramid/reflectance_bake.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "host/formats/image/files/environment_file.h"
#include "host/formats/opencl/device_counts.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/stopwatch.h"
#include "host/foundation/base/version.h"
#include "kernels/shared/reflectance.h"

namespace multum {
namespace {

constexpr std::size_t kLightsMax = std::size_t{1} << 22;

// The number of light evaluations per launch. Longer launches would block the screen of a GPU and delay Ctrl-C.
constexpr double kEvaluationsALaunch = 2e8;

nlohmann::json json_of(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

void refuse(const std::string& what) { throw Error(ErrorCode::kUsage, what); }

bool is_colour(const glm::dvec3& v) {
  for (int c = 0; c < 3; ++c)
    if (!(v[c] >= 0.0) || !std::isfinite(v[c])) return false;
  return true;
}

MultumReflectanceLight device_light(const ReflectanceLight& light, const ReflectanceFrame& frame) {
  const glm::dvec3 world = glm::normalize(light.direction);
  const glm::dvec3 l(glm::dot(world, frame.right), glm::dot(world, frame.up), glm::dot(world, frame.viewer));
  const glm::dvec3 sum = l + glm::dvec3(0.0, 0.0, 1.0);
  // If the light comes from exactly behind, there is no half vector, and no light is reflected to the viewer.
  const glm::dvec3 h = glm::length(sum) > 1e-9 ? glm::normalize(sum) : glm::dvec3(0.0, 0.0, 1.0);
  const auto f = [](double v) { return static_cast<float>(v); };
  return {f(l.x),
          f(l.y),
          f(l.z),
          0.0f,
          f(h.x),
          f(h.y),
          f(h.z),
          0.0f,
          f(light.irradiance.x),
          f(light.irradiance.y),
          f(light.irradiance.z),
          0.0f};
}

MultumReflectanceMap device_map(const ReflectanceJob& job, std::size_t light_count) {
  MultumReflectanceMap map{};
  map.size = job.size;
  map.sample_side = job.sample_side;
  map.light_count = static_cast<int>(light_count);
  map.exponent = job.exponent;
  const auto f = [](double v) { return static_cast<float>(v); };
  map.diffuse_red = f(job.diffuse.x), map.diffuse_green = f(job.diffuse.y), map.diffuse_blue = f(job.diffuse.z);
  map.specular_red = f(job.specular.x), map.specular_green = f(job.specular.y), map.specular_blue = f(job.specular.z);
  return map;
}

// Fills bands of the finest level.
class ReflectanceTexels {
 public:
  ReflectanceTexels(Device& device, const ReflectanceJob& job, const std::vector<ReflectanceLight>& lights)
      : device_(device), map_(device_map(job, lights.size())) {
    const ReflectanceFrame frame = reflectance_frame(job.viewer, job.up);
    for (const ReflectanceLight& light : lights) host_lights_.push_back(device_light(light, frame));
    lights_ = device.wrap_buffer(host_lights_.data(), host_lights_.size() * sizeof(MultumReflectanceLight), "lights");
    texels_ = device.kernel("reflectance_pyramid", "reflectance_texels", {1, 1, false});
  }
  void fill(const MultumBoxBand& band, const BoxPyramid& pyramid) {
    texels_.launch({static_cast<std::size_t>(band.row_count) * static_cast<std::size_t>(band.map_width), kBoxLocalSize},
                   lights_, pyramid.nodes(), map_, band);
    device_.finish();
  }
  double evaluations_a_row() const {
    return static_cast<double>(map_.size) * map_.sample_side * map_.sample_side * map_.light_count;
  }

 private:
  Device& device_;
  MultumReflectanceMap map_;
  std::vector<MultumReflectanceLight> host_lights_;
  DeviceBuffer lights_;
  Kernel texels_;
};

BoxMap box_map(const ReflectanceJob& job) { return {job.size, job.size, 3, 0}; }

// This memory suffices for a band of about kEvaluationsALaunch evaluations, and for at least one row.
BoxPyramid::Memory memory_of(const ReflectanceJob& job, double evaluations_a_row) {
  const auto size = static_cast<std::size_t>(job.size);
  const double rows = std::max(1.0, kEvaluationsALaunch / std::max(1.0, evaluations_a_row));
  const double row_bytes = 3.0 * 4.0 * 7.0 * static_cast<double>(job.size);  // two rows of nodes, and waiting rows
  const auto wanted = static_cast<std::uint64_t>(std::min(rows * row_bytes, 1e12)) +
                      static_cast<std::uint64_t>(size) * 600 + (std::uint64_t{1} << 16);
  return {std::min(job.memory_bytes, wanted), 4 * 3 * size};
}

PyramidHeader make_header(const ReflectanceJob& job) {
  PyramidHeader header;
  header.kind = PyramidKind::kReflectance;
  header.map.encoding = job.encoding;
  header.map.wrap_s = header.map.wrap_t = WrapMode::kClamp;
  header.map.width = header.map.height = job.size;
  BakedProvenance& from = header.map.provenance;
  from.software = software_version();
  from.source_name = std::filesystem::path(job.environment).filename().string();
  from.source_hash = job.environment.empty() ? "" : hash_file(job.environment);
  nlohmann::json lights = nlohmann::json::array();
  for (const ReflectanceLight& light : job.lights)
    lights.push_back({{"direction", json_of(light.direction)}, {"irradiance", json_of(light.irradiance)}});
  from.settings =
      nlohmann::json{{"pyramid", pyramid_kind_name(PyramidKind::kReflectance)},
                     {"frame", nlohmann::json::parse(reflectance_frame_json(reflectance_frame(job.viewer, job.up)))},
                     {"lights", lights},
                     {"environment_scale", job.environment_scale},
                     {"exponent", job.exponent},
                     {"diffuse", json_of(job.diffuse)},
                     {"specular", json_of(job.specular)},
                     {"sample_side", job.sample_side},
                     {"size", job.size},
                     {"encoding", storage_encoding_name(job.encoding)}}
          .dump();
  from.settings_hash = hash_text(from.settings);
  return header;
}

}  // namespace

void validate(const ReflectanceJob& job) {
  if (job.lights.empty() && job.environment.empty())
    refuse("found no --light and no --environment, expected one of them");
  for (const ReflectanceLight& light : job.lights)
    if (!(glm::length(light.direction) > 0.0) || !is_colour(light.irradiance))
      refuse("--light: expected a direction that is not zero, and an irradiance >= 0");
  if (!(glm::length(job.viewer) > 0.0)) refuse("--viewer is 0,0,0, expected a direction towards the viewer");
  if (!(job.exponent >= 1.0f && job.exponent <= 1e5f))
    refuse(fmt::format("--brdf has an exponent of {}, expected 1 to 100000", job.exponent));
  if (!is_colour(job.diffuse) || !is_colour(job.specular)) refuse("--diffuse, --specular: expected numbers >= 0");
  if (job.size < 4 || job.size > 8192) refuse(fmt::format("--size is {}, expected 4 to 8192", job.size));
  if (job.sample_side < 1 || job.sample_side > 16)
    refuse(fmt::format("--texel-samples is {}, expected 1 to 16 per side", job.sample_side));
  validate(job.writing);
}

std::vector<ReflectanceLight> environment_lights(const EnvironmentMap& environment, float exponent, float scale) {
  const double cell_max = 0.5 / std::sqrt(static_cast<double>(exponent));  // radians
  const EnvironmentMap cells = shrink(environment, std::max(32, static_cast<int>(std::ceil(2.0 * M_PI / cell_max))));
  std::vector<ReflectanceLight> lights;
  for (int y = 0; y < cells.height; ++y) {
    const double solid_angle = texel_solid_angle(cells.width, cells.height, y) * static_cast<double>(scale);
    for (int x = 0; x < cells.width; ++x) {
      const glm::dvec3 radiance(cells.texels[static_cast<std::size_t>(y * cells.width + x)]);
      if (radiance.x + radiance.y + radiance.z <= 0.0) continue;
      lights.push_back(
          {environment_direction((x + 0.5) / cells.width, (y + 0.5) / cells.height), radiance * solid_angle});
    }
  }
  return lights;
}

Pyramid reflectance_pyramid(const ReflectanceJob& job, Device& device) {
  validate(job);
  ReflectanceTexels texels(device, job, job.lights);
  BoxPyramid boxes(device, box_map(job), memory_of(job, texels.evaluations_a_row()));
  Pyramid pyramid{make_header(job), {}};
  for (int l = 0; l < pyramid.header.level_count(); ++l)
    pyramid.levels.push_back({mip_level_size(job.size, l), mip_level_size(job.size, l), {}});
  run_box_bands(
      boxes, box_map(job), [&](const MultumBoxBand& band) { texels.fill(band, boxes); },
      [&](const BoxRows& rows) {
        const PyramidLevel level = interleaved(rows, 3);
        std::vector<float>& to = pyramid.levels[static_cast<std::size_t>(rows.level)].values;
        to.insert(to.end(), level.values.begin(), level.values.end());
      },
      nullptr);
  return pyramid;
}

MipReport bake_reflectance(const ReflectanceJob& job, Device& device, Progress* progress) {
  validate(job);
  check_paths_differ({job.environment}, {job.output, job.report});
  if (!job.output.ends_with(".exr"))
    throw Error(ErrorCode::kUsage,
                job.output + ": is not a valid name for a pyramid, expected a name that ends in .exr");
  check_writable(job.output);
  if (!job.report.empty()) check_writable(job.report);
  const Stopwatch reading;
  MipReport report;
  const PyramidHeader header = make_header(job);
  if (!job.force && is_pyramid_in_place(job.output, header.map.provenance)) {
    report.unchanged = true;
    if (!job.report.empty()) write_text_file(job.report, report.to_json());
    return report;
  }
  std::vector<ReflectanceLight> lights = job.lights;
  if (!job.environment.empty()) {
    progress_stage(progress, "read");
    const ColourMap source = read_environment_map(job.environment);
    EnvironmentMap environment{source.width, source.height, {}};
    for (std::size_t i = 0; i < source.r.size(); ++i)
      environment.texels.emplace_back(source.r[i], source.g[i], source.b[i]);
    const std::vector<ReflectanceLight> more = environment_lights(environment, job.exponent, job.environment_scale);
    lights.insert(lights.end(), more.begin(), more.end());
    report.format = source.format;
    report.clamped_count = source.clamped_count;
    log_info(fmt::format("{}: {}, {} directions", job.environment, source.format, more.size()));
    MULTUM_CHECK(lights.size() <= kLightsMax);
  }
  if (lights.empty()) throw Error(ErrorCode::kInput, job.environment + ": is black, expected light");
  report.width = report.height = job.size;
  report.level_count = header.level_count();
  const DeviceCounts counts(device);
  report.device = device.info().name;
  report.read_seconds = reading.seconds();
  progress_start(progress, static_cast<std::uint64_t>(job.size) * static_cast<std::uint64_t>(job.size));
  progress_stage(progress, "light");
  const Stopwatch averaging;
  ReflectanceTexels texels(device, job, lights);
  BoxPyramid pyramid(device, box_map(job), memory_of(job, texels.evaluations_a_row()));
  PyramidWriter writer(job.output, header, job.writing);
  const auto fill = [&](const MultumBoxBand& band) { texels.fill(band, pyramid); };
  report.limited_count = write_box_pyramid(pyramid, box_map(job), writer, job.encoding, fill, progress);
  report.average_seconds = averaging.seconds();
  progress_stage(progress, "write");
  writer.commit(progress);
  report.content_hash = writer.content_hash();
  report.launches = counts.launches();
  if (!job.report.empty()) write_text_file(job.report, report.to_json());
  progress_finish(progress);
  return report;
}

}  // namespace multum
