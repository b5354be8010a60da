// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/pyramid/mip_bake.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/formats/opencl/device_counts.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/size_of.h"
#include "host/foundation/base/stopwatch.h"
#include "host/foundation/base/version.h"

namespace multum {
namespace {

ColourEncoding reading_of(const MipJob& job) {
  return job.kind == PyramidKind::kColour ? job.colours : ColourEncoding::kData;
}

PyramidHeader make_header(const MipJob& job) {
  PyramidHeader header;
  header.kind = job.kind;
  header.map.encoding = job.encoding;
  header.map.wrap_s = job.wrap_s;
  header.map.wrap_t = job.wrap_t;
  BakedProvenance& from = header.map.provenance;
  from.software = software_version();
  from.source_name = std::filesystem::path(job.input).filename().string();
  from.source_hash = hash_file(job.input);
  from.settings = nlohmann::json{{"pyramid", pyramid_kind_name(job.kind)},
                                 {"colours", choice_name(kColourEncodings, reading_of(job))},
                                 {"encoding", storage_encoding_name(job.encoding)},
                                 {"scale", job.scale},
                                 {"wrap_s", wrap_mode_name(job.wrap_s)},
                                 {"wrap_t", wrap_mode_name(job.wrap_t)}}
                      .dump();
  from.settings_hash = hash_text(from.settings);
  return header;
}

void check_job(const MipJob& job) {
  validate(job.writing);
  check_paths_differ({job.input}, {job.output, job.report});
  if (!job.output.ends_with(".exr"))
    throw Error(ErrorCode::kUsage,
                job.output + ": is not a valid name for a pyramid, expected a name that ends in .exr");
  check_writable(job.output);
  if (!job.report.empty()) check_writable(job.report);
}

SpillPolicy spill_policy(const MipJob& job) {
  const std::string folder = std::filesystem::path(job.output).parent_path().string();
  return {!job.scratch_folder.empty() ? job.scratch_folder
          : folder.empty()            ? "."
                                      : folder,
          static_cast<std::int64_t>(job.memory_bytes / 2)};
}

// Holds the planes of a band in the layout of kernels/mip_box.cl.
class BandPlanes {
 public:
  BandPlanes(Device& device, const BoxMap& map, BoxPyramid& pyramid)
      : device_(device),
        pyramid_(pyramid),
        planes_(device.make_buffer(
            size_of(map.plane_count) * size_of(pyramid.band_rows()) * size_of(map.width) * sizeof(float), "planes")),
        texels_(device.kernel("mip_box", "mip_texels", {1, 1, false})) {}

  /// `read(plane, values)` fills the rows of the band in a plane.
  template <typename Read>
  void fill(const MultumBoxBand& band, const Read& read) {
    const std::size_t plane_size = size_of(band.row_count) * size_of(band.map_width);
    const std::size_t bytes = size_of(band.plane_count) * plane_size * sizeof(float);
    device_.write_ranges({{&planes_, 0, bytes}}, [&](const Device::Bytes& at) {
      for (int plane = 0; plane < band.plane_count; ++plane)
        read(plane, reinterpret_cast<float*>(at[0]) + size_of(plane) * plane_size);
    });
    texels_.launch({size_of(band.plane_count) * plane_size, kBoxLocalSize}, planes_, pyramid_.nodes(), band);
  }

 private:
  Device& device_;
  BoxPyramid& pyramid_;
  DeviceBuffer planes_;
  Kernel texels_;
};

// Reserves memory for the planes of a row, and for rows that wait to be written.
BoxPyramid::Memory memory_of(const BoxMap& map, std::uint64_t bytes) {
  return {bytes, 4 * size_of(map.plane_count) * size_of(map.width)};
}

}  // namespace

PyramidLevel interleaved(const BoxRows& rows, int channels) {
  PyramidLevel level{rows.width, rows.height, {}};
  level.values.resize(size_of(rows.width) * size_of(rows.height) * size_of(channels));
  for (int c = 0; c < channels; ++c)
    for (int y = 0; y < rows.height; ++y) {
      const float* const in = rows.row(c, y);
      float* const out = level.values.data() + size_of(y) * size_of(rows.width) * size_of(channels) + c;
      for (std::size_t x = 0; x < size_of(rows.width); ++x) out[x * size_of(channels)] = in[x];
    }
  return level;
}

void run_box_bands(BoxPyramid& pyramid, const BoxMap& map, const std::function<void(const MultumBoxBand&)>& fill_band,
                   const std::function<void(const BoxRows&)>& take, Progress* progress) {
  for (int row = 0; row < map.height; row += pyramid.band_rows()) {
    const MultumBoxBand band = pyramid.band(row, std::min(pyramid.band_rows(), map.height - row));
    fill_band(band);
    pyramid.average(band);
    pyramid.hand_over(band, take);
    progress_advance(progress, static_cast<std::uint64_t>(band.row_count) * static_cast<std::uint64_t>(map.width));
  }
}

std::string MipReport::to_json() const {
  if (unchanged) return nlohmann::json{{"unchanged", true}}.dump(2) + "\n";
  const nlohmann::json json = {
      {"unchanged", false},
      {"width", width},
      {"height", height},
      {"levels", level_count},
      {"format", format},
      {"device", device},
      {"content_hash", content_hash},
      {"launches", launches},
      {"counts", {{"clamped", clamped_count}, {"limited", limited_count}}},
      {"seconds", {{"read", read_seconds}, {"average", average_seconds}, {"write", write_seconds}}}};
  return json_text(json, 2) + "\n";
}

bool is_pyramid_in_place(const std::string& path, const BakedProvenance& provenance) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return false;
  try {
    const BakedProvenance found = read_pyramid_header(path).map.provenance;
    return found.software == provenance.software && found.source_hash == provenance.source_hash &&
           found.settings_hash == provenance.settings_hash;
  } catch (const Error&) {  // the file is not such a pyramid and is written again
    return false;
  }
}

