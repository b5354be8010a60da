// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/averages/moment_file.h"

#include <ImfFloatAttribute.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "host/formats/asset/averages/moment_verify.h"
#include "host/formats/asset/baked_reader.h"
#include "host/formats/asset/baked_writer.h"
#include "host/formats/asset/exr/exr_rows.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

enum MomentPart { kSlopes, kNormal, kColour, kWeights };

// maketx sorts its channels by these names.
constexpr const char* kSlopeNames[] = {"b0_h", "b1_dhds", "b2_dhdt", "b3_dhds2", "b4_dhdt2", "b5_dh2dsdt"};
constexpr const char* kNormalNames[] = {"normal.mean.X", "normal.mean.Y", "normal.mean.Z"};
constexpr char kSlopesText[] =
    "as maketx --bumpslopes: b1,b2 = E[dh/ds],E[dh/dt] = E[-x/z],E[-y/z] of normals +X right, +Y up, +Z out; b3,b4,b5 "
    "= "
    "E[b1*b1],E[b2*b2],E[b1*b2] of the finest; b0 = -1, no height; data, not colour";
constexpr char kNormalText[] = "X,Y,Z = mean unit normal, +X right, +Y up, +Z out; data, not colour";

// Returns the kind of each part, in the file's order.
std::vector<MomentPart> kinds_of(const BakedHeader& header) {
  std::vector<MomentPart> kinds = {kSlopes, kNormal};
  if (header.has_colours) kinds.push_back(kColour);
  if (header.weight_count > 0) kinds.push_back(kWeights);
  return kinds;
}

std::vector<BakedPart> moment_parts(const BakedHeader& header) {
  const int level_count = header.level_count() - header.first_level;
  const auto part = [&](const char* name, const auto& channel_names, Imf::PixelType type, const char* text) {
    BakedPart made{name, {}, header.first_level, level_count, false, text};
    for (const char* channel : channel_names) made.channels.push_back({channel, type});
    return made;
  };
  std::vector<BakedPart> parts;
  for (const MomentPart kind : kinds_of(header)) switch (kind) {
      case kSlopes: parts.push_back(part("bumpslopes", kSlopeNames, vector_type(header.encoding), kSlopesText)); break;
      case kNormal: parts.push_back(part("normal", kNormalNames, vector_type(header.encoding), kNormalText)); break;
      case kColour: parts.push_back(mean_colour_part(header)); break;
      case kWeights: parts.push_back(mean_weights_part(header)); break;
    }
  return parts;
}

const float* values_of(const MomentLevel& rows, MomentPart kind) {
  switch (kind) {
    case kSlopes: return &rows.slopes[0].height;
    case kNormal: return &rows.normals[0].x;
    case kColour: return &rows.colours[0].x;
    case kWeights: break;
  }
  return rows.weights.data();
}

class MomentPortion : public BakedRows {
 public:
  /// Only this thread uses `scan` until the writer's thread ends.
  MomentPortion(const BakedHeader& header, MomentScan& scan, int level, MomentLevel rows)
      : header_(header), scan_(scan), level_(level), rows_(std::move(rows)) {}

  int level() const override { return level_; }
  int height() const override { return rows_.height; }
  std::size_t bytes() const override {
    return rows_.slopes.size() * sizeof(SlopeMoments) +
           (rows_.normals.size() + rows_.colours.size()) * sizeof(glm::vec3) + rows_.weights.size() * sizeof(float);
  }
  void check_sizes(int level_width) const override {
    const std::size_t texels = texel_count(level_width, rows_.height);
    MULTUM_CHECK(rows_.width == level_width && rows_.slopes.size() == texels && rows_.normals.size() == texels);
    MULTUM_CHECK(rows_.colours.size() == (header_.has_colours ? texels : 0));
    MULTUM_CHECK(rows_.weights.size() == texels * static_cast<std::size_t>(header_.weight_count));
  }
  void copy_values(std::size_t part, std::size_t first, std::size_t count, float* values) const override {
    const MomentPart kind = kinds_of(header_)[part];
    const std::size_t channels = kind == kSlopes    ? std::size(kSlopeNames)
                                 : kind == kWeights ? static_cast<std::size_t>(header_.weight_count)
                                                    : std::size(kNormalNames);
    std::memcpy(values, values_of(rows_, kind) + first * channels, count * channels * sizeof(float));
  }
  void scan(int first_row) const override { scan_.add(level_, first_row, rows_); }

 private:
  const BakedHeader& header_;
  MomentScan& scan_;
  const int level_;
  const MomentLevel rows_;
};

std::vector<Imf::Header> make_moment_headers(const BakedHeader& header, const BakedWriteOptions& options) {
  std::vector<Imf::Header> headers = make_baked_headers(header, moment_parts(header), options);
  for (Imf::Header& one : headers) {
    one.insert("multum:slopeMax", Imf::FloatAttribute(kSlopeMax));
    one.insert("multum:slopeDeviationMin", Imf::FloatAttribute(least_slope_deviation(header.encoding)));
  }
  return headers;
}

}  // namespace

