// SPDX-License-Identifier: Apache-2.0
// Rules, in order. Thresholds lie between real maps on either side, whose numbers stand next to them; the test
// SharedData.EveryFileOfTheManifestIsUnderstood prints the numbers of every file.
//  1. One channel, or three that are equal up to compression noise: a height field. (Measured: noise up to 0.1 codes
//     rms in 8 bits; the greyest colour image 2.5.) A grey gloss or albedo is like a height: a warning says so. One
//     value tells nothing and two are a mask: refused.
//  2. Two channels, or a constant blue that does not complete the vectors: z is rebuilt, if x^2 + y^2 <= 1 allows it.
//  3. Floats: 0..1 or signed, whichever gives unit vectors. Integers are 0..1.
//  4. Refused unless it looks like normals (`refusal` below).
//  5. Green by the gradient agreement; up when it is undecided.
#include "host/image/encoding_detection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/parallel.h"
#include "host/image/vector_statistics.h"

namespace multum {
namespace {

struct Reading {
  VectorEncoding encoding;
  VectorStatistics statistics;
};

// Rms distance of the channels from their mean, over the finite texels. For floats relative to the rms of the values (a
// height in metres and a dim photograph both have their own scale), for integers in units of the whole range.
double chroma_rms(const RawImage& image, int threads) {
  struct Sums {
    double chroma = 0, values = 0, count = 0;
  };
  std::vector<Sums> bands(static_cast<std::size_t>(row_band_count(image.height, kRowsPerBand)));
  for_each_row_band(image.height, kRowsPerBand, threads, [&](int band, int row_begin, int row_end) {
    Sums& sums = bands[static_cast<std::size_t>(band)];
    const auto width = static_cast<std::size_t>(image.width);
    for (std::size_t i = static_cast<std::size_t>(row_begin) * width; i < static_cast<std::size_t>(row_end) * width;
         ++i) {
      const glm::dvec3 v(image.planes[0][i], image.planes[1][i], image.planes[2][i]);
      if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) continue;
      const glm::dvec3 chroma = v - (v.x + v.y + v.z) / 3.0;
      sums.chroma += chroma.x * chroma.x + chroma.y * chroma.y + chroma.z * chroma.z;
      sums.values += v.x * v.x + v.y * v.y + v.z * v.z;
      sums.count += 3.0;
    }
  });
  Sums total;
  for (const Sums& band : bands) {
    total.chroma += band.chroma;
    total.values += band.values;
    total.count += band.count;
  }
  if (total.count == 0.0) return 1.0;
  if (!is_float_type(image.sample_type)) return std::sqrt(total.chroma / total.count);
  return total.values > 0.0 ? std::sqrt(total.chroma / total.values) : 0.0;
}

bool is_grey(const RawImage& image, int threads) {
  constexpr double kChromaMax = 1.0 / 255.0;
  return image.planes.size() == 3 && chroma_rms(image, threads) <= kChromaMax;
}

// Why a grey image is no height field, nullopt when it may be one: all its finite values are the same, or are one of
// two, up to a fiftieth of what lies between them (8 bits of a compressed mask).
std::optional<std::string> grey_refusal(const RawImage& image, int threads) {
  const std::vector<float>& values = image.planes[0];
  struct Range {
    float low = std::numeric_limits<float>::infinity();
    float high = -std::numeric_limits<float>::infinity();
    bool between = false;
  };
  std::vector<Range> bands(static_cast<std::size_t>(row_band_count(image.height, kRowsPerBand)));
  const auto for_each_value = [&](const auto& visit) {
    for_each_row_band(image.height, kRowsPerBand, threads, [&](int band, int row_begin, int row_end) {
      const auto width = static_cast<std::size_t>(image.width);
      for (std::size_t i = static_cast<std::size_t>(row_begin) * width; i < static_cast<std::size_t>(row_end) * width;
           ++i)
        if (std::isfinite(values[i])) visit(bands[static_cast<std::size_t>(band)], values[i]);
    });
  };
  for_each_value([](Range& band, float value) {
    band.low = std::min(band.low, value);
    band.high = std::max(band.high, value);
  });
  Range all;
  for (const Range& band : bands) {
    all.low = std::min(all.low, band.low);
    all.high = std::max(all.high, band.high);
  }
  if (all.high < all.low) return "no value is finite";
  if (all.high == all.low) return fmt::format("every texel is {:.4g}, which tells nothing", all.low);
  const double margin = 0.02 * (static_cast<double>(all.high) - static_cast<double>(all.low));
  for_each_value([&all, margin](Range& band, float value) {
    const double v = static_cast<double>(value);
    if (v - static_cast<double>(all.low) > margin && static_cast<double>(all.high) - v > margin) band.between = true;
  });
  if (std::any_of(bands.begin(), bands.end(), [](const Range& band) { return band.between; })) return std::nullopt;
  return fmt::format("every texel is {:.4g} or {:.4g}, as in a mask", all.low, all.high);
}

// How well a reading explains the numbers: unit vectors, or for a rebuilt z: possible ones, not all leaning to one
// side.
double plausibility(const Reading& reading) {
  const VectorStatistics& s = reading.statistics;
  if (s.texel_count == 0.0) return -1.0;
  if (!reading.encoding.rebuild_z) return s.unit_share_10;
  return 1.0 - s.beyond_share - std::hypot(s.mean_x, s.mean_y);
}

// Unsigned or signed for a given use of blue: the more plausible one, unsigned when they tie.
Reading best_signedness(const RawImage& image, VectorEncoding encoding, const NormalMapSettings& settings,
                        int threads) {
  encoding.is_signed = settings.is_signed.value_or(false);
  Reading best{encoding, vector_statistics(image, encoding, threads)};
  const bool may_be_signed = is_float_type(image.sample_type) || image.sample_type == SampleType::kOtherInteger;
  if (settings.is_signed.has_value() || !may_be_signed) return best;
  encoding.is_signed = true;
  const Reading other{encoding, vector_statistics(image, encoding, threads)};
  return plausibility(other) > plausibility(best) ? other : best;
}

Reading best_reading(const RawImage& image, const NormalMapSettings& settings, int threads) {
  VectorEncoding encoding;
  encoding.flat_pair = image.sample_type == SampleType::kUint8;
  encoding.rebuild_z = settings.two_channel.value_or(image.planes.size() == 2);
  const Reading first = best_signedness(image, encoding, settings, threads);
  if (settings.two_channel.has_value() || image.planes.size() == 2) return first;
  // A constant blue, up to compression noise: it may be filler, or be what nearly flat normals have.
  const bool blue_is_constant = first.statistics.blue_max - first.statistics.blue_min <= 2.5 / 255.0;
  if (!blue_is_constant || first.statistics.unit_share_10 >= 0.8) return first;
  encoding.rebuild_z = true;
  const Reading rebuilt = best_signedness(image, encoding, settings, threads);
  // Where x^2 + y^2 > 1 the vectors are (x, y, 1) of no unit length, and blue is meant.
  return rebuilt.statistics.beyond_share <= 0.005 ? rebuilt : first;
}

std::string summary(const Reading& reading) {
  const VectorStatistics& s = reading.statistics;
  if (reading.encoding.rebuild_z)
    return fmt::format(
        "x^2 + y^2 <= 1 on {:.1f} %, mean (x, y) ({:+.2f}, {:+.2f}), mean rebuilt z {:.2f}, gradient agreement "
        "{:+.2f}",
        100.0 * (1.0 - s.beyond_share), s.mean_x, s.mean_y, s.rebuilt_z_mean, s.gradient_agreement);
  return fmt::format(
      "length within 10 % of 1 on {:.1f} %, mean vector ({:+.2f}, {:+.2f}, {:+.2f}), {:.1f} % below the horizon, "
      "gradient agreement {:+.2f}",
      100.0 * s.unit_share_10, s.mean_x, s.mean_y, s.mean_z, 100.0 * s.below_share, s.gradient_agreement);
}

// Why (x, y) with a rebuilt z are no normals. Flow maps are the trap: directions of length up to 1 with an empty blue,
// but no surface's gradients and far from flat (measured: agreement 0.00, rebuilt z 0.67).
std::optional<std::string> two_channel_refusal(const VectorStatistics& s) {
  if (s.beyond_share > 0.005) return fmt::format("x^2 + y^2 exceeds 1 on {:.1f} % of texels", 100.0 * s.beyond_share);
  if (std::hypot(s.mean_x, s.mean_y) > 0.5 * s.rebuilt_z_mean) return "the mean vector leans to one side";
  if (s.tilted_share > 0.05 && s.negative_share < 0.01) return "red and green are never negative";
  if (std::abs(s.gradient_agreement) < 0.15 && s.rebuilt_z_mean < 0.85)
    return "red and green are not the slopes of a surface";
  return std::nullopt;
}

// Why vectors (x, y, z) are no normals; nullopt when they are.
//   below the horizon <= 5 %            normal maps reach 1 % (gutters of an atlas), colours start at 9 %
//   |mean xy| <= 0.5 mean z, z >= 0.4   normal maps 0.27 and 0.61, sky blue (135, 206, 235) 0.74; not asked of vectors
//   of unit length
//   and one of: unit within 10 % on 80 %; within 20 % on 60 % with blue or gradients agreeing; gradients agreeing
//   strongly (maps of vectors that are not of unit length)
std::optional<std::string> vector_refusal(const VectorStatistics& s) {
  if (s.below_share > 0.05) {
    const char* object_space = s.unit_share_10 >= 0.9 ? ", as in an object-space normal map" : "";
    return fmt::format("{:.1f} % of texels point below the surface{}", 100.0 * s.below_share, object_space);
  }
  const double agreement = std::abs(s.gradient_agreement);
  if (s.unit_share_5 >= 0.95 && s.mean_z >= 0.1) return std::nullopt;
  if (s.mean_z < 0.4 || std::hypot(s.mean_x, s.mean_y) > 0.5 * s.mean_z) return "the mean vector leans to one side";
  if (s.unit_share_10 >= 0.8) return std::nullopt;
  if (s.unit_share_20 >= 0.6 && (agreement >= 0.15 || s.rebuilt_z_correlation >= 0.25)) return std::nullopt;
  if (agreement >= 0.25) return std::nullopt;
  return "too few vectors are of unit length, and red and green are not the slopes of a surface";
}

std::optional<std::string> refusal(const Reading& reading) {
  const VectorStatistics& s = reading.statistics;
  if (s.texel_count == 0.0) return "no texel holds a vector";
  return reading.encoding.rebuild_z ? two_channel_refusal(s) : vector_refusal(s);
}

// A constant red beside an alpha: compressed maps of one good channel and a better alpha keep x there (DXT5nm).
bool has_x_in_alpha(const RawImage& image) {
  if (!image.has_alpha || image.planes.size() < 3) return false;
  const auto spread = [](const std::vector<float>& plane) {
    const auto [low, high] = std::minmax_element(plane.begin(), plane.end());
    return static_cast<double>(*high) - static_cast<double>(*low);
  };
  constexpr double kNoise = 2.5 / 255.0;
  return spread(image.planes[0]) <= kNoise && spread(image.planes[1]) > kNoise;
}

// --bumpformat cannot help a map with its x in alpha, which is not read: the message does not offer it.
[[noreturn]] void refuse_vectors(const std::string& path, const RawImage& image, const std::string& why) {
  if (has_x_in_alpha(image))
    throw Error(ErrorCode::kInput,
                path +
                    ": found a constant red and an alpha, as in a map with x in alpha (DXT5nm), expected x in red "
                    "and y in green: move alpha to red (oiiotool --no-autopremult IN --ch R=A,G,B=1.0 -o OUT)");
  throw Error(ErrorCode::kInput,
              fmt::format("{}: found no normal map and no height field: {}; expected unit vectors around +Z, or grey. "
                          "If it is one all the same, say so (--bumpformat normal or height)",
                          path, why));
}

// Of the options given, those that say nothing of what the file was taken for.
void warn_of_ignored(const std::vector<std::pair<bool, const char*>>& given, const char* what,
                     std::vector<std::string>& warnings) {
  std::string names;
  for (const auto& [is_given, name] : given)
    if (is_given) names += (names.empty() ? "" : ", ") + std::string(name);
  if (!names.empty()) warnings.push_back(names + ": without effect on " + what);
}

DetectedEncoding height_field(const std::string& reason, const NormalMapSettings& settings) {
  DetectedEncoding result;
  result.is_height_field = true;
  result.reason = reason;
  const bool is_signed = settings.is_signed.value_or(false);
  warn_of_ignored({{settings.green.has_value(), "--green"},
                   {is_signed, "--signed"},
                   {settings.is_signed.has_value() && !is_signed, "--unsigned"},
                   {settings.two_channel.has_value(), "--two-channel"}},
                  "a height field", result.warnings);
  return result;
}

DetectedEncoding grey_image(const std::string& path, const RawImage& image, const std::string& reason,
                            const NormalMapSettings& settings, int threads) {
  if (const std::optional<std::string> why = grey_refusal(image, threads))
    throw Error(ErrorCode::kInput, fmt::format("{}: found a grey image that is no height field: {}; expected heights "
                                               "of more than two values. If it is one all the same, say so "
                                               "(--bumpformat height)",
                                               path, *why));
  return height_field(reason + "; a grey gloss, mask or albedo cannot be told from a height", settings);
}

// The threshold lies between the maps that are known and those that are not (0.15 and 0.31, see vector_statistics.cpp);
// four standard deviations of the correlation of independent samples where they are few.
std::optional<GreenAxis> green_from_gradients(const VectorStatistics& s) {
  const double threshold = std::max(0.25, 4.0 / std::sqrt(std::max(1.0, s.gradient_sample_count)));
  if (s.gradient_agreement >= threshold) return GreenAxis::kUp;
  if (s.gradient_agreement <= -threshold) return GreenAxis::kDown;
  return std::nullopt;
}

std::string describe(const VectorEncoding& encoding, const char* green_note) {
  return fmt::format("normal map, {}, {}green {}{}", encoding.is_signed ? "signed" : "unsigned",
                     encoding.rebuild_z ? "two channels (z rebuilt), " : "",
                     encoding.green == GreenAxis::kUp ? "up (OpenGL)" : "down (DirectX)", green_note);
}

}  // namespace

