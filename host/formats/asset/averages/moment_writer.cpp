// SPDX-License-Identifier: Apache-2.0
// Writes baked files of moments (host/formats/asset/averages/moment_file.h). Builds that only read leave it out.
#include <ImfFloatAttribute.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "host/formats/asset/averages/moment_file.h"
#include "host/formats/asset/averages/moment_parts.h"
#include "host/formats/asset/averages/moment_verify.h"
#include "host/formats/asset/baked_writer.h"
#include "host/formats/asset/exr/exr_rows.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

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
    const MomentPart kind = moment_part_kinds(header_)[part];
    const std::size_t channels = moment_parts(header_)[part].channels.size();
    std::memcpy(values, moment_part_values(rows_, kind) + first * channels, count * channels * sizeof(float));
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

}  // namespace multum