class MomentWriter::Work {
 public:
  Work(const std::string& path, const BakedHeader& header_of_file, const BakedWriteOptions& options)
      : header(header_of_file),
        writer(path, header, moment_parts(header), make_moment_headers(header, options), options) {
    MULTUM_CHECK(header.representation == Representation::kMoments);
  }

  const BakedHeader header;  // must outlive the portions, like the scan
  MomentScan scan{header};
  BakedWriter writer;
};

MomentWriter::MomentWriter(const std::string& path, const BakedHeader& header, const BakedWriteOptions& options)
    : work_(std::make_unique<Work>(path, header, options)) {}
MomentWriter::~MomentWriter() = default;

void MomentWriter::write_level(int level, int first_row, MomentLevel rows) {
  work_->writer.write(first_row, std::make_unique<MomentPortion>(work_->header, work_->scan, level, std::move(rows)));
}

void MomentWriter::commit(const std::string& measured_error, Progress* progress) {
  work_->writer.commit(
      measured_error, [this] { return work_->scan.findings(); }, progress);
}

const std::string& MomentWriter::content_hash() const { return work_->writer.content_hash(); }

class MomentReader::File {
 public:
  File(const std::string& path, int threads, TexelCheck check) : reader_(path, threads, check) {
    reader_.guarded([&] {
      header_ = parse_baked_header(reader_.file().header(0), Representation::kMoments, path);
      reader_.expect(header_, moment_parts(header_));
    });
    hash_ = std::make_unique<BakedRowHash>(moment_parts(header_));
  }

  const BakedHeader& header() const { return header_; }
  int tile_size() const { return reader_.tile_size(); }
  BakedRowHash& hash() { return *hash_; }
  const std::vector<std::string>& changed_rows() const { return reader_.changed_rows(); }

  MomentLevel read_level(int level, int first_row, int row_count) {
    MomentLevel rows{mip_level_size(header_.width, level), row_count, {}, {}, {}};
    const std::size_t texels = texel_count(rows.width, row_count);
    rows.slopes.resize(texels);
    rows.normals.resize(texels);
    if (header_.has_colours) rows.colours.resize(texels);
    rows.weights.resize(texels * static_cast<std::size_t>(header_.weight_count));
    if (texels == 0) return rows;
    const std::vector<MomentPart> kinds = kinds_of(header_);
    const std::vector<BakedPart> parts = moment_parts(header_);
    for (std::size_t p = 0; p < parts.size(); ++p) {
      auto* const values = const_cast<float*>(values_of(rows, kinds[p]));
      reader_.read_values(p, level, first_row, row_count, values);
      hash_->add(p, level, values, texels * parts[p].channels.size());
    }
    return rows;
  }

 private:
  BakedReader reader_;
  BakedHeader header_;
  std::unique_ptr<BakedRowHash> hash_;
};

MomentReader::MomentReader(const std::string& path, int threads, TexelCheck check)
    : file_(std::make_unique<File>(path, threads, check)) {}
MomentReader::~MomentReader() = default;
const BakedHeader& MomentReader::header() const { return file_->header(); }
int MomentReader::tile_size() const { return file_->tile_size(); }
MomentLevel MomentReader::read_level(int level, int first_row, int row_count) {
  return file_->read_level(level, first_row, row_count);
}
const std::vector<std::string>& MomentReader::changed_rows() const { return file_->changed_rows(); }
std::string MomentReader::finish_hash() { return file_->hash().finish(); }

void write_moment_mipmap(const std::string& path, const MomentMipmap& mipmap, const BakedWriteOptions& options,
                         Progress* progress) {
  BakedWriteOptions exact = options;
  exact.measured_error_bytes = static_cast<int>(mipmap.header.provenance.measured_error.size());
  MomentWriter writer(path, mipmap.header, exact);
  for (int l = mipmap.header.first_level; l < mipmap.header.level_count(); ++l) {
    const MomentLevel& level = mipmap.levels[static_cast<std::size_t>(l)];
    for (int row = 0; row < level.height; row += options.tile_size) {
      progress_advance(progress, 0);  // lets the caller cancel
      writer.write_level(l, row, rows_of(level, row, std::min(options.tile_size, level.height - row)));
    }
  }
  writer.commit(mipmap.header.provenance.measured_error, progress);
}

MomentMipmap read_moment_mipmap(const std::string& path, int threads) {
  MomentReader reader(path, threads);
  const BakedHeader& header = reader.header();
  MomentMipmap mipmap{header, empty_moment_levels(header.width, header.height)};
  for (int l = header.first_level; l < header.level_count(); ++l) {
    MomentLevel& level = mipmap.levels[static_cast<std::size_t>(l)];
    level = reader.read_level(l, 0, level.height);
  }
  return mipmap;
}

BakedHeader read_moment_header(const std::string& path) { return MomentReader(path, 1).header(); }

}  // namespace multum
