// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/averages/moment_file.h"

#include "host/formats/asset/averages/moment_parts.h"
#include "host/formats/asset/baked_reader.h"
#include "host/formats/asset/exr/exr_rows.h"

namespace multum {

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
    const std::vector<MomentPart> kinds = moment_part_kinds(header_);
    const std::vector<BakedPart> parts = moment_parts(header_);
    for (std::size_t p = 0; p < parts.size(); ++p) {
      auto* const values = const_cast<float*>(moment_part_values(rows, kinds[p]));
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
