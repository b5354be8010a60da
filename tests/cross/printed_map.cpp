// SPDX-License-Identifier: Apache-2.0
// Prints what multum.h reads from baked files: texts of the header, checksums of all values, filtered lookups, and
// shading. tests/cross/same_map_test.py compares the output of two processors or systems. The program needs no OpenCL.
//   printed_map FILE...
#include <multum.h>

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <vector>

namespace {

int fail(const char* file, multum_error* error) {
  std::fprintf(stderr, "printed_map: %s: %s\n", file, multum_error_message(error));
  const int code = multum_error_status(error);
  multum_error_free(error);
  return code;
}

// FNV-1a of 64 bits, which needs no library.
std::uint64_t checksum(const void* data, std::size_t byte_count) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (std::size_t i = 0; i < byte_count; ++i) hash = (hash ^ bytes[i]) * 0x100000001b3u;
  return hash;
}

multum_status print_level(multum_map* map, int level, multum_part part, multum_error** error) {
  const multum_view shape = multum_map_shape(map, level, part);
  if (shape.layers == 0) return MULTUM_OK;
  multum_view view = {};
  multum_status status = multum_map_level(map, level, part, &view, error);
  if (status != MULTUM_OK) return status;
  const auto count = static_cast<std::size_t>(view.layers) * static_cast<std::size_t>(view.height) *
                     static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.channels);
  std::printf("level %d part %d: %d x %d x %d x %d, floats %016" PRIx64, level, part, view.layers, view.height,
              view.width, view.channels, checksum(view.values, count * sizeof(float)));
  std::vector<std::uint16_t> halves(count);
  const multum_region all = {0, 0, view.width, view.height};
  status = multum_map_read(map, level, part, all, MULTUM_HALF, halves.data(), error);
  if (status == MULTUM_OK) std::printf(", halves %016" PRIx64 "\n", checksum(halves.data(), 2 * count));
  return status;
}

multum_status print_shading(multum_map* map, multum_error** error) {
  const double view[3] = {0.6, 0.0, 0.8}, normal[3] = {0.0, 0.6, 0.8}, random[3] = {0.3, 0.6, 0.2};
  const double lights[3][3] = {{0.0, 0.0, 1.0}, {-0.6, 0.0, 0.8}, {0.36, 0.48, 0.8}};
  for (const char* text : {"lambert", "blinn-phong:100", "ggx:0.4", "ggx:0.2,0.04"}) {
    multum_brdf* made = nullptr;
    multum_status status = multum_brdf_new(text, &made, error);
    if (status != MULTUM_OK) return status;
    const std::unique_ptr<multum_brdf, decltype(&multum_brdf_free)> brdf(made, multum_brdf_free);
    for (int i = 0; i < 8; ++i) {
      multum_lobes lobes = {};
      status = multum_map_lookup(map, 0.11 + 0.31 * i, 0.07 + 0.23 * i, 0.6 * i, &lobes, error);
      if (status != MULTUM_OK) return status;
      std::printf("lookup %d: %d lobes", i, lobes.count);
      for (int j = 0; j < lobes.count; ++j)
        for (const float value : lobes.lobes[j]) std::printf(" %.9g", static_cast<double>(value));
      std::printf("\n");
      for (const auto& light : lights) {
        double rgb[3] = {};
        multum_shade(&lobes, brdf.get(), light, view, rgb);
        std::printf("shade %s: %.17g %.17g %.17g\n", text, rgb[0], rgb[1], rgb[2]);
      }
      double drawn[3] = {};
      const double pdf = multum_sample(&lobes, brdf.get(), view, random, drawn);
      std::printf("sample %s: %.17g %.17g %.17g %.17g\n", text, pdf, drawn[0], drawn[1], drawn[2]);
      std::printf("density: %.17g\n", multum_density(&lobes, normal));
    }
  }
  return MULTUM_OK;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "printed_map: expected baked files\n"), 2;
  for (int i = 1; i < argc; ++i) {
    multum_error* error = nullptr;
    multum_map* opened = nullptr;
    if (multum_map_open(argv[i], &opened, &error) != MULTUM_OK) return fail(argv[i], error);
    const std::unique_ptr<multum_map, decltype(&multum_map_free)> map(opened, multum_map_free);
    const multum_info info = multum_map_info(map.get());
    std::printf("file %d: %d x %d, levels %d to %d, %d lobes, order %d\n", i, info.width, info.height, info.first_level,
                info.level_count - 1, info.lobe_count, info.sh_order);
    for (const char* key : {"representation", "encoding", "content_hash", "settings"})
      std::printf("%s: %s\n", key, multum_map_text(map.get(), key));
    for (int level = info.first_level; level < info.level_count; ++level)
      for (int part = MULTUM_LOBES; part <= MULTUM_HARMONICS; ++part)
        if (print_level(map.get(), level, static_cast<multum_part>(part), &error) != MULTUM_OK)
          return fail(argv[i], error);
    const bool has_lobes = std::strcmp(multum_map_text(map.get(), "representation"), "vmf") == 0;
    if (has_lobes && print_shading(map.get(), &error) != MULTUM_OK) return fail(argv[i], error);
  }
}
