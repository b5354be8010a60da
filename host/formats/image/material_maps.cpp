// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/material_maps.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>

#include "host/formats/image/image_reader.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

// Receives rows of the wanted channels as floats of 0 to 1, each as [row * width + column].
using UseRows = std::function<void(int first_row, int row_count, const std::vector<std::vector<float>>& channels)>;

struct Wanted {
  std::string path;
  const char* what;  // description for messages, such as "a roughness map"
  int width, height;
  std::size_t checked = 4;  // number of channels whose values are checked
};

void check_size(const Wanted& wanted, const RawImageInfo& info) {
  if (info.width != wanted.width || info.height != wanted.height)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: found {} of {} x {} texels, expected {} x {} as in the normal map", wanted.path,
                            wanted.what, info.width, info.height, wanted.width, wanted.height));
}

// Reads channels in parallel, with separate rows for every thread. The first `wanted.checked` channels must have values
// from 0 to 1.
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
        if (c < wanted.checked && !(value >= 0.0f && value <= 1.0f))
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

ImageReadSettings settings_of(const SpillPolicy& spill, int threads) {
  ImageReadSettings settings;
  settings.threads = threads;
  settings.band_rows = spill.band_rows;
  settings.all_channels = true;
  return settings;
}

// Finds a channel by name. Also finds R, G, B and A by position. If no name is given, returns the only channel, or the
// channel at `default_place`, or the last channel if there are fewer.
std::size_t find_channel(const ChannelFile& file, const std::vector<std::string>& names,
                         std::size_t default_place = 1) {
  if (file.channel.empty()) return std::min(default_place, names.size() - 1);
  const auto named = std::find(names.begin(), names.end(), file.channel);
  if (named != names.end()) return static_cast<std::size_t>(named - names.begin());
  const std::size_t place = std::string("RGBA").find(file.channel);
  if (file.channel.size() != 1 || place >= names.size())
    throw Error(ErrorCode::kInput, fmt::format("{}: found no channel {}, expected one of {}", file.path, file.channel,
                                               fmt::join(names, ", ")));
  return place;
}

// The sums over one row of a roughness map, and over the colours in its file.
struct RoughnessSums {
  double cosine = 0.0, roughness = 0.0, least = 1.0, most = 0.0;
  std::int64_t zeros = 0, ones = 0, mirrors = 0;
  double difference = 0.0;           // largest minus smallest value of red, green and blue
  std::array<double, 3> colour{};    // sums of values
  std::array<double, 3> squares{};   // sums of squares
  std::array<double, 2> products{};  // sums of green * red and of green * blue

  void add(double value, double value_cosine) {
    cosine += value_cosine;
    roughness += value;
    least = std::min(least, value);
    most = std::max(most, value);
    zeros += value <= 0.0;
    ones += value >= 1.0;
    mirrors += value < kMirrorRoughness;
  }
  void add_colour(const std::array<float, 3>& rgb) {
    const std::array<double, 3> c = {static_cast<double>(rgb[0]), static_cast<double>(rgb[1]),
                                     static_cast<double>(rgb[2])};
    difference += std::max({c[0], c[1], c[2]}) - std::min({c[0], c[1], c[2]});
    for (std::size_t k = 0; k < 3; ++k) colour[k] += c[k], squares[k] += c[k] * c[k];
    products[0] += c[1] * c[0];
    products[1] += c[1] * c[2];
  }
  void add(const RoughnessSums& other) {
    cosine += other.cosine;
    roughness += other.roughness;
    least = std::min(least, other.least);
    most = std::max(most, other.most);
    zeros += other.zeros;
    ones += other.ones;
    mirrors += other.mirrors;
    difference += other.difference;
    for (std::size_t k = 0; k < 3; ++k) colour[k] += other.colour[k], squares[k] += other.squares[k];
    for (std::size_t k = 0; k < 2; ++k) products[k] += other.products[k];
  }
  // Returns the lower of the correlations of green with red and of green with blue. Returns 0 if a channel is constant.
  double colour_correlation(double count) const {
    const auto variance = [&](std::size_t k) { return squares[k] / count - colour[k] * colour[k] / (count * count); };
    const auto with_green = [&](std::size_t k, double product) {
      constexpr double kVarianceMin = 1e-8;  // square of a tenth of an 8-bit step
      const double both = variance(1) * variance(k);
      return both > kVarianceMin * kVarianceMin
                 ? (product / count - colour[1] * colour[k] / (count * count)) / std::sqrt(both)
                 : 0.0;
    };
    return std::min(with_green(0, products[0]), with_green(2, products[1]));
  }
};

