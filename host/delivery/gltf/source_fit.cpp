// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/gltf/source_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <optional>
#include <utility>

#include "host/delivery/export/material_folder.h"
#include "host/delivery/gltf/plane_resize.h"
#include "host/formats/asset/baked_file.h"
#include "host/formats/image/image_reader.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/surface_points.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr float kCodeMax = 255.0f;

SpillPolicy spill_of(const SourceFitSettings& settings) {
  return {settings.folder,
          static_cast<std::int64_t>(settings.memory_bytes / (settings.surface == MapSurface::kInterpolated ? 6 : 4))};
}

std::string extracted(const GltfAsset& asset, std::size_t image, const std::string& folder) {
  const std::string bytes = read_gltf_image(asset, image).bytes, type = gltf_image_type(bytes);
  const std::string file = fmt::format("{}/image_{}.{}", folder, image, type.substr(type.find('/') + 1));
  std::error_code error;
  if (!std::filesystem::exists(file, error)) write_text_file(file, bytes);
  return file;
}

ImageReadSettings reading_of(const SourceFitSettings& settings) {
  ImageReadSettings reading;
  reading.threads = settings.threads;
  reading.all_channels = true;
  return reading;
}

float fourth_power(float v) { return v * v * (v * v); }

// Reads occlusion (red), roughness (green) and metalness (blue) from an image. Roughness is multiplied by the
// material's factor. A grey image sets all three.
PlaneStore read_surface(const GltfAsset& asset, const std::string& file, const LobeSource& source, bool is_fourth_power,
                        const SourceFitSettings& settings) {
  ImageReader reader(file, reading_of(settings));
  const RawImageInfo info = reader.info();
  const SampleConverter converter(info.base_type);
  const auto channels = size_of(info.channel_count), width = size_of(info.width);
  const bool is_grey = channels < 3;
  const auto factor = static_cast<float>(source.roughness_factor);
  for (const std::string& note : info.notes)
    log_warning(fmt::format("{}: image {}", asset.path, *source.surface_image), note);
  PlaneStore planes = make_plane_store(info.width, info.height, spill_of(settings));
  reader.read(
      [&](const RawBand& band) {
        for_each_row_band(band.row_count, kRowsPerBand, settings.threads, [&](int, int begin, int end) {
          const std::size_t texels = width * size_of(end - begin);
          std::vector<float> values(texels * channels), rough(texels), occlusion(texels), metal(texels);
          converter.convert(band.samples + size_of(begin) * info.row_bytes, values.size(), values.data());
          for (std::size_t i = 0; i < texels; ++i) {
            const auto value = [&](std::size_t c) {
              return std::clamp(values[i * channels + (is_grey ? 0 : c)], 0.0f, 1.0f);
            };
            rough[i] = factor * value(1);
            if (is_fourth_power) rough[i] = fourth_power(rough[i]);
            occlusion[i] = value(0);
            metal[i] = value(2);
          }
          planes.write_rows(band.first_row + begin, end - begin, {rough.data(), occlusion.data(), metal.data()});
        });
      },
      nullptr);
  return planes;
}

PlaneStore read_normals(const GltfAsset& asset, const PreparedSource& prepared, const SourceFitSettings& settings,
                        Progress* progress) {
  const LobeSource& source = prepared.source;
  NormalMapRows map = of_image(asset, source.normal_image, prepared.normal_file, [&] {
    return read_normal_map_rows(prepared.normal_file, gltf_normal_reading(source, settings), spill_of(settings),
                                settings.threads, progress);
  });
  log_info(fmt::format("{}: image {}: {} x {}, {}; {}", asset.path, source.normal_image, map.normals.width(),
                       map.normals.height(), map.report.encoding, map.report.encoding_reason));
  for (const std::string& warning : map.report.warnings)
    log_warning(asset.path, fmt::format("image {}: {}", source.normal_image, warning));
  if (map.normals.width() == prepared.width && map.normals.height() == prepared.height) return std::move(map.normals);
  return enlarged_planes(
      map.normals,
      {prepared.width, prepared.height, source.wrap_s, source.wrap_t, spill_of(settings), settings.threads},
      [](float& x, float& y, float& z) {
        const float length = std::sqrt(x * x + y * y + z * z);
        if (length > 0.0f) x /= length, y /= length, z /= length;
        else x = y = 0.0f, z = 1.0f;
      });
}

