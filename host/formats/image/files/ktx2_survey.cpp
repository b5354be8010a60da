// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/files/ktx2_survey.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "host/formats/image/files/number_type.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr char kHead[] = "the head of a KTX2 file";

struct Ktx2Texels {
  std::int64_t vk_format;
  int base_type, channels, bytes;
  bool is_srgb;
};

// These are VK_FORMAT_R8_UNORM, R8G8_UNORM, R8G8B8A8_UNORM, R8G8B8A8_SRGB, R16G16B16A16_SFLOAT.
constexpr Ktx2Texels kKtx2Texels[] = {{9, number_type::kUint8, 1, 1, false},
                                      {16, number_type::kUint8, 2, 2, false},
                                      {37, number_type::kUint8, 4, 4, false},
                                      {43, number_type::kUint8, 4, 4, true},
                                      {97, number_type::kHalf, 4, 8, false}};

// Values of KHR_DF_MODEL and KHR_DF_TRANSFER in the first descriptor block.
constexpr std::int64_t kUastcModel = 166, kSrgbTransfer = 2;

void find_texels(const std::string& path, ByteFile& file, Ktx2Survey& survey) {
  const std::int64_t vk_format = file.little_endian(12, 4, kHead), descriptor = file.little_endian(48, 4, kHead);
  const std::int64_t model = file.little_endian(descriptor + 12, 1, kHead);
  survey.is_srgb = file.little_endian(descriptor + 14, 1, kHead) == kSrgbTransfer;
  survey.is_uastc = vk_format == 0 && model == kUastcModel;
  if (survey.is_uastc) {
    survey.base_type = number_type::kUint8;
    survey.channel_count = 4;
    survey.bytes = (survey.width + 3) / 4 * ((survey.height + 3) / 4) * 16;
    return;
  }
  const auto found = std::find_if(std::begin(kKtx2Texels), std::end(kKtx2Texels),
                                  [&](const Ktx2Texels& one) { return one.vk_format == vk_format; });
  if (found == std::end(kKtx2Texels))
    refuse_file(
        path,
        fmt::format(
            "found a KTX2 texture of VkFormat {} (colour model {}), expected uncompressed texels (R8, RG8, RGBA8 or "
            "RGBA16F) or UASTC. Give the image from which it was made, or the output of multum export --texels rgba8",
            vk_format, model));
  survey.base_type = found->base_type;
  survey.channel_count = found->channels;
  survey.is_srgb = survey.is_srgb || found->is_srgb;
  survey.bytes = survey.width * survey.height * found->bytes;
}

}  // namespace

Ktx2Survey survey_ktx2(const std::string& path, ByteFile& file) {
  constexpr std::int64_t kSideMax = 1 << 20, kZstandard = 2, kIndexAt = 80;
  const auto word = [&](std::int64_t position) { return file.little_endian(position, 4, kHead); };
  Ktx2Survey survey;
  survey.width = word(20);
  survey.height = word(24);
  if (survey.width < 1 || survey.height < 1 || survey.width > kSideMax || survey.height > kSideMax)
    refuse_file(path, fmt::format("found a KTX2 texture of {} x {} texels, expected 1 to 2^20 per side", survey.width,
                                  survey.height));
  if (word(28) > 1 || word(32) > 0 || word(36) != 1)
    refuse_file(path,
                fmt::format("found a KTX2 texture with depth {}, {} layers and {} faces, expected a single picture",
                            word(28), word(32), word(36)));
  const std::int64_t scheme = word(44);
  if (scheme != 0 && scheme != kZstandard)
    refuse_file(path, fmt::format("found a KTX2 texture with supercompression {}, expected none or Zstandard", scheme));
  survey.is_zstd = scheme == kZstandard;
  find_texels(path, file, survey);
  survey.begin = file.little_endian(kIndexAt, 8, kHead);
  survey.stored_bytes = file.little_endian(kIndexAt + 8, 8, kHead);
  if (survey.stored_bytes < 1 || (!survey.is_zstd && survey.stored_bytes != survey.bytes))
    refuse_file(path,
                fmt::format("damaged KTX2: level 0 has {} bytes, expected {}", survey.stored_bytes, survey.bytes));
  if (survey.begin < 0 || survey.begin > file.size() || survey.stored_bytes > file.size() - survey.begin)
    refuse_file(
        path, fmt::format("the file is cut short: it ends at byte {}, expected level 0 of a KTX2 texture, {} bytes at "
                          "byte {}",
                          file.size(), survey.stored_bytes, survey.begin));
  return survey;
}

}  // namespace multum