// Returns the words of a file name in lower case. A word ends before a character that is not a letter, or between a
// small letter and a capital.
std::vector<std::string> words_of_name(const std::string& path) {
  std::vector<std::string> words(1);
  bool was_lower = false;
  for (const char c : std::filesystem::path(path).stem().string()) {
    const bool is_upper = c >= 'A' && c <= 'Z', is_lower = c >= 'a' && c <= 'z';
    if ((!is_upper && !is_lower) || (is_upper && was_lower)) words.emplace_back();
    if (is_upper || is_lower) words.back() += static_cast<char>(is_upper ? c - 'A' + 'a' : c);
    was_lower = is_lower;
  }
  std::erase_if(words, [](const std::string& word) { return word.empty(); });
  return words;
}

// Single letters, as in "floor_s.png", count only at the end of a name. The same applies to "metal", which is also a
// material.
NamedMap map_of_word(const std::string& word, bool is_last) {
  struct Word {
    const char* text;
    NamedMap map;
  };
  static constexpr Word kWords[] = {{"rough", NamedMap::kRoughness},    {"roughness", NamedMap::kRoughness},
                                    {"gloss", NamedMap::kGloss},        {"glossiness", NamedMap::kGloss},
                                    {"smoothness", NamedMap::kGloss},   {"spec", NamedMap::kSpecular},
                                    {"specular", NamedMap::kSpecular},  {"specularity", NamedMap::kSpecular},
                                    {"metallic", NamedMap::kMetalness}, {"metalness", NamedMap::kMetalness}};
  static constexpr Word kLastWords[] = {{"r", NamedMap::kRoughness},
                                        {"metal", NamedMap::kMetalness},
                                        {"g", NamedMap::kGloss},
                                        {"s", NamedMap::kSpecular},
                                        {"m", NamedMap::kMetalness}};
  constexpr std::size_t kLong = 8;  // words of this length also match the end of longer words: "metallicroughness"
  for (const Word& one : kWords) {
    const std::string_view text = one.text;
    if (word == text || word == std::string(text) + "map" || (text.size() >= kLong && word.ends_with(text)))
      return one.map;
  }
  for (const Word& one : kLastWords)
    if (is_last && word == one.text) return one.map;
  return NamedMap::kUnknown;
}

const char* name_of(NamedMap map) {
  switch (map) {
    case NamedMap::kRoughness: return "roughness";
    case NamedMap::kGloss: return "gloss";
    case NamedMap::kSpecular: return "specular";
    case NamedMap::kMetalness: return "metalness";
    case NamedMap::kUnknown: break;
  }
  return "";
}

// Uses the name and the values together, because neither proves anything by itself.
void warn_of_doubts(const ChannelFile& file, RoughnessReport& report) {
  const NamedMap named = map_by_name(file.path), taken = file.is_gloss ? NamedMap::kGloss : NamedMap::kRoughness;
  const bool is_opposite = file.is_gloss ? named == NamedMap::kRoughness : named == NamedMap::kGloss;
  // A channel that the user names may hold another kind of map than the file name states. For example, the alpha
  // channel of a specular map may hold gloss.
  if (is_opposite || (named != NamedMap::kUnknown && named != taken && file.channel.empty())) {
    report.warnings.push_back(fmt::format(
        "{}: its name says that it is a {} map, but it was given as --{}: {}", file.path, name_of(named),
        name_of(taken),
        is_opposite ? fmt::format("--{} would invert the values", name_of(named)) : "check that it is the right map"));
    return;  // one doubt is enough
  }
  if (report.share_mirror > (named == taken ? kMirrorShareMaxNamed : kMirrorShareMax))
    report.warnings.push_back(fmt::format(
        "{}: {:.0f} % of the texels are mirrors (perceptual roughness below {:g}), but real roughness maps have almost "
        "none: is it a specular{} map?",
        file.path, 100.0 * report.share_mirror, kMirrorRoughness, file.is_gloss ? " or roughness" : " or gloss"));
  if (file.is_gloss && report.share_one > kDullShareMax)
    report.warnings.push_back(
        fmt::format("{}: {:.0f} % of the texels have no gloss (roughness 1), but real gloss maps have almost none: is "
                    "it a specular map?",
                    file.path, 100.0 * report.share_one));
}

