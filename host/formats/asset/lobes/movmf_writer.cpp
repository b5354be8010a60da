// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/lobes/movmf_writer.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "host/formats/asset/baked_writer.h"
#include "host/formats/asset/lobes/movmf_header.h"
#include "host/formats/asset/lobes/movmf_parts.h"
#include "host/formats/asset/lobes/movmf_verify.h"
#include "host/foundation/base/error.h"

namespace multum {

// The header and the parts, used to check and split rows.
struct MovmfWriter::Shape {
  explicit Shape(const MovmfMipmap& header)
      : lobe_count(static_cast<std::size_t>(header.lobe_count())),
        has_colours(header.has_colours()),
        weight_count(static_cast<std::size_t>(header.header.weight_count)),
        has_roughness(header.header.has_roughness),
        parts(movmf_parts(header)),
        scan(std::make_unique<MovmfScan>(header)) {
    MULTUM_CHECK(header.lobe_count() >= 1 && header.lobe_count() <= kLobeCountMax);
    MULTUM_CHECK(static_cast<int>(header.levels.size()) == mip_level_count(header.width(), header.height()));
  }

  const std::size_t lobe_count;
  const bool has_colours;
  const std::size_t weight_count;
  const bool has_roughness;
  const std::vector<MovmfPart> parts;
  const std::unique_ptr<MovmfScan> scan;  // used only by the writer's thread until this thread ends
};

namespace {

using Shape = MovmfWriter::Shape;

class FinestPortion : public BakedRows {
 public:
  FinestPortion(const Shape& shape, MovmfFinest rows) : shape_(shape), rows_(std::move(rows)) {}

  int level() const override { return 0; }
  int height() const override { return rows_.height; }
  std::size_t bytes() const override {
    return rows_.normals.size() * (sizeof(glm::vec3) + 1) + rows_.colours.size() * sizeof(glm::vec3) +
           rows_.weights.size() * sizeof(float);
  }
  void check_sizes(int level_width) const override {
    MULTUM_CHECK(rows_.width == level_width && rows_.height >= 0);
    const std::size_t texels = texel_count(rows_.width, rows_.height);
    MULTUM_CHECK(rows_.normals.size() == texels && rows_.lobe.size() == texels);
    MULTUM_CHECK(rows_.colours.size() == (shape_.has_colours ? texels : 0));
    MULTUM_CHECK(rows_.weights.size() == shape_.weight_count * texels && rows_.has_roughness == shape_.has_roughness);
    for (const std::uint8_t lobe : rows_.lobe) MULTUM_CHECK(lobe < shape_.lobe_count);
  }
  void copy_values(std::size_t, std::size_t first, std::size_t count, float* values) const override {
    interleave(rows_, first, count, values);
  }
  void scan(int first_row) const override { shape_.scan->add_finest(first_row, rows_); }

 private:
  const Shape& shape_;
  const MovmfFinest rows_;
};

class LevelPortion : public BakedRows {
 public:
  LevelPortion(const Shape& shape, int level, MovmfLevel rows) : shape_(shape), level_(level), rows_(std::move(rows)) {}

  int level() const override { return level_; }
  int height() const override { return rows_.height; }
  std::size_t bytes() const override {
    std::size_t sum = 0;
    for (const auto& lobe : rows_.lobes) sum += lobe.size() * sizeof(glm::vec4);
    for (const auto& colour : rows_.colours) sum += colour.size() * sizeof(glm::vec3);
    for (const auto& weights : rows_.weights) sum += weights.size() * sizeof(float);
    return sum;
  }
  void check_sizes(int level_width) const override {
    MULTUM_CHECK(rows_.width == level_width && rows_.height >= 0);
    const std::size_t texels = texel_count(rows_.width, rows_.height);
    MULTUM_CHECK(rows_.lobes.size() == shape_.lobe_count);
    MULTUM_CHECK(rows_.colours.size() == (shape_.has_colours ? shape_.lobe_count : 0));
    for (const auto& lobe : rows_.lobes) MULTUM_CHECK(lobe.size() == texels);
    for (const auto& colour : rows_.colours) MULTUM_CHECK(colour.size() == texels);
    MULTUM_CHECK(rows_.weights.size() == (shape_.weight_count > 0 ? shape_.lobe_count : 0));
    for (const auto& weights : rows_.weights) MULTUM_CHECK(weights.size() == texels * shape_.weight_count);
  }
  void copy_values(std::size_t part, std::size_t first, std::size_t count, float* values) const override {
    const std::size_t channels = shape_.parts[part].channels.size();
    std::memcpy(values, shape_.parts[part].values(rows_) + first * channels, count * channels * sizeof(float));
  }
  void scan(int first_row) const override { shape_.scan->add(level_, first_row, rows_); }

 private:
  const Shape& shape_;
  const int level_;
  const MovmfLevel rows_;
};

}  // namespace

MovmfWriter::MovmfWriter(const std::string& path, const MovmfMipmap& header, const BakedWriteOptions& options)
    : shape_(std::make_unique<const Shape>(header)),
      writer_(std::make_unique<BakedWriter>(path, full_header(header),
                                            std::vector<BakedPart>(shape_->parts.begin(), shape_->parts.end()),
                                            make_headers(header, shape_->parts, options), options)) {}

MovmfWriter::~MovmfWriter() = default;

void MovmfWriter::write_finest(int first_row, MovmfFinest rows) {
  writer_->write(first_row, std::make_unique<FinestPortion>(*shape_, std::move(rows)));
}

void MovmfWriter::write_level(int level, int first_row, MovmfLevel rows) {
  MULTUM_CHECK(level >= 1);
  writer_->write(first_row, std::make_unique<LevelPortion>(*shape_, level, std::move(rows)));
}

void MovmfWriter::commit(const std::string& measured_error, Progress* progress) {
  writer_->commit(
      measured_error, [this] { return shape_->scan->findings(); }, progress);
}

const std::string& MovmfWriter::content_hash() const { return writer_->content_hash(); }

void write_movmf_mipmap(const std::string& path, const MovmfMipmap& mipmap, const BakedWriteOptions& options,
                        Progress* progress) {
  BakedWriteOptions exact = options;
  exact.measured_error_bytes = static_cast<int>(mipmap.header.provenance.measured_error.size());
  MovmfWriter writer(path, mipmap, exact);
  for (std::size_t l = static_cast<std::size_t>(mipmap.header.first_level); l < mipmap.levels.size(); ++l) {
    const MovmfLevel& level = mipmap.levels[l];
    for (int row = 0; row < level.height; row += options.tile_size) {
      progress_advance(progress, 0);  // lets the caller cancel
      const int rows = std::min(options.tile_size, level.height - row);
      if (l == 0)
        writer.write_finest(row,
                            finest_of(level, row, rows, mipmap.header.representation, mipmap.header.has_roughness));
      else writer.write_level(static_cast<int>(l), row, rows_of(level, row, rows));
    }
  }
  writer.commit(mipmap.header.provenance.measured_error, progress);
}

}  // namespace multum
