// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/pyramid/pyramid_file.h"

#include <ImfIntAttribute.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>
#include <half.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "host/formats/asset/baked_reader.h"
#include "host/formats/asset/baked_writer.h"
#include "host/formats/asset/exr/exr_rows.h"
#include "host/formats/asset/half_value.h"
#include "host/formats/asset/header_hash.h"
#include "host/formats/asset/verify_scan.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr int kFormatVersion = 1;
const std::vector<StorageEncoding> kEncodings = {StorageEncoding::kHalf, StorageEncoding::kFloat};

struct KindInfo {
  PyramidKind kind;
  const char* name;  // suffix of "multum:representation", after "pyramid of "
  std::vector<const char*> channels;
  const char* interop;  // value of colorInteropID
  const char* text;
};

const std::array<KindInfo, 4>& kinds() {
  static const std::array<KindInfo, 4> all = {{
      {PyramidKind::kColour, "colours", {"R", "G", "B"}, "lin_rec709_scene", "R,G,B = mean linear RGB"},
      {PyramidKind::kReflectance,
       "reflectance",
       {"R", "G", "B"},
       "lin_rec709_scene",
       "R,G,B = mean radiance towards the eye, over normals (docs/reference/file_format.md, \"Pyramids\")"},
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
  headers[0].insert("textureformat", Imf::StringAttribute("Plain Texture"));  // the same text that maketx writes
  return headers;
}

std::size_t count_nonfinite(const PyramidLevel& level) {
  return static_cast<std::size_t>(
      std::count_if(level.values.begin(), level.values.end(), [](float v) { return !std::isfinite(v); }));
}

// Sums each channel of each level, for verify_pyramid().
class PyramidScan {
 public:
  explicit PyramidScan(const PyramidHeader& header)
      : channels_(static_cast<std::size_t>(header.channel_count())),
        encoding_(header.map.encoding),
        levels_(static_cast<std::size_t>(header.level_count())) {
    for (Level& level : levels_) level.sums.resize(channels_);
  }

  void add(int level_number, const PyramidLevel& rows) {
    Level& level = levels_[static_cast<std::size_t>(level_number)];
    nonfinite_ += count_nonfinite(rows);
    level.count += rows.values.size() / channels_;
    for (std::size_t i = 0; i < rows.values.size(); ++i) {
      const auto value = static_cast<double>(rows.values[i]);
      level.sums[i % channels_] += value;
      if (level_number == 0) largest_ = std::max(largest_, std::abs(value));
    }
  }

  std::vector<VerifyFinding> findings() const {
    double worst = 0.0;
    std::size_t worst_level = 0;
    for (std::size_t l = 1; l < levels_.size(); ++l)
      if (const double off = mean_difference(levels_[l]); off > worst) {
        worst = off;
        worst_level = l;
      }
    // Rounding to half changes each value by up to 2^-11. The tolerance is relative to the largest value.
    const double tolerance = encoding_ == StorageEncoding::kHalf ? 0x1p-11 : 1e-6;
    return {
        {"finite", nonfinite_ == 0, fmt::format("{} non-finite values, expected 0", nonfinite_)},
        {"means", worst <= tolerance,
         fmt::format("the means of the levels differ from the mean of level 0 by {:.1e} of the largest value, expected "
                     "at most {:.1e}{}",
                     worst, tolerance, worst <= tolerance ? "" : fmt::format(" (level {})", worst_level))},
    };
  }

 private:
  struct Level {
    std::size_t count = 0;
    std::vector<double> sums;
  };
  // Returns the difference between the means of a level and of the finest level, relative to the largest magnitude.
  double mean_difference(const Level& level) const {
    double worst = 0.0;
    for (std::size_t c = 0; c < channels_; ++c)
      worst = std::max(worst, std::abs(level.sums[c] / static_cast<double>(level.count) -
                                       levels_[0].sums[c] / static_cast<double>(levels_[0].count)));
    return largest_ > 0.0 ? worst / largest_ : worst;
  }

  const std::size_t channels_;
  const StorageEncoding encoding_;
  std::vector<Level> levels_;
  std::size_t nonfinite_ = 0;
  double largest_ = 0.0;  // largest magnitude in level 0
};

class PyramidPortion : public BakedRows {
 public:
  /// Only this thread uses `scan` until the writer's thread ends.
  PyramidPortion(int channels, PyramidScan& scan, int level, PyramidLevel rows)
      : channels_(static_cast<std::size_t>(channels)), scan_(scan), level_(level), rows_(std::move(rows)) {}

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
  void scan(int) const override { scan_.add(level_, rows_); }

 private:
  const std::size_t channels_;
  PyramidScan& scan_;
  const int level_;
  const PyramidLevel rows_;
};

BakedWriteOptions without_error(BakedWriteOptions options) {
  options.measured_error_bytes = 0;
  return options;
}

// An open file whose structure has been checked.
class PyramidReader {
 public:
  PyramidReader(const std::string& path, int threads, TexelCheck check = TexelCheck::kRefuse)
      : reader_(path, threads, check) {
    reader_.guarded([&] {
      const Imf::Header& first = reader_.file().header(0);
      const std::string name = text_attribute(first, "multum:representation", path);
      for (const KindInfo& info : kinds())
        if (name == std::string(kPrefix) + info.name) header_.kind = info.kind;
      if (name != std::string(kPrefix) + info_of(header_.kind).name)
        refuse_file(
            path, "representation '" + name + "'",
            "a pyramid of colours, reflectance, heights or positions, written by `multum mip`, `reflectance` or `lod`");
      if (const int version = int_attribute(first, "multum:formatVersion", path); version != kFormatVersion)
        refuse_file(path, fmt::format("format version {}", version), fmt::format("version {}", kFormatVersion));
      header_.map = parse_map_header(first, kEncodings, path);
      if (header_.map.first_level != 0) refuse_file(path, "no level 0", "all levels");
      reader_.expect(header_.map, pyramid_parts(header_));
    });
  }

  const PyramidHeader& header() const { return header_; }
  const std::vector<std::string>& changed_rows() const { return reader_.changed_rows(); }
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
        scan(header),
        writer(path, header.map, pyramid_parts(header), pyramid_headers(header, options), options) {}
  const int channels;
  PyramidScan scan;  // outlives the portions
  BakedWriter writer;
};

PyramidWriter::PyramidWriter(const std::string& path, const PyramidHeader& header, const BakedWriteOptions& options)
    : work_(std::make_unique<Work>(path, header, without_error(options))) {}
PyramidWriter::~PyramidWriter() = default;

void PyramidWriter::write_level(int level, int first_row, PyramidLevel rows) {
  work_->writer.write(first_row,
                      std::make_unique<PyramidPortion>(work_->channels, work_->scan, level, std::move(rows)));
}

void PyramidWriter::commit(Progress* progress) {
  work_->writer.commit(
      "", [this] { return work_->scan.findings(); }, progress);
}
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
      refuse_file(path, fmt::format("non-finite values in level {}", l), "numbers");
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
  PyramidReader reader(path, threads, TexelCheck::kReport);
  const PyramidHeader& header = reader.header();
  BakedRowHash hash(pyramid_parts(header));
  PyramidScan scan(header);
  for (int l = 0; l < header.level_count(); ++l) {
    const PyramidLevel level = reader.read(l);
    hash.add(0, l, level.values.data(), level.values.size());
    scan.add(l, level);
  }
  std::vector<VerifyFinding> findings = {
      {"structure", true,
       fmt::format("{} x {}, {} levels, pyramid of {}, encoding {}", header.map.width, header.map.height,
                   header.level_count(), pyramid_kind_name(header.kind), storage_encoding_name(header.map.encoding))},
      checksum_finding(hash.finish(), header.map.provenance.content_hash, reader.changed_rows()),
      header_finding(path),
  };
  for (VerifyFinding& finding : scan.findings()) findings.push_back(std::move(finding));
  return findings;
}

}  // namespace multum
