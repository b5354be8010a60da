// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/averages/sh_file.h"

#include <ImfIntAttribute.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "host/formats/asset/averages/sh_verify.h"
#include "host/formats/asset/baked_reader.h"
#include "host/formats/asset/baked_writer.h"
#include "host/formats/asset/exr/exr_rows.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr char kOrderAttribute[] = "multum:shOrder";
constexpr const char* kChannelNames[] = {"R", "G", "B", "A"};

// Names the channels of the part R, G, B and A. A part with fewer than four coefficients has fewer channels. The index
// of the first coefficient is 4 times the number in the name of the part.
BakedPart coefficient_part(const BakedHeader& header, int order, int part) {
  BakedPart made{fmt::format("sh.{:02}", part),
                 {},
                 header.first_level,
                 header.level_count() - header.first_level,
                 false,
                 fmt::format("R,G,B,A = coefficients {} and on of real spherical harmonics, l*l+l+m-1, l from 1, no "
                             "Condon-Shortley phase, +X right, +Y up, +Z out; data, not colour",
                             4 * part)};
  for (int c = 0; c < std::min(4, sh_coefficient_count(order) - 4 * part); ++c)
    made.channels.push_back({fmt::format("sh{:02}.Y.{}", part, kChannelNames[c]), vector_type(header.encoding)});
  return made;
}

std::vector<BakedPart> sh_parts(const BakedHeader& header, int order) {
  std::vector<BakedPart> parts;
  for (int part = 0; part < sh_part_count(order); ++part) parts.push_back(coefficient_part(header, order, part));
  if (header.has_colours) parts.push_back(mean_colour_part(header));
  if (header.weight_count > 0) parts.push_back(mean_weights_part(header));
  return parts;
}

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
  for (Imf::Header& one : headers) one.insert(kOrderAttribute, Imf::IntAttribute(order));
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

class ShReader::File {
 public:
  File(const std::string& path, int threads, TexelCheck check) : reader_(path, threads, check) {
    reader_.guarded([&] {
      const Imf::Header& first = reader_.file().header(0);
      header_ = parse_baked_header(first, Representation::kSh, path);
      order_ = int_attribute(first, kOrderAttribute, path);
      if (order_ < kShOrderMin || order_ > kShOrderMax)
        refuse_file(path, fmt::format("an order of {}", order_), fmt::format("{} to {}", kShOrderMin, kShOrderMax));
      reader_.expect(header_, sh_parts(header_, order_));
    });
    hash_ = std::make_unique<BakedRowHash>(sh_parts(header_, order_));
  }

  const BakedHeader& header() const { return header_; }
  int order() const { return order_; }
  int tile_size() const { return reader_.tile_size(); }
  BakedRowHash& hash() { return *hash_; }
  const std::vector<std::string>& changed_rows() const { return reader_.changed_rows(); }

  ShLevel read_level(int level, int first_row, int row_count) {
    ShLevel rows{mip_level_size(header_.width, level), row_count, {}, {}, {}};
    const std::size_t texels = texel_count(rows.width, row_count);
    rows.parts.assign(static_cast<std::size_t>(sh_part_count(order_)), std::vector<glm::vec4>(texels));
    if (header_.has_colours) rows.colours.resize(texels);
    rows.weights.resize(texels * static_cast<std::size_t>(header_.weight_count));
    if (texels == 0) return rows;
    for (std::size_t part = 0; part < rows.parts.size(); ++part) {
      const int channels = std::min(4, sh_coefficient_count(order_) - 4 * static_cast<int>(part));
      std::vector<glm::vec4>& values = rows.parts[part];
      float* const first = &values[0].x;
      read_part(part, level, first_row, row_count, first, static_cast<std::size_t>(channels) * texels);
      if (channels == 4) continue;
      // Moves the values to their final places, beginning with the last texel. The final place of each texel is at or
      // after the present place of its values.
      for (std::size_t i = texels; i-- > 0;) {
        glm::vec4 texel(0.0f);
        std::copy_n(first + i * static_cast<std::size_t>(channels), channels, &texel.x);
        values[i] = texel;
      }
    }
    std::size_t part = rows.parts.size();
    if (header_.has_colours) read_part(part++, level, first_row, row_count, &rows.colours[0].x, 3 * texels);
    if (header_.weight_count > 0)
      read_part(part, level, first_row, row_count, rows.weights.data(), rows.weights.size());
    return rows;
  }

 private:
  void read_part(std::size_t part, int level, int first_row, int row_count, float* values, std::size_t value_count) {
    reader_.read_values(part, level, first_row, row_count, values);
    hash_->add(part, level, values, value_count);
  }

  BakedReader reader_;
  BakedHeader header_;
  int order_ = 0;
  std::unique_ptr<BakedRowHash> hash_;
};

ShReader::ShReader(const std::string& path, int threads, TexelCheck check)
    : file_(std::make_unique<File>(path, threads, check)) {}
ShReader::~ShReader() = default;
const BakedHeader& ShReader::header() const { return file_->header(); }
int ShReader::order() const { return file_->order(); }
int ShReader::tile_size() const { return file_->tile_size(); }
ShLevel ShReader::read_level(int level, int first_row, int row_count) {
  return file_->read_level(level, first_row, row_count);
}
const std::vector<std::string>& ShReader::changed_rows() const { return file_->changed_rows(); }
std::string ShReader::finish_hash() { return file_->hash().finish(); }

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

ShMipmap read_sh_mipmap(const std::string& path, int threads) {
  ShReader reader(path, threads);
  const BakedHeader& header = reader.header();
  ShMipmap mipmap{header, reader.order(), empty_sh_levels(header.width, header.height)};
  for (int l = header.first_level; l < header.level_count(); ++l) {
    ShLevel& level = mipmap.levels[static_cast<std::size_t>(l)];
    level = reader.read_level(l, 0, level.height);
  }
  return mipmap;
}

ShMipmap read_sh_header(const std::string& path) {
  const ShReader reader(path, 1);
  return {reader.header(), reader.order(), empty_sh_levels(reader.header().width, reader.header().height)};
}

}  // namespace multum