std::uint64_t write_box_pyramid(BoxPyramid& pyramid, const BoxMap& map, PyramidWriter& writer, StorageEncoding encoding,
                                const std::function<void(const MultumBoxBand&)>& fill_band, Progress* progress) {
  std::uint64_t limited = 0;
  const auto take = [&](const BoxRows& rows) {
    PyramidLevel level = interleaved(rows, map.plane_count);
    limited += quantize_pyramid(level.values, encoding);
    writer.write_level(rows.level, rows.first_row, std::move(level));
  };
  run_box_bands(pyramid, map, fill_band, take, progress);
  return limited;
}

Pyramid box_pyramid(Device& device, const BoxMap& map, const float* planes, std::uint64_t memory_bytes) {
  BoxPyramid boxes(device, map, memory_of(map, memory_bytes));
  BandPlanes band_planes(device, map, boxes);
  Pyramid pyramid;
  pyramid.header.kind = map.plane_count == 1 ? PyramidKind::kHeight : PyramidKind::kColour;
  pyramid.header.map.encoding = StorageEncoding::kFloat;
  pyramid.header.map.width = map.width;
  pyramid.header.map.height = map.height;
  for (int l = 0; l < pyramid.header.level_count(); ++l)
    pyramid.levels.push_back({mip_level_size(map.width, l), mip_level_size(map.height, l), {}});
  const auto fill = [&](const MultumBoxBand& band) {
    band_planes.fill(band, [&](int plane, float* values) {
      const std::size_t first = (size_of(plane) * size_of(map.height) + size_of(band.first_row)) * size_of(map.width);
      std::copy_n(planes + first, size_of(band.row_count) * size_of(map.width), values);
    });
  };
  const auto take = [&](const BoxRows& rows) {
    const PyramidLevel level = interleaved(rows, map.plane_count);
    std::vector<float>& to = pyramid.levels[size_of(rows.level)].values;
    to.insert(to.end(), level.values.begin(), level.values.end());
  };
  run_box_bands(boxes, map, fill, take, nullptr);
  return pyramid;
}

MipReport bake_mip(const MipJob& job, Device& device, Progress* progress) {
  check_job(job);
  MipReport report;
  PyramidHeader header = make_header(job);
  if (!job.force && is_pyramid_in_place(job.output, header.map.provenance)) {
    report.unchanged = true;
    if (!job.report.empty()) write_text_file(job.report, report.to_json());
    return report;
  }
  Stopwatch seconds;
  progress_stage(progress, "read");
  const ColourRows source = read_colour_rows(job.input, reading_of(job), spill_policy(job), job.threads, progress);
  if (job.kind == PyramidKind::kPosition && source.channel_count != 3)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: found {} colour channel, expected 3 channels that hold the positions x, y and z",
                            job.input, source.channel_count));
  report.read_seconds = seconds.lap();
  report.format = source.format;
  report.clamped_count = source.clamped_count;
  log_info(job.input + ": " + source.format);
  for (const std::string& note : source.notes) log_warning(job.input, note);
  const BoxMap map = {source.planes.width(), source.planes.height(), header.channel_count(), 0};
  validate_box_map(0, map.width, map.height);
  report.width = header.map.width = map.width;
  report.height = header.map.height = map.height;
  report.level_count = header.level_count();
  const DeviceCounts counts(device);
  report.device = device.info().name;
  progress_start(progress, static_cast<std::uint64_t>(map.width) * static_cast<std::uint64_t>(map.height));
  progress_stage(progress, "average");
  BoxPyramid pyramid(device, map, memory_of(map, job.memory_bytes / 2));
  BandPlanes planes(device, map, pyramid);
  PyramidWriter writer(job.output, header, job.writing);
  const auto fill = [&](const MultumBoxBand& band) {
    planes.fill(band, [&](int plane, float* values) {
      source.planes.read_rows(plane, band.first_row, band.row_count, values);
      if (job.scale != 1.0f)
        std::for_each_n(values, size_of(band.row_count) * size_of(map.width), [&](float& v) { v *= job.scale; });
    });
  };
  report.limited_count = write_box_pyramid(pyramid, map, writer, job.encoding, fill, progress);
  report.average_seconds = seconds.lap();
  progress_stage(progress, "write");
  writer.commit(progress);
  report.write_seconds = seconds.lap();
  report.content_hash = writer.content_hash();
  report.launches = counts.launches();
  if (!job.report.empty()) write_text_file(job.report, report.to_json());
  progress_finish(progress);
  return report;
}

}  // namespace multum
