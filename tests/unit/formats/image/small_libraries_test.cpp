// SPDX-License-Identifier: Apache-2.0
// Compares the readers of PNG and JPEG (host/formats/decoder) with OpenImageIO.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cstdio>
#include <filesystem>
#include <optional>
#include <random>

#include "host/formats/decoder/libraries/oiio_image_file.h"
#include "host/formats/image/files/number_type.h"
#include "host/foundation/base/error.h"
#include "tests/fixtures/shared_data.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

struct PngCase {
  int colour_type = PNG_COLOR_TYPE_RGB;
  int bits = 8;
  bool is_interlaced = false;
  bool has_transparent_colour = false;
  std::optional<double> gamma = std::nullopt;  // gAMA
  bool is_srgb = false;
  bool has_text = false;

  std::string name() const {
    return fmt::format("type {} bits {}{}{}{}{}{}", colour_type, bits, is_interlaced ? " interlaced" : "",
                       has_transparent_colour ? " tRNS" : "", gamma ? fmt::format(" gamma {}", *gamma) : "",
                       is_srgb ? " sRGB" : "", has_text ? " text" : "");
  }
};

void write_case(const std::string& path, const PngCase& one, int width, int height) {
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  ASSERT_NE(file, nullptr);
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), one.bits, one.colour_type,
               one.is_interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  std::mt19937 random(7);
  std::vector<png_color> palette(std::size_t{1} << one.bits % 16);
  for (png_color& colour : palette)
    colour = {static_cast<png_byte>(random()), static_cast<png_byte>(random()), static_cast<png_byte>(random())};
  if (one.colour_type == PNG_COLOR_TYPE_PALETTE)
    png_set_PLTE(png, info, palette.data(), static_cast<int>(palette.size()));
  png_byte alphas[] = {0, 100};
  png_color_16 clear = {};
  clear.gray = clear.red = clear.green = clear.blue = 1;
  if (one.has_transparent_colour && one.colour_type == PNG_COLOR_TYPE_PALETTE)
    png_set_tRNS(png, info, alphas, 2, nullptr);
  else if (one.has_transparent_colour) png_set_tRNS(png, info, nullptr, 0, &clear);
  if (one.gamma) png_set_gAMA(png, info, *one.gamma);
  if (one.is_srgb) png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  char key[] = "Comment", text[] = "made by a test";
  png_text comment = {};
  comment.compression = PNG_TEXT_COMPRESSION_NONE;
  comment.key = key;
  comment.text = text;
  if (one.has_text) png_set_text(png, info, &comment, 1);
  png_write_info(png, info);
  std::vector<std::vector<png_byte>> rows(static_cast<std::size_t>(height));
  std::vector<png_bytep> pointers;
  for (std::vector<png_byte>& row : rows) {
    row.resize(png_get_rowbytes(png, info));
    for (png_byte& byte : row) byte = static_cast<png_byte>(random() % 4 == 0 ? 0 : random());
    pointers.push_back(row.data());
  }
  png_write_image(png, pointers.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

void expect_equal_parts(const ImagePart& a, const ImagePart& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.full_width, b.full_width);
  EXPECT_EQ(a.full_height, b.full_height);
  EXPECT_EQ(a.tile_width, b.tile_width);
  EXPECT_EQ(a.alpha_channel, b.alpha_channel);
  EXPECT_EQ(a.base_type, b.base_type);
  EXPECT_EQ(a.channel_names, b.channel_names);
  EXPECT_EQ(a.channel_types, b.channel_types);
  EXPECT_EQ(a.colour_space, b.colour_space);
  EXPECT_EQ(a.compression, b.compression);
  EXPECT_EQ(a.rows_per_strip, b.rows_per_strip);
}

std::vector<std::byte> values_of(LibraryImageFile& file, const PixelBlock& block) {
  std::vector<std::byte> values(block_bytes(file.part(), block));
  EXPECT_EQ(file.read_into(block, values.data()), "");
  return values;
}

class SmallLibrariesTest : public ::testing::Test {
 protected:
  void compare(const std::string& path) {
    const auto file = open_small_library_image(path, {}), expected = open_oiio_image(path, {});
    ASSERT_NE(file, nullptr);
    EXPECT_EQ(file->description().format, expected->description().format);
    expect_equal_parts(file->part(), expected->part());
    const int channels = expected->part().channel_count(), type = expected->part().base_type;
    const int height = expected->part().height, third = height / 3;
    // The last block goes back to the top.
    for (const auto& [begin, end] : {std::pair{0, third}, std::pair{third, height}, std::pair{0, height}})
      for (const auto& [first, last] : {std::pair{0, channels}, std::pair{0, 1}, std::pair{channels - 1, channels}}) {
        const PixelBlock block{0, begin, end, first, last, type};
        EXPECT_TRUE(values_of(*file, block) == values_of(*expected, block)) << begin << " to " << end;
      }
  }
  void compare(const PngCase& one, int width, int height) {
    SCOPED_TRACE(one.name());
    write_case(png_, one, width, height);
    compare(png_);
  }

  const TemporaryFolder folder_;
  const std::string png_ = folder_ / "map.png", jpeg_ = folder_ / "map.jpg";
};

