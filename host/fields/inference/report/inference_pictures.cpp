// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/report/inference_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "host/fields/inference/pipeline/inference_rows.h"
#include "host/formats/image/colour_map.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"

namespace multum {
namespace {

constexpr int kMargin = 4;  // pixels around an object

// Returns a file name that needs no escaping in pages, on disks or in shells. The number makes it unique.
std::string file_name(std::size_t object, const std::string& name, const std::string& what) {
  std::string safe = fmt::format("{:02}_{}_{}", object, name, what);
  for (char& c : safe)
    if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'))) c = '_';
  return "report/" + safe + ".png";
}

class PictureWriter {
 public:
  PictureWriter(const ParameterizedScene& field, const InferenceReport& report)
      : field_(field), report_(report), job_(report.job) {}

  ReportPictures run() {
    make_folder(report_.settings.output + "/report");
    if (report_.frames != nullptr) {
      const auto frame = std::find_if(report_.frames->frames.begin(), report_.frames->frames.end(),
                                      [&](const FrameErrors& one) { return one.sample == report_.sample; });
      if (frame != report_.frames->frames.end()) write_frame(*frame);
    }
    for (std::size_t k = 0; k < report_.result.manifest.objects.size(); ++k) write_textures(k);
    return std::move(pictures_);
  }

 private:
  void write_frame(const FrameErrors& errors) {
    const RenderedFrame frame = read_frame(job_, report_.settings.output + "/" + errors.file);
    const Png8Image ray_traced = srgb_image(ray_traced_picture(field_, report_.sample), frame.width, frame.height);
    const Png8Image rendered = srgb_image(frame.rgb, frame.width, frame.height);
    const Png8Image error = error_image(ray_traced, rendered);
    const PixelBox all = {0, 0, frame.width, frame.height};
    pictures_.has_frame = true;
    pictures_.frame = {write("report/frame_ray_traced.png", ray_traced), write("report/frame_rendered.png", rendered),
                       write("report/frame_error.png", cut_out(error, frame.alpha, all)), errors.squared_error};
    const std::vector<std::vector<float>> coverages = field_.coverages(report_.sample);
    for (std::size_t k = 0; k < coverages.size(); ++k) {
      const PixelBox box = covered_box(coverages[k], frame.width, frame.height);
      PictureRow row;
      if (box.width > 0) {
        const auto one = [&](const char* what, const Png8Image& image) {
          return write(file_name(k, job_.objects[k].name, what), cut_out(image, coverages[k], box));
        };
        row = {one("ray_traced", ray_traced), one("rendered", rendered), one("error", error),
               errors.object_squared_errors[k]};
      }
      pictures_.objects.push_back(row);
    }
  }

  void write_textures(std::size_t k) {
    for (const InferredLayer& layer : report_.result.manifest.objects[k].layers) {
      const std::string& file = layer.textures[static_cast<std::size_t>(report_.sample)];
      if (file.empty()) continue;
      const auto found = std::find_if(job_.layers.begin(), job_.layers.end(),
                                      [&](const AnimationLayer& one) { return one.name == layer.name; });
      MULTUM_CHECK(found != job_.layers.end());
      InferredTexture texture = read_inferred_texture(report_.settings.output + "/" + file);
      texture.texels.resize(3u * static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height));
      divide(texture.texels, job_.radiance_max);
      pictures_.textures.push_back({k, static_cast<std::size_t>(found - job_.layers.begin()),
                                    write(file_name(k, job_.objects[k].name, "texture_" + layer.name),
                                          srgb_image(texture.texels, texture.width, texture.height))});
    }
  }

  ReportPicture write(const std::string& file, const Png8Image& image) const {
    write_png8(report_.settings.output + "/" + file, image);
    return {file, image.width, image.height};
  }

  const ParameterizedScene& field_;
  const InferenceReport& report_;
  const AnimationJob& job_;
  ReportPictures pictures_;
};

}  // namespace

ReportPictures write_report_pictures(const ParameterizedScene& field, const InferenceReport& report) {
  return PictureWriter(field, report).run();
}

PixelBox covered_box(const std::vector<float>& coverage, int width, int height) {
  int x_min = width, x_max = -1, y_min = height, y_max = -1;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (coverage[static_cast<std::size_t>(y * width + x)] < kWholeCoverage) continue;
      x_min = std::min(x_min, x);
      x_max = std::max(x_max, x);
      y_min = std::min(y_min, y);
      y_max = std::max(y_max, y);
    }
  if (x_max < 0) return {};
  x_min = std::max(0, x_min - kMargin);
  y_min = std::max(0, y_min - kMargin);
  return {x_min, y_min, std::min(width - 1, x_max + kMargin) - x_min + 1,
          std::min(height - 1, y_max + kMargin) - y_min + 1};
}

Png8Image srgb_image(const std::vector<float>& rgb, int width, int height) {
  MULTUM_CHECK(rgb.size() == 3u * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  Png8Image image{width, height, 3, {}};
  image.interleaved.reserve(rgb.size());
  for (const float value : rgb) {
    // Shows NaN as black.
    const double linear = std::isfinite(value) ? std::clamp(static_cast<double>(value), 0.0, 1.0) : 0.0;
    image.interleaved.push_back(static_cast<std::uint8_t>(std::lround(255.0 * srgb_from_linear(linear))));
  }
  return image;
}

Png8Image error_image(const Png8Image& a, const Png8Image& b) {
  MULTUM_CHECK(a.interleaved.size() == b.interleaved.size());
  Png8Image image = a;
  for (std::size_t i = 0; i < image.interleaved.size(); ++i)
    image.interleaved[i] =
        static_cast<std::uint8_t>(std::min(255.0, kErrorScale * std::abs(a.interleaved[i] - b.interleaved[i])));
  return image;
}

Png8Image cut_out(const Png8Image& image, const std::vector<float>& coverage, const PixelBox& box) {
  Png8Image cut{box.width, box.height, 4, {}};
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x) {
      const auto pixel = static_cast<std::size_t>(y * image.width + x);
      const bool is_covered = coverage[pixel] >= kWholeCoverage;
      for (std::size_t c = 0; c < 3; ++c)  // invisible parts become black, which compresses to almost no bytes
        cut.interleaved.push_back(is_covered ? image.interleaved[3 * pixel + c] : std::uint8_t{0});
      cut.interleaved.push_back(is_covered ? 255 : 0);
    }
  return cut;
}

}  // namespace multum