DetectedEncoding detect_encoding(const std::string& path, const RawImage& image, const NormalMapSettings& settings,
                                 int threads) {
  if (settings.bump_format == BumpFormat::kHeight)
    return height_field(image.planes.size() == 1 ? "as asked for" : "as asked for; the mean of the colour channels",
                        settings);
  if (image.planes.size() == 1 && settings.two_channel.value_or(false))
    throw Error(ErrorCode::kInput, fmt::format("{}: found {}: 1 colour channel, expected red and green, where a "
                                               "two-channel map has x and y",
                                               path, image.format));
  if (image.planes.size() == 1) {
    if (settings.bump_format == BumpFormat::kNormal)
      throw Error(ErrorCode::kInput, path + ": found 1 colour channel, expected a normal map of 2 or 3 as asked for");
    return grey_image(path, image, "1 channel", settings, threads);
  }
  if (settings.bump_format == BumpFormat::kAuto && is_grey(image, threads))
    return grey_image(path, image, "red, green and blue are equal", settings, threads);

  const Reading reading = best_reading(image, settings, threads);
  if (settings.bump_format == BumpFormat::kAuto) {
    if (const std::optional<std::string> why = refusal(reading))
      refuse_vectors(path, image, fmt::format("{} ({})", *why, summary(reading)));
  }
  DetectedEncoding result;
  result.vectors = reading.encoding;
  const std::optional<GreenAxis> found_green = green_from_gradients(reading.statistics);
  result.vectors.green = settings.green.value_or(found_green.value_or(GreenAxis::kUp));
  const char* green_note = settings.green.has_value() ? ", as asked for" : found_green.has_value() ? "" : ", undecided";
  result.description = describe(result.vectors, green_note);
  result.reason = summary(reading);
  const bool is_scaled = settings.height_scale != NormalMapSettings().height_scale;
  warn_of_ignored({{is_scaled, "--height-scale"}}, "a normal map", result.warnings);
  // Where nothing is tilted, green is 0 either way.
  if (!settings.green.has_value() && !found_green.has_value() && reading.statistics.tilted_share > 0.0)
    result.warnings.emplace_back(
        "which way green points cannot be told from the statistics; up (OpenGL) is taken, --green up or --green down "
        "says it");
  return result;
}

}  // namespace multum
