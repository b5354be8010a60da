// SPDX-License-Identifier: Apache-2.0
#include "host/asset/pyramid_file.h"

#include <ImfIntAttribute.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>
#include <half.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "host/asset/baked_reader.h"
#include "host/asset/baked_writer.h"
#include "host/asset/exr_rows.h"
#include "host/asset/half_value.h"
#include "host/asset/header_hash.h"
#include "host/base/error.h"

namespace multum {
namespace {

constexpr int kFormatVersion = 1;
const std::vector<StorageEncoding> kEncodings = {StorageEncoding::kHalf, StorageEncoding::kFloat};

struct KindInfo {
  PyramidKind kind;
  const char* name;  // "multum:representation" is "pyramid of " and this
  std::vector<const char*> channels;
  const char* interop;  // colorInteropID
  const char* text;
};

const std::array<KindInfo, 4>& kinds() {
  static const std::array<KindInfo, 4> all = {{
      {PyramidKind::kColour, "colours", {"R", "G", "B"}, "lin_rec709_scene", "R,G,B = mean linear RGB"},
      {PyramidKind::kReflectance,
       "reflectance",
       {"R", "G", "B"},
       "lin_rec709_scene",
       "R,G,B = mean radiance towards the eye, over normals (docs/FORMAT.md, \"Pyramids\")"},
      {PyramidKind::kHeight, "heights", {"Y"}, "data", "Y = mean height; data, not colour"},
      {PyramidKind::kPosition, "positions", {"X", "Y", "Z"}, "data", "X,Y,Z = mean position; data, not colour"},
  }};
  return all;
}

const KindInfo& info_of(PyramidKind kind) {
  const auto found = std::find_if(kinds().begin(), kinds().end(), [&](const KindInfo& k) { return k.kind == kind; });
  MULTUM_CHECK(found != kinds().end());
  return *found;
}

constexpr char kPrefix[] = "pyramid of ";

std::vector<BakedPart> pyramid_parts(const PyramidHeader& header) {
  const KindInfo& info = info_of(header.kind);
  BakedPart part{info.name, {}, 0, header.level_count(), false, info.text};
  for (const char* channel : info.channels) part.channels.push_back({channel, vector_type(header.map.encoding)});
  return {part};
}

std::vector<Imf::Header> pyramid_headers(const PyramidHeader& header, const BakedWriteOptions& options) {
  std::vector<Imf::Header> headers = make_baked_headers(header.map, pyramid_parts(header), options);
  const KindInfo& info = info_of(header.kind);
  headers[0].insert("multum:representation", Imf::StringAttribute(std::string(kPrefix) + info.name));
  headers[0].insert("multum:formatVersion", Imf::IntAttribute(kFormatVersion));
  headers[0].insert("colorInteropID", Imf::StringAttribute(info.interop));
  headers[0].insert("textureformat", Imf::StringAttribute("Plain Texture"));  // as maketx says it
  return headers;
}

class PyramidPortion : public BakedRows {
 public:
  PyramidPortion(int channels, int level, PyramidLevel rows)
      : channels_(static_cast<std::size_t>(channels)), level_(level), rows_(std::move(rows)) {}

  int level() const override { return level_; }
  int height() const override { return rows_.height; }
  std::size_t bytes() const override { return rows_.values.size() * sizeof(float); }
  void check_sizes(int level_width) const override {
    MULTUM_CHECK(rows_.width == level_width);
    MULTUM_CHECK(rows_.values.size() == texel_count(level_width, rows_.height) * channels_);
  }
  void copy_values(std::size_t, std::size_t first, std::size_t count, float* values) const override {
    std::memcpy(values, rows_.values.data() + first * channels_, count * channels_ * sizeof(float));
  }

 private:
  const std::size_t channels_;
  const int level_;
  const PyramidLevel rows_;
};

BakedWriteOptions without_error(BakedWriteOptions options) {
  options.measured_error_bytes = 0;
  return options;
}

// A file, opened and its structure checked.
class PyramidReader {
 public:
  PyramidReader(const std::string& path, int threads) : reader_(path, threads) {
    reader_.guarded([&] {
      const Imf::Header& first = reader_.file().header(0);
      const std::string name = text_attribute(first, "multum:representation", path);
      for (const KindInfo& info : kinds())
        if (name == std::string(kPrefix) + info.name) header_.kind = info.kind;
      if (name != std::string(kPrefix) + info_of(header_.kind).name)
        refuse_file(path, "representation '" + name + "'",
                    "a pyramid of colours, reflectance, heights or positions, as `multum mip`, `reflectance` and "
                    "`lod` write them");
      if (const int version = int_attribute(first, "multum:formatVersion", path); version != kFormatVersion)
        refuse_file(path, fmt::format("format version {}", version), fmt::format("version {}", kFormatVersion));
      header_.map = parse_map_header(first, kEncodings, path);
      if (header_.map.first_level != 0) refuse_file(path, "no level 0", "all levels");
      reader_.expect(header_.map, pyramid_parts(header_));
    });
  }

  const PyramidHeader& header() const { return header_; }
  PyramidLevel read(int level) {
    PyramidLevel read{mip_level_size(header_.map.width, level), mip_level_size(header_.map.height, level), {}};
    read.values.resize(texel_count(read.width, read.height) * static_cast<std::size_t>(header_.channel_count()));
    reader_.read_values(0, level, 0, read.height, read.values.data());
    return read;
  }

