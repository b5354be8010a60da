// SPDX-License-Identifier: Apache-2.0
// Tests the errors of multum.h. Every wrong argument is reported with a message that names the settings, and no file or
// memory remains.
#include <cstddef>
#include <fstream>

#include "tests/api/api_fixture.h"

namespace multum::testing {
namespace {

TEST(ApiErrorTest, NullErrorIsSuccess) {
  EXPECT_EQ(multum_error_status(nullptr), MULTUM_OK);
  EXPECT_STREQ(multum_error_message(nullptr), "");
  EXPECT_STREQ(multum_error_file(nullptr), "");
  multum_error_free(nullptr);
  multum_map_free(nullptr);
  multum_device_free(nullptr);
  multum_values_free(nullptr);
  multum_brdf_free(nullptr);
  multum_text_free(nullptr);
  EXPECT_STREQ(multum_text_get(nullptr), "");
}

// Programs that were built with an earlier header rely on these numbers (x86-64 and arm64).
TEST(ApiErrorTest, StructsKeepTheirLayout) {
  EXPECT_EQ(sizeof(multum_callbacks), 32u);
  EXPECT_EQ(offsetof(multum_callbacks, progress), 16u);
  EXPECT_EQ(sizeof(multum_image), 40u);
  EXPECT_EQ(offsetof(multum_image, pixels), 32u);
  EXPECT_EQ(sizeof(multum_maps), 48u);
  EXPECT_EQ(sizeof(multum_parameter), 24u);
  EXPECT_EQ(sizeof(multum_info), 40u);
  EXPECT_EQ(sizeof(multum_view), 24u);
  EXPECT_EQ(sizeof(multum_plane), 104u);
  EXPECT_EQ(sizeof(multum_region), 16u);
  EXPECT_EQ(sizeof(multum_lobes), 12u + 8u * 28u);
  EXPECT_EQ(static_cast<int>(MULTUM_INTERNAL), 7);
  EXPECT_EQ(static_cast<int>(MULTUM_SNORM16), 4);
  EXPECT_EQ(static_cast<int>(MULTUM_HARMONICS), 5);
}

TEST(ApiErrorTest, UnknownCommandHasNoSettings) {
  multum_values* values = nullptr;
  MadeError error;
  EXPECT_EQ(multum_values_new("brew", &values, error.place()), MULTUM_BAD_SETTING);
  EXPECT_EQ(values, nullptr);
  EXPECT_EQ(error.message(), "command is 'brew', expected bake, export, gltf, infer or pack");
  EXPECT_EQ(multum_parameter_count("brew"), 0);
  EXPECT_STREQ(multum_parameter_at("bake", -1).name, "");
  EXPECT_STREQ(multum_parameter_at("bake", 1000).name, "");
}

TEST(ApiErrorTest, IllegalValuesNameTheSetting) {
  const Owned<multum_values> values = bake_values();
  MadeError number, text, flag, unknown, kind;
  EXPECT_EQ(multum_values_set_number(values.get(), "lobes", 9, number.place()), MULTUM_BAD_SETTING);
  EXPECT_EQ(number.message(), "lobes is 9, expected an integer from 1 to 8");
  EXPECT_EQ(number.found(), "9");
  EXPECT_EQ(number.expected(), "an integer from 1 to 8");
  EXPECT_EQ(multum_values_set_text(values.get(), "ndf", "cones", text.place()), MULTUM_BAD_SETTING);
  EXPECT_NE(text.message().find("ndf is"), std::string::npos) << text.message();
  EXPECT_EQ(multum_values_set_flag(values.get(), "lobes", 1, flag.place()), MULTUM_BAD_SETTING);
  EXPECT_EQ(multum_values_set_number(values.get(), "lobse", 3, unknown.place()), MULTUM_BAD_SETTING);
  EXPECT_NE(unknown.message().find("'lobse' is unknown"), std::string::npos);
  EXPECT_EQ(multum_values_set_number(values.get(), "lobes", 2.5, kind.place()), MULTUM_BAD_SETTING);
}

TEST(ApiErrorTest, EverySettingOfATableHasTexts) {
  for (const char* command : {"bake", "export", "gltf", "infer", "pack"}) {
    const int count = multum_parameter_count(command);
    EXPECT_GT(count, 3) << command;
    for (int i = 0; i < count; ++i) {
      const multum_parameter row = multum_parameter_at(command, i);
      EXPECT_STRNE(row.name, "") << command;
      EXPECT_STRNE(row.help, "") << row.name;
      EXPECT_EQ(std::string(row.name).find('-'), std::string::npos) << row.name;
    }
  }
}

TEST(ApiErrorTest, MissingFileIsNamed) {
  const Owned<multum_device> device = open_device();
  multum_maps maps = MULTUM_MAPS_INIT;
  maps.input = "/nowhere/bricks.png";
  multum_map* map = nullptr;
  MadeError error;
  EXPECT_EQ(multum_bake(device.get(), &maps, nullptr, nullptr, nullptr, &map, error.place()), MULTUM_BAD_INPUT);
  EXPECT_EQ(error.file(), "/nowhere/bricks.png") << error.message();
  EXPECT_EQ(map, nullptr);
}

TEST(ApiErrorTest, MapsMustBeOneOfFileAndImage) {
  const Owned<multum_device> device = open_device();
  const std::vector<float> pixels = wavy_normals(8);
  const multum_image image = image_of(pixels, 8);
  multum_maps maps = MULTUM_MAPS_INIT;
  multum_map* map = nullptr;
  MadeError neither, both, old;
  EXPECT_EQ(multum_bake(device.get(), &maps, nullptr, nullptr, nullptr, &map, neither.place()), MULTUM_BAD_SETTING);
  maps.input = "a.png";
  maps.normals = &image;
  EXPECT_EQ(multum_bake(device.get(), &maps, nullptr, nullptr, nullptr, &map, both.place()), MULTUM_BAD_SETTING);
  EXPECT_NE(both.message().find("found both"), std::string::npos) << both.message();
  maps.size = 0;
  EXPECT_EQ(multum_bake(device.get(), &maps, nullptr, nullptr, nullptr, &map, old.place()), MULTUM_BAD_SETTING);
}

TEST(ApiErrorTest, NullArgumentsAreReported) {
  MadeError error;
  EXPECT_EQ(multum_bake(nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, error.place()), MULTUM_BAD_SETTING);
  EXPECT_EQ(error.message(), "multum_bake: device is NULL, expected a device");
  EXPECT_EQ(multum_map_open(nullptr, nullptr, nullptr), MULTUM_BAD_SETTING);
  EXPECT_EQ(multum_device_open("", nullptr, nullptr), MULTUM_BAD_SETTING);
  EXPECT_EQ(multum_values_new(nullptr, nullptr, nullptr), MULTUM_BAD_SETTING);
  EXPECT_EQ(multum_values_set_number(nullptr, "lobes", 1, nullptr), MULTUM_BAD_SETTING);
  EXPECT_EQ(multum_brdf_new(nullptr, nullptr, nullptr), MULTUM_BAD_SETTING);
  EXPECT_EQ(multum_map_info(nullptr).width, 0);
}

TEST(ApiErrorTest, BadImagesAreReported) {
  const Owned<multum_device> device = open_device();
  const std::vector<float> pixels = wavy_normals(8);
  multum_maps maps = MULTUM_MAPS_INIT;
  const auto refusal = [&](void (*change)(multum_image&)) {
    multum_image image = image_of(pixels, 8);
    change(image);
    maps.normals = &image;
    multum_map* map = nullptr;
    MadeError error;
    EXPECT_EQ(multum_bake(device.get(), &maps, nullptr, nullptr, nullptr, &map, error.place()), MULTUM_BAD_SETTING);
    return error.message();
  };
  EXPECT_EQ(refusal([](multum_image& image) { image.width = 0; }),
            "normals: found 0 x 8 texels, expected 1 to 1048576 per side");
  EXPECT_EQ(refusal([](multum_image& image) { image.channels = 5; }), "normals: found 5 channels, expected 1 to 4");
  EXPECT_EQ(refusal([](multum_image& image) { image.pixels = nullptr; }), "normals: pixels is NULL, expected pixels");
  EXPECT_EQ(refusal([](multum_image& image) { image.row_bytes = 5; }), "normals: row_bytes is 5, expected at least 96");
  EXPECT_NE(refusal([](multum_image& image) { image.type = MULTUM_SNORM16; }).find("type is 4"), std::string::npos);
}

TEST(ApiErrorTest, BadDataInMemoryIsNamedByItsPlainName) {
  const Owned<multum_device> device = open_device();
  std::vector<float> pixels(8 * 8 * 3, std::nanf(""));
  const multum_image image = image_of(pixels, 8);
  multum_maps maps = MULTUM_MAPS_INIT;
  maps.normals = &image;
  multum_map* map = nullptr;
  MadeError error;
  EXPECT_EQ(multum_bake(device.get(), &maps, nullptr, nullptr, nullptr, &map, error.place()), MULTUM_BAD_INPUT);
  EXPECT_EQ(error.message().rfind("normals: ", 0), 0u) << error.message();
  EXPECT_EQ(error.message().find("memory"), std::string::npos) << error.message();
  EXPECT_EQ(error.message().find("--"), std::string::npos) << error.message();
}

TEST(ApiErrorTest, DamagedFileIsRefused) {
  const TestFolder folder;
  std::ofstream(folder.file("broken.ndf.exr")) << "not an OpenEXR file";
  multum_map* map = nullptr;
  MadeError error;
  EXPECT_EQ(multum_map_open(folder.file("broken.ndf.exr").c_str(), &map, error.place()), MULTUM_BAD_INPUT);
  EXPECT_EQ(error.file(), folder.file("broken.ndf.exr"));
}

}  // namespace
}  // namespace multum::testing