PlaneStore read_material(const GltfAsset& asset, const PreparedSource& prepared, const SourceFitSettings& settings) {
  const LobeSource& source = prepared.source;
  return of_image(asset, *source.surface_image, prepared.surface_file, [&] {
    const RawImageInfo info = ImageReader(prepared.surface_file, reading_of(settings)).info();
    const bool is_same = info.width == prepared.width && info.height == prepared.height;
    PlaneStore planes = read_surface(asset, prepared.surface_file, source, is_same, settings);
    if (is_same) return planes;
    // Renderers filter roughness, while the fit uses alpha^2.
    return enlarged_planes(
        planes, {prepared.width, prepared.height, source.wrap_s, source.wrap_t, spill_of(settings), settings.threads},
        [](float& rough, float&, float&) { rough = fourth_power(rough); });
  });
}

// Rounds rows to 8 bits and writes them.
class LevelSink : public MaterialSink {
 public:
  LevelSink(FittedSource& files, bool carries_occlusion) : files_(files), carries_occlusion_(carries_occlusion) {}

  void add_level(int level, int first_row, MaterialRows rows) override {
    round_material(rows, MaterialTexels::kRgba8);
    const auto component = [](float v) { return 0.5f + 0.5f * v; };
    write(*files_.normal, level, first_row, rows, [&](std::size_t i) {
      const glm::vec3& n = rows.normals[i];
      return glm::vec3(component(n.x), component(n.y), component(n.z));
    });
    write(*files_.surface, level, first_row, rows, [&](std::size_t i) {
      const glm::vec3 texel(carries_occlusion_ ? rows.occlusion[i] : 1.0f, rows.roughness[i],
                            rows.metalness.empty() ? 1.0f : rows.metalness[i]);
      is_one_ = is_one_ && texel == glm::vec3(1.0f);
      return texel;
    });
    if (files_.anisotropy == nullptr) return;
    write(*files_.anisotropy, level, first_row, rows, [&](std::size_t i) {
      const glm::vec3& a = rows.anisotropy[i];
      return glm::vec3(component(a.x), component(a.y), a.z);
    });
  }
  bool is_one() const { return is_one_; }

 private:
  template <typename Texel>
  static void write(LevelFile& file, int level, int first_row, const MaterialRows& rows, const Texel& texel) {
    std::vector<std::uint8_t> codes;
    codes.reserve(4 * rows.normals.size());
    for (std::size_t i = 0; i < rows.normals.size(); ++i) {
      const glm::vec3 v = texel(i);
      for (const float share : {v.x, v.y, v.z, 1.0f})
        codes.push_back(static_cast<std::uint8_t>(std::lround(share * kCodeMax)));
    }
    file.write_rows(level, first_row, codes);
  }

  FittedSource& files_;
  const bool carries_occlusion_;
  bool is_one_ = true;  // whether all values of the surface so far are 1
};

// Returns whether two stored normals have the same direction apart from rounding. Their lengths may differ.
bool is_same_direction(const std::uint8_t* one, const std::uint8_t* other) {
  constexpr float kCosineOfADegree = 0.99985f;
  const auto decoded = [](const std::uint8_t* code) {
    return glm::vec3(code[0], code[1], code[2]) * (2.0f / kCodeMax) - 1.0f;
  };
  const glm::vec3 a = decoded(one), b = decoded(other);
  return glm::dot(a, b) > kCosineOfADegree * glm::length(a) * glm::length(b);
}

// Keeps level 0 exactly as it is in the file. Rounding its unit vectors again would turn them by up to 0.4 degrees,
// which is visible on mirrors.
void keep_finest_normals(const std::string& file, LevelFile& normal, const SourceFitSettings& settings) {
  ImageReader reader(file, reading_of(settings));
  const RawImageInfo info = reader.info();
  if (info.width != normal.width() || info.height != normal.height() || info.channel_count < 3) return;
  const SampleConverter converter(info.base_type);
  const auto channels = size_of(info.channel_count), width = size_of(info.width);
  reader.read(
      [&](const RawBand& band) {
        std::vector<std::uint8_t> rows = normal.read_rows(0, band.first_row, band.row_count);
        for_each_row_band(band.row_count, kRowsPerBand, settings.threads, [&](int, int begin, int end) {
          const std::size_t texels = width * size_of(end - begin);
          std::vector<float> values(texels * channels);
          converter.convert(band.samples + size_of(begin) * info.row_bytes, values.size(), values.data());
          std::uint8_t* code = rows.data() + 4 * width * size_of(begin);
          for (std::size_t i = 0; i < texels; ++i, code += 4) {
            std::array<std::uint8_t, 3> given;
            for (std::size_t c = 0; c < 3; ++c)
              given[c] =
                  static_cast<std::uint8_t>(std::lround(std::clamp(values[i * channels + c], 0.0f, 1.0f) * kCodeMax));
            if (is_same_direction(given.data(), code)) std::copy(given.begin(), given.end(), code);
          }
        });
        normal.write_rows(0, band.first_row, rows);
      },
      nullptr);
}