 private:
  BakedReader reader_;
  PyramidHeader header_;
};

std::size_t count_nonfinite(const PyramidLevel& level) {
  return static_cast<std::size_t>(
      std::count_if(level.values.begin(), level.values.end(), [](float v) { return !std::isfinite(v); }));
}

// How far a level's mean is from the finest level's, in parts of the largest value's size.
double mean_difference(const PyramidLevel& level, const std::vector<double>& expected, double largest) {
  const std::size_t channels = expected.size();
  std::vector<double> sums(channels);
  for (std::size_t i = 0; i < level.values.size(); ++i) sums[i % channels] += static_cast<double>(level.values[i]);
  double worst = 0.0;
  for (std::size_t c = 0; c < channels; ++c)
    worst = std::max(
        worst,
        std::abs(sums[c] * static_cast<double>(channels) / static_cast<double>(level.values.size()) - expected[c]));
  return largest > 0.0 ? worst / largest : worst;
}

}  // namespace

const char* pyramid_kind_name(PyramidKind kind) { return info_of(kind).name; }

std::uint64_t quantize_pyramid(std::vector<float>& values, StorageEncoding encoding) {
  if (encoding != StorageEncoding::kHalf) return 0;
  std::uint64_t limited = 0;
  for (float& value : values) {
    limited += std::abs(value) > kHalfMax ? 1 : 0;
    value = half(std::clamp(value, -kHalfMax, kHalfMax));
  }
  return limited;
}

class PyramidWriter::Work {
 public:
  Work(const std::string& path, const PyramidHeader& header, const BakedWriteOptions& options)
      : channels(header.channel_count()),
        writer(path, header.map, pyramid_parts(header), pyramid_headers(header, options), options) {}
  const int channels;
  BakedWriter writer;
};

PyramidWriter::PyramidWriter(const std::string& path, const PyramidHeader& header, const BakedWriteOptions& options)
    : work_(std::make_unique<Work>(path, header, without_error(options))) {}
PyramidWriter::~PyramidWriter() = default;

void PyramidWriter::write_level(int level, int first_row, PyramidLevel rows) {
  work_->writer.write(first_row, std::make_unique<PyramidPortion>(work_->channels, level, std::move(rows)));
}

void PyramidWriter::commit(Progress* progress) { work_->writer.commit("", progress); }
const std::string& PyramidWriter::content_hash() const { return work_->writer.content_hash(); }

bool is_pyramid_file(const std::string& path) {
  const BakedReader reader(path, 1);
  const auto* name = reader.file().header(0).findTypedAttribute<Imf::StringAttribute>("multum:representation");
  return name != nullptr && name->value().starts_with(kPrefix);
}

Pyramid read_pyramid(const std::string& path) {
  PyramidReader reader(path, 0);
  Pyramid pyramid{reader.header(), {}};
  for (int l = 0; l < pyramid.header.level_count(); ++l) {
    pyramid.levels.push_back(reader.read(l));
    if (count_nonfinite(pyramid.levels.back()) > 0)
      refuse_file(path, fmt::format("values in level {} that are not finite", l), "numbers");
  }
  return pyramid;
}

Pyramid read_pyramid(const std::string& path, PyramidKind expected) {
  if (const PyramidKind found = read_pyramid_header(path).kind; found != expected)
    refuse_file(path, fmt::format("a pyramid of {}", pyramid_kind_name(found)),
                fmt::format("one of {}", pyramid_kind_name(expected)));
  return read_pyramid(path);
}

PyramidHeader read_pyramid_header(const std::string& path) { return PyramidReader(path, 1).header(); }

std::vector<VerifyFinding> verify_pyramid(const std::string& path, int threads) {
  PyramidReader reader(path, threads);
  const PyramidHeader& header = reader.header();
  const auto channels = static_cast<std::size_t>(header.channel_count());
  BakedRowHash hash(pyramid_parts(header));
  std::size_t nonfinite = 0;
  std::vector<double> means(channels);
  double largest = 0.0, worst = 0.0;
  int worst_level = 0;
  for (int l = 0; l < header.level_count(); ++l) {
    const PyramidLevel level = reader.read(l);
    hash.add(0, l, level.values.data(), level.values.size());
    nonfinite += count_nonfinite(level);
    if (l == 0) {
      for (std::size_t i = 0; i < level.values.size(); ++i) {
        means[i % channels] += static_cast<double>(level.values[i]);
        largest = std::max(largest, std::abs(static_cast<double>(level.values[i])));
      }
      for (double& mean : means) mean *= static_cast<double>(channels) / static_cast<double>(level.values.size());
    } else if (const double off = mean_difference(level, means, largest); off > worst) {
      worst = off;
      worst_level = l;
    }
  }
  const std::string found = hash.finish(), &expected = header.map.provenance.content_hash;
  // Rounding to half takes up to 2^-11 of a value from each, in parts of the largest.
  const double tolerance = header.map.encoding == StorageEncoding::kHalf ? 0x1p-11 : 1e-6;
  return {
      {"structure", true,
       fmt::format("{} x {}, {} levels, pyramid of {}, encoding {}", header.map.width, header.map.height,
                   header.level_count(), pyramid_kind_name(header.kind), storage_encoding_name(header.map.encoding))},
      {"checksum", found == expected,
       found == expected ? found : "found " + found + ", expected " + expected + " as the header says"},
      header_finding(path),
      {"finite", nonfinite == 0, fmt::format("{} values that are not finite, expected 0", nonfinite)},
      {"means", worst <= tolerance,
       fmt::format("every level has the mean of level 0 within {:.1e} of the largest value, expected {:.1e}{}", worst,
                   tolerance, worst <= tolerance ? "" : fmt::format(" (level {})", worst_level))},
  };
}

}  // namespace multum