// Returns the statements of the file about its picture that the reader ignores, each with the file's name.
std::vector<std::string> named_notes(const std::string& path, const RawImageInfo& info) {
  std::vector<std::string> notes;
  for (const std::string& note : info.notes) notes.push_back(path + ": " + note);
  return notes;
}

RoughnessReport report_of(const ChannelFile& file, const std::vector<RoughnessSums>& rows, double count) {
  RoughnessSums sums;
  for (const RoughnessSums& row : rows) sums.add(row);
  RoughnessReport report;
  report.mean_cosine = sums.cosine / count;
  report.least = sums.least;
  report.mean = sums.roughness / count;
  report.most = sums.most;
  report.share_zero = static_cast<double>(sums.zeros) / count;
  report.share_one = static_cast<double>(sums.ones) / count;
  report.share_mirror = static_cast<double>(sums.mirrors) / count;
  warn_of_doubts(file, report);
  const double correlation = sums.colour_correlation(count);
  if (sums.difference / count > kColourDifferenceMin && correlation > kColourCorrelationMin)
    report.warnings.push_back(
        fmt::format("{}: red, green and blue differ, but have a correlation of {:.2f}, as in a picture; green was used "
                    "as {}: is it a colour or specular map? Use FILE:CHANNEL to name a channel",
                    file.path, correlation, file.is_gloss ? "gloss" : "roughness"));
  return report;
}

// Reads a roughness or gloss map. `use(first_row, row_count, roughness)` receives it in bands, from several threads.
template <typename Use>
RoughnessReport read_roughness(const ChannelFile& file, int map_width, int map_height, const SpillPolicy& spill,
                               int threads, const Use& use) {
  const Wanted wanted{file.path, file.is_gloss ? "a gloss map" : "a roughness map", map_width, map_height, 1};
  ImageReader reader(file.path, settings_of(spill, threads));
  check_size(wanted, reader.info());
  const std::size_t channel = find_channel(file, reader.info().channel_names);
  std::vector<RoughnessSums> sums(static_cast<std::size_t>(map_height));  // one per row, so that the division into
                                                                          // bands does not matter
  std::vector<std::size_t> read = {channel};
  const bool looks_for_colours = file.channel.empty() && reader.info().channel_count >= 3;
  if (looks_for_colours) read.insert(read.end(), {0, 1, 2});
  read_channels(reader, wanted, read, threads, [&](int first_row, int row_count, const auto& channels) {
    std::vector<float> roughness = channels[0];
    if (file.is_gloss)
      for (float& value : roughness) value = 1.0f - value;
    const auto width = static_cast<std::size_t>(map_width);
    for (std::size_t i = 0; i < roughness.size(); ++i) {
      RoughnessSums& row = sums[static_cast<std::size_t>(first_row) + i / width];
      const auto c = static_cast<float>(mean_cosine_of_roughness(static_cast<double>(roughness[i])));
      row.add(static_cast<double>(roughness[i]), static_cast<double>(c));
      if (looks_for_colours) row.add_colour({channels[1][i], channels[2][i], channels[3][i]});
    }
    use(first_row, row_count, roughness);
  });
  RoughnessReport report = report_of(file, sums, static_cast<double>(map_width) * map_height);
  const std::vector<std::string> notes = named_notes(file.path, reader.info());
  report.warnings.insert(report.warnings.begin(), notes.begin(), notes.end());
  return report;
}

}  // namespace

double mean_cosine_of_roughness(double roughness) {
  const double alpha = roughness * roughness;
  return 1.0 - 0.5 * alpha * alpha;
}

NamedMap map_by_name(const std::string& path) {
  const std::vector<std::string> words = words_of_name(path);
  NamedMap found = NamedMap::kUnknown;
  for (std::size_t i = words.size(); i-- > 0;) {
    const NamedMap map = map_of_word(words[i], i + 1 == words.size());
    if (map == NamedMap::kUnknown) continue;
    if (map != NamedMap::kMetalness) return map;
    found = map;
  }
  return found;
}

ChannelFile parse_channel_file(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  std::error_code error;  // a file system may not accept the text as a name
  if (colon == std::string::npos || colon == 0 || std::filesystem::exists(text, error)) return {text, ""};
  return {text.substr(0, colon), text.substr(colon + 1)};
}

std::string RoughnessReport::to_text() const {
  return fmt::format("perceptual roughness {:.3g} to {:.3g}, mean {:.3g}; {:.3g} % at 0, {:.3g} % at 1", least, most,
                     mean, 100.0 * share_zero, 100.0 * share_one);
}

