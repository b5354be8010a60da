// SPDX-License-Identifier: Apache-2.0
// Writes baked files of spherical harmonics (host/formats/asset/averages/sh_file.h). Builds that only read leave it
// out.
#include <ImfIntAttribute.h>

#include <algorithm>
#include <utility>

#include "host/formats/asset/averages/sh_file.h"
#include "host/formats/asset/averages/sh_parts.h"
#include "host/formats/asset/averages/sh_verify.h"
#include "host/formats/asset/baked_writer.h"
#include "host/formats/asset/exr/exr_rows.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

class ShPortion : public BakedRows {
 public:
  /// Only this thread uses `scan` until the writer's thread ends.
  ShPortion(int order, const BakedHeader& header, ShScan& scan, int level, ShLevel rows)
      : order_(order), header_(header), scan_(scan), level_(level), rows_(std::move(rows)) {}

  int level() const override { return level_; }
  int height() const override { return rows_.height; }
  std::size_t bytes() const override {
    return rows_.parts.size() * rows_.parts[0].size() * sizeof(glm::vec4) + rows_.colours.size() * sizeof(glm::vec3) +
           rows_.weights.size() * sizeof(float);
  }
  void check_sizes(int level_width) const override {
    const std::size_t texels = texel_count(level_width, rows_.height);
    MULTUM_CHECK(rows_.width == level_width && static_cast<int>(rows_.parts.size()) == sh_part_count(order_));
    for (const auto& part : rows_.parts) MULTUM_CHECK(part.size() == texels);
    MULTUM_CHECK(rows_.colours.size() == (header_.has_colours ? texels : 0));
    MULTUM_CHECK(rows_.weights.size() == texels * static_cast<std::size_t>(header_.weight_count));
  }
  void copy_values(std::size_t part, std::size_t first, std::size_t count, float* values) const override {
    if (part >= rows_.parts.size()) {
      const auto weights = static_cast<std::size_t>(header_.weight_count);
      if (header_.has_colours && part == rows_.parts.size()) std::copy_n(&rows_.colours[first].x, 3 * count, values);
      else std::copy_n(&rows_.weights[first * weights], count * weights, values);
      return;
    }
    const int channels = std::min(4, sh_coefficient_count(order_) - 4 * static_cast<int>(part));
    for (std::size_t i = first; i < first + count; ++i) values = std::copy_n(&rows_.parts[part][i].x, channels, values);
  }
  void scan(int first_row) const override { scan_.add(level_, first_row, rows_); }

 private:
  const int order_;
  const BakedHeader& header_;
  ShScan& scan_;
  const int level_;
  const ShLevel rows_;
};

std::vector<Imf::Header> make_sh_headers(const BakedHeader& header, int order, const BakedWriteOptions& options) {
  std::vector<Imf::Header> headers = make_baked_headers(header, sh_parts(header, order), options);
  for (Imf::Header& one : headers) one.insert(kShOrderAttribute, Imf::IntAttribute(order));
  return headers;
}

}  // namespace

int sh_tile_size(int map_width, int order, int default_size) {
  constexpr std::uint64_t kWaitingMax = std::uint64_t{64} << 20;
  constexpr int kLeast = 16;
  // This is twice the row size of the finest level, because all coarser levels together are as wide as the finest
  // level.
  const std::uint64_t row_bytes = 2 * static_cast<std::uint64_t>(map_width) *
                                  static_cast<std::uint64_t>(sh_coefficient_count(order)) * sizeof(float);
  int size = default_size;
  while (size > kLeast && row_bytes * static_cast<std::uint64_t>(size) > kWaitingMax) size /= 2;
  return size;
}

class ShWriter::Work {
 public:
  Work(const std::string& path, const BakedHeader& file_header, int sh_order, const BakedWriteOptions& options)
      : order(sh_order),
        header(file_header),
        writer(path, header, sh_parts(header, sh_order), make_sh_headers(header, sh_order, options), options) {
    MULTUM_CHECK(header.representation == Representation::kSh);
  }

  const int order;
  const BakedHeader header;  // must outlive the portions, like the scan
  ShScan scan{header, order};
  BakedWriter writer;
};

ShWriter::ShWriter(const std::string& path, const BakedHeader& header, int order, const BakedWriteOptions& options)
    : work_(std::make_unique<Work>(path, header, order, options)) {}
ShWriter::~ShWriter() = default;

void ShWriter::write_level(int level, int first_row, ShLevel rows) {
  work_->writer.write(first_row,
                      std::make_unique<ShPortion>(work_->order, work_->header, work_->scan, level, std::move(rows)));
}

void ShWriter::commit(const std::string& measured_error, Progress* progress) {
  work_->writer.commit(
      measured_error, [this] { return work_->scan.findings(); }, progress);
}

const std::string& ShWriter::content_hash() const { return work_->writer.content_hash(); }

void write_sh_mipmap(const std::string& path, const ShMipmap& mipmap, const BakedWriteOptions& options,
                     Progress* progress) {
  BakedWriteOptions exact = options;
  exact.measured_error_bytes = static_cast<int>(mipmap.header.provenance.measured_error.size());
  ShWriter writer(path, mipmap.header, mipmap.order, exact);
  for (int l = mipmap.header.first_level; l < mipmap.header.level_count(); ++l) {
    progress_advance(progress, 0);  // lets the caller cancel
    const ShLevel& level = mipmap.levels[static_cast<std::size_t>(l)];
    writer.write_level(l, 0, level);
  }
  writer.commit(mipmap.header.provenance.measured_error, progress);
}

}  // namespace multum