TEST_F(SmallLibrariesTest, EachTypeAgreesWithOpenImageIO) {
  const std::vector<std::pair<int, std::vector<int>>> types = {{PNG_COLOR_TYPE_GRAY, {1, 2, 4, 8, 16}},
                                                               {PNG_COLOR_TYPE_RGB, {8, 16}},
                                                               {PNG_COLOR_TYPE_PALETTE, {1, 2, 4, 8}},
                                                               {PNG_COLOR_TYPE_GRAY_ALPHA, {8, 16}},
                                                               {PNG_COLOR_TYPE_RGB_ALPHA, {8, 16}}};
  for (const auto& [type, depths] : types)
    for (const int bits : depths)
      for (const bool is_interlaced : {false, true})
        for (const bool has_transparent_colour : {false, true})
          if (!has_transparent_colour || (type & PNG_COLOR_MASK_ALPHA) == 0)
            compare({type, bits, is_interlaced, has_transparent_colour}, 37, 21);
}

TEST_F(SmallLibrariesTest, EachColourSpaceAgreesWithOpenImageIO) {
  for (const bool has_text : {false, true}) {
    for (const double gamma : {1.0, 1.0 / 1.85, 1.0 / 2.2, 0.5})
      compare({PNG_COLOR_TYPE_RGB, 8, false, false, gamma, false, has_text}, 9, 5);
    compare({PNG_COLOR_TYPE_RGB, 8, false, false, 1.0 / 2.2, true, has_text}, 9, 5);
  }
  compare({PNG_COLOR_TYPE_GRAY, 16, false, false, std::nullopt, true, false}, 1, 1);
}

TEST_F(SmallLibrariesTest, JpegAgreesWithOpenImageIO) {
  for (const int channels : {1, 3})
    for (const char* subsampling : {"4:4:4", "4:2:0"}) {
      SCOPED_TRACE(fmt::format("{} channels {}", channels, subsampling));
      OIIO::ImageSpec spec(61, 43, channels, OIIO::TypeDesc::UINT8);
      spec.attribute("jpeg:subsampling", subsampling);
      spec.attribute("ImageDescription", "made by a test");
      std::mt19937 random(3);
      std::vector<std::uint8_t> values(spec.image_pixels() * static_cast<std::size_t>(channels));
      for (std::uint8_t& value : values) value = static_cast<std::uint8_t>(random());
      const auto out = OIIO::ImageOutput::create("jpeg");
      ASSERT_TRUE(out->open(jpeg_, spec) && out->write_image(OIIO::TypeDesc::UINT8, values.data()) && out->close());
      compare(jpeg_);
    }
}

// Real files, among them progressive and grey ones. Files that OpenImageIO refuses must be refused too.
TEST_F(SmallLibrariesTest, FilesOfTheSharedDataAgreeWithOpenImageIO) {
  if (shared_data().empty()) GTEST_SKIP() << "MULTUM_SHARED_DATA is not set";
  int compared = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(shared_data())) {
    const std::string path = entry.path().string();
    if (!entry.is_regular_file() || (image_format(path) != "png" && image_format(path) != "jpeg")) continue;
    SCOPED_TRACE(path);
    std::unique_ptr<LibraryImageFile> file, expected;
    const auto refusal = [&](auto open, std::unique_ptr<LibraryImageFile>& to) {
      try {
        to = open(path, ImageFileSettings{});
        return to != nullptr ? "" : "none";
      } catch (const Error&) {
        return "refused";
      }
    };
    const std::string theirs = refusal(open_oiio_image, expected), ours = refusal(open_small_library_image, file);
    if (ours == "none") continue;  // CMYK
    EXPECT_EQ(ours, theirs);
    if (file == nullptr || expected == nullptr) continue;
    expect_equal_parts(file->part(), expected->part());
    const PixelBlock all{
        0, 0, expected->part().height, 0, expected->part().channel_count(), expected->part().base_type};
    std::vector<std::byte> mine(block_bytes(file->part(), all)), reference(mine.size());
    const bool is_read = file->read_into(all, mine.data()).empty();
    EXPECT_EQ(is_read, expected->read_into(all, reference.data()).empty());
    EXPECT_TRUE(!is_read || mine == reference);
    ++compared;
  }
  EXPECT_GT(compared, 10);
}

TEST_F(SmallLibrariesTest, OtherFilesAreLeftToOpenImageIO) {
  TestImage image = normal_image(8, 8);
  write_test_image(folder_ / "a.tif", image);
  write_test_image(folder_ / "a.webp", image);
  write_test_image(folder_ / "a.exr", image);
  for (const char* name : {"a.tif", "a.webp", "a.exr"})
    EXPECT_EQ(open_small_library_image(folder_ / name, {}), nullptr);
  write_test_image(png_, image);
  ImageFileSettings with_texts;
  with_texts.all_parts = true;
  EXPECT_EQ(open_small_library_image(png_, with_texts), nullptr);
}

// libpng notices a wrong checksum. libjpeg only warns that data is missing, and makes rows grey.
TEST_F(SmallLibrariesTest, DamageIsReported) {
  write_case(png_, {}, 64, 64);
  std::string bytes = read_bytes(png_);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] + 1);
  write_bytes(png_, bytes);
  write_test_image(jpeg_, normal_image(64, 64));
  bytes = read_bytes(jpeg_);
  write_bytes(jpeg_, bytes.substr(0, bytes.size() * 3 / 4) + "\xff\xd9");
  for (const std::string& path : {png_, jpeg_}) {
    SCOPED_TRACE(path);
    const auto file = open_small_library_image(path, {});
    std::vector<std::byte> values(64 * 64 * 3);
    EXPECT_NE(file->read_into({0, 0, 64, 0, 3, number_type::kUint8}, values.data()), "");
  }
}

}  // namespace
}  // namespace multum::testing