RoughnessReport shorten_by_roughness(PlaneStore& normals, const ChannelFile& file, const SpillPolicy& spill,
                                     int threads) {
  const auto shorten = [&](int first_row, int row_count, const std::vector<float>& roughness) {
    std::vector<float> x(roughness.size()), y(roughness.size()), z(roughness.size());
    normals.read_rows(first_row, row_count, {x.data(), y.data(), z.data()});
    for (std::size_t i = 0; i < roughness.size(); ++i) {
      const auto c = static_cast<float>(mean_cosine_of_roughness(static_cast<double>(roughness[i])));
      x[i] *= c;
      y[i] *= c;
      z[i] *= c;
    }
    normals.write_rows(first_row, row_count, {x.data(), y.data(), z.data()});
  };
  RoughnessReport report = read_roughness(file, normals.width(), normals.height(), spill, threads, shorten);
  normals.set_shortened(true);
  return report;
}

LobeMaterial read_lobe_material(const LobeMaterialFiles& files, int width, int height, const SpillPolicy& spill,
                                int threads) {
  LobeMaterial material{make_plane_store(width, height, spill)};
  // Planes are written in groups of three. Each map replaces its own plane and leaves the other two unchanged.
  const auto put = [&](std::size_t plane, int first_row, int row_count, const std::vector<float>& values) {
    std::array<std::vector<float>, 3> planes;
    for (std::vector<float>& all : planes) all = std::vector<float>(values.size());
    material.planes.read_rows(first_row, row_count, {planes[0].data(), planes[1].data(), planes[2].data()});
    planes[plane] = values;
    material.planes.write_rows(first_row, row_count, {planes[0].data(), planes[1].data(), planes[2].data()});
  };
  const std::vector<float> ones(static_cast<std::size_t>(width), 1.0f);
  for (int row = 0; row < height; ++row) material.planes.write_rows(row, 1, {ones.data(), ones.data(), ones.data()});
  if (!files.roughness.path.empty())
    material.roughness = read_roughness(files.roughness, width, height, spill, threads,
                                        [&](int first_row, int row_count, std::vector<float> values) {
                                          for (float& r : values) r = r * r * (r * r);
                                          put(0, first_row, row_count, values);
                                        });
  // glTF packs occlusion, roughness and metalness into red, green and blue.
  const auto read_plane = [&](std::size_t plane, std::size_t default_place, const ChannelFile& file, const char* what) {
    if (file.path.empty()) return;
    const Wanted wanted{file.path, what, width, height, 1};
    ImageReader reader(file.path, settings_of(spill, threads));
    check_size(wanted, reader.info());
    const std::vector<std::size_t> channel = {find_channel(file, reader.info().channel_names, default_place)};
    read_channels(reader, wanted, channel, threads, [&](int first_row, int row_count, const auto& channels) {
      put(plane, first_row, row_count, channels[0]);
    });
    const std::vector<std::string> notes = named_notes(file.path, reader.info());
    material.warnings.insert(material.warnings.end(), notes.begin(), notes.end());
  };
  read_plane(1, 0, files.occlusion, "an occlusion map");
  read_plane(2, 2, files.metalness, "a metalness map");
  return material;
}

WeightMap read_weight_map(const std::string& path, int width, int height, const SpillPolicy& spill, int threads) {
  const Wanted wanted{path, "a map of weights", width, height};
  ImageReader reader(path, settings_of(spill, threads));
  check_size(wanted, reader.info());
  WeightMap map;
  map.count = reader.info().channel_count;
  map.warnings = named_notes(path, reader.info());
  if (map.count > 4)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: found {} channels, expected the weights of 1 to 4 basis BRDFs", path, map.count));
  std::vector<std::size_t> channels;
  for (int c = 0; c < map.count; ++c) channels.push_back(static_cast<std::size_t>(c));
  for (int c = 0; c < map.count; c += 3) map.rgb_planes.push_back(make_plane_store(width, height, spill));
  read_channels(reader, wanted, channels, threads, [&](int first_row, int row_count, const auto& rows) {
    const std::vector<float> zeros(rows[0].size());
    const auto plane = [&](std::size_t c) { return c < rows.size() ? rows[c].data() : zeros.data(); };
    for (std::size_t t = 0; t < map.rgb_planes.size(); ++t)
      map.rgb_planes[t].write_rows(first_row, row_count, {plane(3 * t), plane(3 * t + 1), plane(3 * t + 2)});
  });
  return map;
}

}  // namespace multum