// Computes rows of a level. Each texel is the mean of the texels that it covers in the previous level, rounded to 8
// bits as in drivers.
std::vector<std::uint8_t> averaged_rows(const LevelFile& file, int level, int first, int count) {
  const int width = mip_level_size(file.width(), level), height = mip_level_size(file.height(), level);
  const int finer_width = mip_level_size(file.width(), level - 1),
            finer_height = mip_level_size(file.height(), level - 1);
  const auto edge = [](int index, int from, int to) { return static_cast<int>(std::int64_t{index} * from / to); };
  const int top = edge(first, finer_height, height), bottom = edge(first + count, finer_height, height);
  const std::vector<std::uint8_t> finer = file.read_rows(level - 1, top, bottom - top);
  std::vector<std::uint8_t> made;
  made.reserve(4 * size_of(width) * size_of(count));
  for (int y = first; y < first + count; ++y)
    for (int x = 0; x < width; ++x) {
      std::array<unsigned, 4> sums{};
      unsigned texels = 0;
      for (int v = edge(y, finer_height, height); v < edge(y + 1, finer_height, height); ++v)
        for (int u = edge(x, finer_width, width); u < edge(x + 1, finer_width, width); ++u, ++texels)
          for (std::size_t c = 0; c < 4; ++c)
            sums[c] += finer[4 * (size_of(v - top) * size_of(finer_width) + size_of(u)) + c];
      for (const unsigned sum : sums) made.push_back(static_cast<std::uint8_t>((sum + texels / 2) / texels));
    }
  return made;
}

constexpr int kAveragedRows = 64;

// Averages level 0 of both textures.
void write_averages(const LevelFile& normal, const LevelFile& surface, LevelFile& averages) {
  for (int level = 0; level < averages.level_count(); ++level) {
    const int height = mip_level_size(averages.height(), level);
    for (int row = 0; row < height; row += kAveragedRows) {
      const int count = std::min(kAveragedRows, height - row);
      if (level > 0) {
        averages.write_rows(level, row, averaged_rows(averages, level, row, count));
        continue;
      }
      std::vector<std::uint8_t> texels = normal.read_rows(0, row, count);
      const std::vector<std::uint8_t> material = surface.read_rows(0, row, count);
      for (std::size_t i = 0; i < texels.size(); i += 4) texels[i + 3] = material[i + 1];
      averages.write_rows(0, row, texels);
    }
  }
}

int rounded_up(int side, int multiple) { return (side + multiple - 1) / multiple * multiple; }

}  // namespace

NormalMapSettings gltf_normal_reading(const LobeSource& source, const SourceFitSettings& settings) {
  NormalMapSettings reading;
  reading.bump_format = BumpFormat::kNormal;
  reading.green = GreenAxis::kUp;
  reading.is_signed = false;
  reading.two_channel = settings.two_channel;
  reading.z_range = settings.z_range;
  reading.refuse_doubts = true;
  reading.normal_scale = static_cast<float>(source.normal_scale);
  reading.wrap_s = source.wrap_s;
  reading.wrap_t = source.wrap_t;
  reading.wrap_s_origin = reading.wrap_t_origin = WrapOrigin::kSaid;
  reading.repair_share_max = 1.0f;  // renderers draw any normal; repaired normals cause a warning
  return reading;
}

namespace {

void prepare(const GltfAsset& asset, const SourceFitSettings& settings, PreparedSource& made) {
  const LobeSource& source = made.source;
  const auto size_of_image = [&](std::size_t image, std::string& file) {
    file = extracted(asset, image, settings.folder);
    return of_image(asset, image, file, [&] {
      const RawImageInfo info = ImageReader(file, reading_of(settings)).info();
      return std::make_pair(info.width, info.height);
    });
  };
  const auto normal = size_of_image(source.normal_image, made.normal_file);
  auto largest = normal;
  bool is_surface_whole = false;
  if (source.surface_image) {
    const auto surface = size_of_image(*source.surface_image, made.surface_file);
    is_surface_whole = surface.first >= normal.first && surface.second >= normal.second;
    largest = {std::max(normal.first, surface.first), std::max(normal.second, surface.second)};
    const auto texels = [](const std::pair<int, int>& size) { return std::int64_t{size.first} * size.second; };
    // A common size of up to four times the larger image is accepted, so that images may differ in one side. If the
    // common size is larger, the images do not belong together.
    if (texels(largest) > 4 * std::max(texels(normal), texels(surface)))
      made.kept = fmt::format("its normals have {} x {} texels, but its roughness has {} x {}", normal.first,
                              normal.second, surface.first, surface.second);
    if (surface != normal)
      made.notes.push_back(fmt::format("normals of {} x {} and roughness of {} x {} were resized to the same size",
                                       normal.first, normal.second, surface.first, surface.second));
  }
  if (normal == std::make_pair(1, 1)) made.kept = "its normal map is a single texel";
  made.width = rounded_up(largest.first, settings.side_multiple);
  made.height = rounded_up(largest.second, settings.side_multiple);
  const auto is_plain = [&](const std::string& file, const std::pair<int, int>& size) {
    return size == std::make_pair(made.width, made.height) && !file.ends_with(".webp");
  };
  made.normal_is_original =
      is_plain(made.normal_file, normal) && source.normal_scale == 1.0 && !settings.two_channel && !settings.z_range;
  made.surface_is_original = source.surface_image && is_plain(made.surface_file, largest) &&
                             source.roughness_factor == 1.0 && is_surface_whole;
  if (std::make_pair(made.width, made.height) != largest)
    made.notes.push_back(fmt::format(
        "{} x {} was enlarged to {} x {}, because KHR_texture_basisu requires sides that are multiples of {}",
        largest.first, largest.second, made.width, made.height, settings.side_multiple));
}

}  // namespace

