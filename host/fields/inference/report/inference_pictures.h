// SPDX-License-Identifier: Apache-2.0
// Draws the pictures of the report of `multum infer`, as in figure 6 of Hakura et al. 2000. For each object, and for
// the whole frame, the pictures show the ray-traced picture, the picture drawn with inferred textures, and the error
// times 20. The textures are also shown. Departure: in the paper's inverted errors, white means no error. Here black
// means no error, so that errors keep their colours.
#pragma once

#include <string>
#include <vector>

#include "host/fields/inference/report/inference_report.h"
#include "host/formats/image/files/png_writer.h"

namespace multum {

struct ReportPicture {
  std::string file;  // relative to the output folder
  int width = 0, height = 0;
};

struct PictureRow {
  ReportPicture ray_traced, rendered, error;
  double squared_error = 0.0;  // squared error of the shown pixels
};

struct ReportPictures {
  bool has_frame = false;
  PictureRow frame;
  std::vector<PictureRow> objects;  // one per object of the job; width 0 if the object covers no pixel wholly
  struct Texture {
    std::size_t object, layer;
    ReportPicture picture;  // picture of level 0
  };
  std::vector<Texture> textures;  // textures of the shown sample
};

constexpr double kErrorScale = 20.0;  // as in the paper's figure 6

/// Writes OUTPUT/report/*.png for the report's sample. Without frames, writes only pictures of textures.
ReportPictures write_report_pictures(const ParameterizedScene& field, const InferenceReport& report);

struct PixelBox {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Returns a box around the wholly covered pixels, with a margin. The box is inside the picture. Its width is 0 if
/// there are no such pixels.
PixelBox covered_box(const std::vector<float>& coverage, int width, int height);

/// Converts linear values of 0..1, three per pixel, to sRGB.
Png8Image srgb_image(const std::vector<float>& rgb, int width, int height);
/// Returns |a - b| * kErrorScale, up to 255.
Png8Image error_image(const Png8Image& a, const Png8Image& b);
/// Returns the box of the picture with alpha. The picture is transparent where coverage is below kWholeCoverage.
Png8Image cut_out(const Png8Image& image, const std::vector<float>& coverage, const PixelBox& box);

}  // namespace multum
