// SPDX-License-Identifier: Apache-2.0
#include "host/image/material_maps.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <numeric>

#include "host/base/error.h"
#include "host/base/parallel.h"
#include "host/image/image_reader.h"

namespace multum {
namespace {

// Rows of the channels that are wanted, as floats of 0 to 1: [row * width + column] each.
using UseRows = std::function<void(int first_row, int row_count, const std::vector<std::vector<float>>& channels)>;

struct Wanted {
  std::string path;
  const char* what;  // "a roughness map", for messages
  int width, height;
};

void check_size(const Wanted& wanted, const RawImageInfo& info) {
  if (info.width != wanted.width || info.height != wanted.height)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: found {} of {} x {} texels, expected the normal map's {} x {}", wanted.path,
                            wanted.what, info.width, info.height, wanted.width, wanted.height));
}

// In parallel, rows of a thread's own each time.
void read_channels(ImageReader& reader, const Wanted& wanted, const std::vector<std::size_t>& channels, int threads,
                   const UseRows& use) {
  const RawImageInfo info = reader.info();
  const SampleConverter converter(info.base_type);
  const auto all = static_cast<std::size_t>(info.channel_count);
  const auto use_band = [&](const RawBand& band, int row_begin, int row_end) {
    const auto width = static_cast<std::size_t>(info.width);
    const std::size_t texels = width * static_cast<std::size_t>(row_end - row_begin);
    std::vector<float> values(texels * all);
    converter.convert(band.samples + static_cast<std::size_t>(row_begin) * info.row_bytes, values.size(),
                      values.data());
    std::vector<std::vector<float>> planes(channels.size(), std::vector<float>(texels));
    for (std::size_t c = 0; c < channels.size(); ++c)
      for (std::size_t i = 0; i < texels; ++i) {
        const float value = values[i * all + channels[c]];
        if (!(value >= 0.0f && value <= 1.0f))
          throw Error(ErrorCode::kInput,
                      fmt::format("{}: texel ({}, {}): found {} in channel {}, expected {} with values from 0 to 1",
                                  wanted.path, i % width, band.first_row + row_begin + static_cast<int>(i / width),
                                  value, info.channel_names[channels[c]], wanted.what));
        planes[c][i] = value;
      }
    use(band.first_row + row_begin, row_end - row_begin, planes);
  };
  reader.read(
      [&](const RawBand& band) {
        for_each_row_band(band.row_count, kRowsPerBand, threads,
                          [&](int, int begin, int end) { use_band(band, begin, end); });
      },
      nullptr);
}

ImageReadSettings settings_of(const ReadingPlace& place, int threads) {
  ImageReadSettings settings;
  settings.threads = threads;
  settings.band_rows = place.band_rows;
  settings.all_channels = true;
  return settings;
}

// By name; R, G, B and A also by place, whatever a file calls them.
std::size_t find_channel(const ChannelFile& file, const std::vector<std::string>& names) {
  if (file.channel.empty()) return names.size() == 1 ? 0 : 1;
  const auto named = std::find(names.begin(), names.end(), file.channel);
  if (named != names.end()) return static_cast<std::size_t>(named - names.begin());
  const std::size_t place = std::string("RGBA").find(file.channel);
  if (file.channel.size() != 1 || place >= names.size())
    throw Error(ErrorCode::kInput, fmt::format("{}: found no channel {}, expected one of {}", file.path, file.channel,
                                               fmt::join(names, ", ")));
  return place;
}

}  // namespace

double mean_cosine_of_roughness(double roughness) {
  const double alpha = roughness * roughness;
  return 1.0 - 0.5 * alpha * alpha;
}

ChannelFile parse_channel_file(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  std::error_code error;  // no file system takes every text as a name
  if (colon == std::string::npos || colon == 0 || std::filesystem::exists(text, error)) return {text, ""};
  return {text.substr(0, colon), text.substr(colon + 1)};
}

double shorten_by_roughness(PlaneStore& normals, const ChannelFile& file, const ReadingPlace& place, int threads) {
  const Wanted wanted{file.path, "a roughness map", normals.width(), normals.height()};
  ImageReader reader(file.path, settings_of(place, threads));
  check_size(wanted, reader.info());
  const std::size_t channel = find_channel(file, reader.info().channel_names);
  std::vector<double> sums(
      static_cast<std::size_t>(normals.height()));  // by rows: no band or thread can be seen in them
  read_channels(reader, wanted, {channel}, threads, [&](int first_row, int row_count, const auto& channels) {
    const std::vector<float>& roughness = channels[0];
    const auto width = static_cast<std::size_t>(normals.width());
    std::vector<float> x(roughness.size()), y(roughness.size()), z(roughness.size());
    normals.read_rows(first_row, row_count, {x.data(), y.data(), z.data()});
    for (std::size_t i = 0; i < roughness.size(); ++i) {
      const auto c = static_cast<float>(mean_cosine_of_roughness(static_cast<double>(roughness[i])));
      sums[static_cast<std::size_t>(first_row) + i / width] += static_cast<double>(c);
      x[i] *= c;
      y[i] *= c;
      z[i] *= c;
    }
    normals.write_rows(first_row, row_count, {x.data(), y.data(), z.data()});
  });
  return std::accumulate(sums.begin(), sums.end(), 0.0) / (static_cast<double>(normals.width()) * normals.height());
}

WeightMap read_weight_map(const std::string& path, int width, int height, const ReadingPlace& place, int threads) {
  const Wanted wanted{path, "a map of weights", width, height};
  ImageReader reader(path, settings_of(place, threads));
  check_size(wanted, reader.info());
  WeightMap map;
  map.count = reader.info().channel_count;
  if (map.count > 4)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: found {} channels, expected the weights of 1 to 4 basis BRDFs", path, map.count));
  std::vector<std::size_t> channels;
  for (int c = 0; c < map.count; ++c) channels.push_back(static_cast<std::size_t>(c));
  for (int c = 0; c < map.count; c += 3) map.triples.push_back(make_plane_store(width, height, place));
  read_channels(reader, wanted, channels, threads, [&](int first_row, int row_count, const auto& rows) {
    const std::vector<float> zeros(rows[0].size());
    const auto plane = [&](std::size_t c) { return c < rows.size() ? rows[c].data() : zeros.data(); };
    for (std::size_t t = 0; t < map.triples.size(); ++t)
      map.triples[t].write_rows(first_row, row_count, {plane(3 * t), plane(3 * t + 1), plane(3 * t + 2)});
  });
  return map;
}

}  // namespace multum