PreparedSource prepare_source(const GltfAsset& asset, const LobeSource& source, const SourceFitSettings& settings) {
  PreparedSource made;
  made.source = source;
  try {
    prepare(asset, settings, made);
  } catch (const Error& error) {
    made.kept = why_kept(asset, error);
    made.is_bad = true;
  }
  return made;
}

void add_colours(const GltfAsset& asset, std::size_t image, const SourceFitSettings& settings, PreparedSource& made) {
  if (!made.kept.empty()) return;
  try {
    const std::string file = extracted(asset, image, settings.folder);
    const RawImageInfo colours = ImageReader(file, reading_of(settings)).info();
    const RawImageInfo normals = ImageReader(made.normal_file, reading_of(settings)).info();
    if (colours.width == normals.width && colours.height == normals.height && colours.channel_count >= 3)
      made.colour_file = file;
  } catch (const Error& error) {
    why_kept(asset, error);  // rethrows errors that the image did not cause
  }
}

std::string why_kept(const GltfAsset& asset, const Error& error) {
  if (error.code() != ErrorCode::kInput) throw error;
  const std::string message = error.what(), beginning = asset.path + ": ";
  return message.starts_with(beginning) ? message.substr(beginning.size()) : message;
}

SourcePlanes read_source(const GltfAsset& asset, const PreparedSource& prepared, const SourceFitSettings& settings,
                         Progress* progress) {
  SourcePlanes made{read_normals(asset, prepared, settings, progress), std::nullopt};
  if (prepared.source.surface_image) made.material = read_material(asset, prepared, settings);
  return made;
}

FittedSource fit_source(Device& device, const GltfAsset& asset, const PreparedSource& prepared, std::size_t number,
                        const SourceFitSettings& settings, Progress* progress) {
  const LobeSource& source = prepared.source;
  const SourcePlanes planes = read_source(asset, prepared, settings, progress);
  std::optional<PlaneStore> surface;
  if (settings.surface == MapSurface::kInterpolated)
    surface =
        surface_normals(planes.normals, {source.wrap_s, source.wrap_t}, spill_of(settings), settings.threads, progress);
  OneLobeInputs inputs;
  inputs.normals = &planes.normals;
  if (surface) inputs.surface = &*surface;
  if (planes.material) inputs.material = &*planes.material;
  inputs.has_roughness = inputs.has_metalness = source.surface_image.has_value();
  inputs.has_occlusion = source.has_occlusion;
  inputs.memory_bytes = settings.memory_bytes / 2;
  inputs.threads = settings.threads;
  OneLobeSettings lobe;
  lobe.is_anisotropic = source.is_anisotropic;
  lobe.is_fast = settings.is_fast;
  lobe.base_roughness = source.roughness_factor;
  FittedSource made;
  const auto level_file = [&](const char* what) {
    return std::make_unique<LevelFile>(settings.folder, fmt::format("{}_{}.levels", what, number), prepared.width,
                                       prepared.height);
  };
  made.normal = level_file("normal");
  made.surface = level_file("surface");
  if (source.is_anisotropic) made.anisotropy = level_file("anisotropy");
  LevelSink sink(made, source.has_occlusion);
  fit_one_lobe(device, inputs, lobe, sink, progress);
  of_image(asset, source.normal_image, prepared.normal_file,
           [&] { keep_finest_normals(prepared.normal_file, *made.normal, settings); });
  if (!source.is_anisotropic) {
    made.averages = level_file("averages");
    write_averages(*made.normal, *made.surface, *made.averages);
  }
  if (!source.surface_image && sink.is_one()) made.surface = nullptr;
  return made;
}

}  // namespace multum
