// SPDX-License-Identifier: Apache-2.0
// Rules, in order. Each threshold lies between groups of real maps, whose values are in the comment next to the
// threshold. The test SharedData.EveryFileOfTheManifestIsUnderstood prints the values of every file.
//  1. One channel, or three channels that are equal up to compression noise, is a height field. (Measured: the noise is
//     up to 0.1 codes rms in 8 bits, and the greyest colour image has 2.5.) A grey gloss or albedo looks like a height,
//     so a warning says so. An image with one value has no information, and an image with two values is a mask; both
//     are rejected. Heights whose bytes are spread over channels are also recognised (packed_heights.h).
//  2. With two channels, or a constant blue that does not complete the vectors, z is rebuilt if x^2 + y^2 is at
//     most 1. A blue that equals the rounded z of nearly flat normals is kept, because both readings are then equal up
//     to rounding.
//  3. Floats are 0..1 or signed, depending on which reading gives unit vectors. Integers are 0..1.
//  4. z is blue itself, in 0..1, if only this reading gives unit length (`is_z_positive`).
//  5. The file is rejected if it does not look like normals (`refusal` below), or if blue is not z (`blue_doubt`).
//  6. The direction of green follows from the gradient agreement. It is up if the agreement is undecided.
// The caller's settings take precedence; a warning names the disagreement.
#include "host/formats/image/normals/encoding_detection.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "host/formats/image/files/number_type.h"
#include "host/formats/image/normals/packed_heights.h"
#include "host/formats/image/normals/vector_statistics.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/messages/option_words.h"

namespace multum {
namespace {

struct Reading {
  VectorEncoding encoding;
  VectorStatistics statistics;
  double signed_z_error = 0.0;  // for a positive z, the length error that z = 2 * blue - 1 would have
};

// Returns statistics from the survey. For encodings that the survey did not cover, reads the image again.
struct Evidence {
  const RawImage& image;
  const ImageSurvey& survey;
  int threads;

  const RawImageInfo& info() const { return image.info(); }
  VectorStatistics statistics(const VectorEncoding& encoding) const {
    const std::optional<VectorStatistics> surveyed = survey.statistics(encoding);
    return surveyed ? *surveyed : vector_statistics(image, encoding, threads);
  }
};

// Compression adds colours of up to one code of 8 bits. In files of more bits, larger differences between channels are
// not noise if they are as large as the differences between texels. Such values are short normals around mid-grey.
bool is_grey(const Evidence& evidence) { return is_grey_image(evidence.info(), evidence.survey); }

// Returns whether a finite value of the first channel differs by more than `margin` from both ends of its range. In
// most images, the first rows suffice to decide this.
bool has_value_between(const RawImage& image, const ImageSurvey::Range& range, double margin) {
  const auto channel_count = static_cast<std::size_t>(image.info().channel_count);
  RawRows rows;
  for (int row = 0; row < image.info().height; ++row) {
    image.read_rows(row, 1, rows);
    for (std::size_t i = 0; i < rows.values.size(); i += channel_count) {
      const auto v = static_cast<double>(rows.values[i]);
      if (v - static_cast<double>(range.low) > margin && static_cast<double>(range.high) - v > margin) return true;
    }
  }
  return false;
}

// Returns why a grey image is not a height field, or nullopt if it may be one. Rejects images with one or two finite
// values. Values count as one of the two if they differ from it by at most a fiftieth of the difference between the
// two, as in a mask with 8-bit compression.
std::optional<std::string> grey_refusal(const Evidence& evidence) {
  const ImageSurvey::Range range = evidence.survey.range(0);
  if (range.high < range.low) return "no value is finite";
  if (range.high == range.low)
    return fmt::format("every texel is {:.4g}, so the image holds no information", range.low);
  const double margin = 0.02 * (static_cast<double>(range.high) - static_cast<double>(range.low));
  if (has_value_between(evidence.image, range, margin)) return std::nullopt;
  return fmt::format("every texel is {:.4g} or {:.4g}, as in a mask", range.low, range.high);
}

// Returns whether all vectors around +Z have the same length, no matter how long they are. Such vectors are normals
// times a constant factor, which normalising removes.
bool has_one_length(const VectorStatistics& s) {
  constexpr double kSpreadMax = 0.05;
  return s.length_spread <= kSpreadMax && s.below_share <= 0.05 && s.mean_z >= 0.4 * s.length_mean &&
         std::hypot(s.mean_x, s.mean_y) <= 0.5 * s.mean_z;
}

// Rates how well a reading explains the values. Unit vectors rate best, followed by vectors that all have the same
// other length. A rebuilt z rates well if the vectors are possible and do not all lean to one side.
double plausibility(const Reading& reading) {
  const VectorStatistics& s = reading.statistics;
  if (s.texel_count == 0.0) return -1.0;
  if (!reading.encoding.rebuild_z) return std::max(s.unit_share_10, has_one_length(s) ? 0.5 - s.length_spread : 0.0);
  return 1.0 - s.beyond_share - std::hypot(s.mean_x, s.mean_y);
}

// Returns the possible encodings for a given use of blue. In a tie, the first one is chosen.
std::vector<VectorEncoding> signedness_candidates(SampleType sample_type, VectorEncoding encoding,
                                                  const NormalMapSettings& settings) {
  encoding.is_signed = settings.is_signed.value_or(false);
  std::vector<VectorEncoding> candidates = {encoding};
  const bool may_be_signed = is_float_type(sample_type) || sample_type == SampleType::kOtherInteger;
  if (settings.is_signed.has_value() || !may_be_signed) return candidates;
  encoding.is_signed = true;
  candidates.push_back(encoding);
  return candidates;
}

// Chooses unsigned or signed for a given use of blue. Chooses the more plausible reading, or unsigned in a tie.
Reading best_signedness(const Evidence& evidence, const VectorEncoding& encoding, const NormalMapSettings& settings) {
  std::optional<Reading> best;
  for (const VectorEncoding& candidate : signedness_candidates(evidence.info().sample_type, encoding, settings)) {
    const Reading reading{candidate, evidence.statistics(candidate)};
    if (!best || plausibility(reading) > plausibility(*best)) best = reading;
  }
  return *best;
}

// Returns the first encoding to try. Blue is z, unless there is no blue.
VectorEncoding first_encoding(const RawImageInfo& info, const NormalMapSettings& settings) {
  VectorEncoding encoding;
  encoding.flat_pair = info.sample_type == SampleType::kUint8;
  encoding.rebuild_z = settings.two_channel.value_or(info.channel_count == 2);
  encoding.positive_z = !encoding.rebuild_z && settings.z_range == ZRange::kPositive;
  return encoding;
}

// Returns whether blue is the same in every texel, up to compression noise. Blue also varies little if all vectors are
// short, which is possible in floats and 16 bits.
bool is_blue_constant(const Evidence& evidence, const VectorStatistics& s) {
  constexpr double kNoise = 2.5 / 255.0;
  const double range = s.blue_max - s.blue_min;
  const bool is_short = evidence.info().sample_type != SampleType::kUint8 && s.unit_share_20 < 0.5 && has_one_length(s);
  return range <= (is_short ? 0.0 : kNoise);
}

// Returns the largest difference between the z of unit vectors and a constant blue that rounding and compression can
// cause. With 8 bits, also if signed, it is 0.02. With half floats, it is two steps below 1.
double filler_noise(const RawImageInfo& info) {
  if (info.base_type == number_type::kUint8 || info.base_type == number_type::kInt8) return 2 * 2.5 / 255.0;
  return info.base_type == number_type::kHalf ? 1.0 / 512.0 : 2 * 2.5 / 65535.0;
}

// Returns whether a constant blue differs from the z of unit vectors by more than filler_noise(). Such a blue is
// filler, as in two-channel maps saved with three channels. A tilt of 11 degrees changes z by 0.02. At this tilt, (x,
// y, 1) and the rebuilt vector differ by 0.2 degrees, half a code of 8 bits. For flat maps, both readings are flat.
bool is_blue_filler(const Evidence& evidence, const Reading& reading) {
  const VectorStatistics& s = reading.statistics;
  if (s.tilted_share == 0.0) return false;
  const double noise = filler_noise(evidence.info());
  const auto z_of = [&](double blue) { return reading.encoding.is_signed ? blue : 2.0 * blue - 1.0; };
  return s.rebuilt_z_min < z_of(s.blue_min) - noise || s.rebuilt_z_mean > z_of(s.blue_max) + noise;
}

// Old tools and some models store z in 0..1. If their z is read as 2 * blue - 1, tilts are too large: by 0.6 degrees at
// a tilt of 16 degrees, by 8 at 36, and by 30 at 60. If such files are read as positive, the measured length error is
// 0.0012 to 0.002 in 8 bits, and 0.01 to 0.02 after JPEG. If the choice matters, the error of the other reading is at
// least three times as large. Blurring or compression also shortens normals. The most similar real maps of this kind
// have an error of 0.020 and a ratio of 2.4, or an error of 0.023 and a ratio of 4.5. Of 636 real maps, one (a picture
// frame) has an error of 0.005 and a ratio of 5. That map does store z in 0..1.
bool is_z_positive(const Evidence& evidence, const Reading& reading, const NormalMapSettings& settings) {
  constexpr double kExact = 0.012, kExactRatio = 3.0, kCompressed = 0.03, kCompressedRatio = 6.0;
  const VectorStatistics& s = reading.statistics;
  if (settings.z_range || reading.encoding.is_signed || reading.encoding.rebuild_z) return false;
  // Half a step of 8 bits in x, y and z causes an error of 0.0023. The error is three times as large if 1 is stored as
  // code 254.
  const double least = evidence.info().sample_type == SampleType::kUint8 ? 0.007 : 0.0005;
  if (s.length_error < least) return false;
  const double ratio = s.length_error / std::max(1e-9, s.positive_length_error);
  return (s.positive_length_error <= kExact && ratio >= kExactRatio) ||
         (s.positive_length_error <= kCompressed && ratio >= kCompressedRatio);
}

Reading best_reading(const Evidence& evidence, const NormalMapSettings& settings) {
  VectorEncoding encoding = first_encoding(evidence.info(), settings);
  const Reading first = best_signedness(evidence, encoding, settings);
  if (settings.two_channel.value_or(false) || evidence.info().channel_count == 2) return first;
  if (is_z_positive(evidence, first, settings)) {
    encoding = first.encoding;
    encoding.positive_z = true;
    return {encoding, evidence.statistics(encoding), first.statistics.length_error};
  }
  if (!is_blue_constant(evidence, first.statistics)) return first;
  if (settings.two_channel.has_value() || settings.z_range) return first;
  if (first.statistics.unit_share_10 >= 0.8 && !is_blue_filler(evidence, first)) return first;
  encoding.rebuild_z = true;
  const Reading rebuilt = best_signedness(evidence, encoding, settings);
  // If x^2 + y^2 > 1, the rebuilt vectors are (x, y, 1), without unit length, so blue must be z.
  return rebuilt.statistics.beyond_share <= 0.005 ? rebuilt : first;
}

std::string summary(const Reading& reading) {
  const VectorStatistics& s = reading.statistics;
  if (reading.encoding.rebuild_z)
    return fmt::format(
        "x^2 + y^2 <= 1 in {:.1f} % of the texels, mean (x, y) ({:+.2f}, {:+.2f}), mean rebuilt z {:.2f}, gradient "
        "agreement {:+.2f}",
        100.0 * (1.0 - s.beyond_share), s.mean_x, s.mean_y, s.rebuilt_z_mean, s.gradient_agreement);
  return fmt::format(
      "length within 10 % of 1 in {:.1f} % of the texels, mean vector ({:+.2f}, {:+.2f}, {:+.2f}), {:.1f} % below the "
      "horizon, gradient agreement {:+.2f}",
      100.0 * s.unit_share_10, s.mean_x, s.mean_y, s.mean_z, 100.0 * s.below_share, s.gradient_agreement);
}

// Returns why (x, y) with a rebuilt z are not normals. Flow maps look similar, because they hold directions of length
// up to 1 with an empty blue channel. But they lack the gradients of a surface and are far from flat (measured:
// agreement 0.00, rebuilt z 0.67).
std::optional<std::string> two_channel_refusal(const VectorStatistics& s) {
  if (s.beyond_share > 0.005) return fmt::format("x^2 + y^2 exceeds 1 in {:.1f} % of texels", 100.0 * s.beyond_share);
  if (std::hypot(s.mean_x, s.mean_y) > 0.5 * s.rebuilt_z_mean) return "the mean vector is tilted to one side";
  if (s.tilted_share > 0.05 && s.negative_share < 0.01) return "red and green contain no negative values";
  if (std::abs(s.gradient_agreement) < 0.15 && s.rebuilt_z_mean < 0.85)
    return "red and green are not the slopes of a surface";
  return std::nullopt;
}

// Returns why vectors (x, y, z) are not normals, or nullopt if they are. Normals need
//   below the horizon <= 5 %            normal maps reach 1 % (gutters of an atlas), colours start at 9 %
//   |mean xy| <= 0.5 mean z, z >= 0.4   normal maps 0.27 and 0.61, sky blue (135, 206, 235) 0.74; not required of
//                                       vectors of unit length
//   and one of: unit within 10 % on 80 %; within 20 % on 60 % with blue or gradients agreeing; gradients agreeing
//   strongly (maps of vectors without unit length)
std::optional<std::string> vector_refusal(const VectorStatistics& s) {
  if (s.below_share > 0.05) {
    const char* object_space = s.unit_share_10 >= 0.9 ? ", as in an object-space normal map" : "";
    return fmt::format("{:.1f} % of the normals point below the surface{}", 100.0 * s.below_share, object_space);
  }
  const double agreement = std::abs(s.gradient_agreement);
  if (s.unit_share_5 >= 0.95 && s.mean_z >= 0.1) return std::nullopt;
  // These vectors are normals times a constant factor. In a picture of low contrast, the colour vectors also have
  // nearly equal lengths, but they are not gradients.
  if (has_one_length(s) && agreement >= 0.25) return std::nullopt;
  if (s.length_mean < 0.4)
    return fmt::format(
        "vectors have a mean length of {:.3g}, expected 1; their lengths differ, and they are not clearly the slopes "
        "of a surface (scale them to unit length)",
        s.length_mean);
  if (s.mean_z < 0.4 || std::hypot(s.mean_x, s.mean_y) > 0.5 * s.mean_z) return "the mean vector is tilted to one side";
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

// Returns the share of texels for which is_empty() holds.
double empty_share(const Evidence& evidence, const Reading& reading) {
  const bool is_zero_empty = reading.encoding.is_signed && !reading.encoding.rebuild_z;
  const std::int64_t count =
      evidence.survey.all_nan_count() + (is_zero_empty ? evidence.survey.all_zero_count() : std::int64_t{0});
  return static_cast<double>(count) / (static_cast<double>(evidence.info().width) * evidence.info().height);
}

// Detects a constant red channel in a file with alpha. Some compressed formats store alpha more precisely than colours,
// so normal maps in these formats store x in alpha (DXT5nm).
bool has_x_in_alpha(const Evidence& evidence) {
  if (!evidence.info().has_alpha || evidence.info().channel_count < 3) return false;
  const auto spread = [&evidence](int channel) {
    const ImageSurvey::Range range = evidence.survey.range(channel);
    return static_cast<double>(range.high) - static_cast<double>(range.low);
  };
  constexpr double kNoise = 2.5 / 255.0;
  return spread(0) <= kNoise && spread(1) > kNoise;
}

// Returns whether x and y are plausible when z is ignored. Two conditions must hold: the slopes agree with a surface,
// and x^2 + y^2 leaves room for z.
bool is_two_channel_plausible(const Evidence& evidence, const Reading& reading) {
  if (reading.encoding.rebuild_z || evidence.info().channel_count < 3) return false;
  VectorEncoding encoding = reading.encoding;
  encoding.rebuild_z = true;
  encoding.positive_z = false;
  const VectorStatistics s = evidence.statistics(encoding);
  return s.texel_count > 0.0 && !two_channel_refusal(s) && std::abs(s.gradient_agreement) >= 0.25;
}

// Returns how doubtful it is that blue is the z of red and green. LabPBR packs, for example, store another map in blue
// (occlusion, smoothness, height). Lengths then scatter at every scale, and the tilt explains little of blue. Three
// values were measured: the share of unit lengths, the dependence of z on the tilt, and the spread of lengths of 4 x 4
// texels. In 12 lossy maps, these are 0.23 to 0.75, 0.11 to 0.86, and 0.02 to 0.11. From 25 real maps, 109 maps were
// made with occlusion, gloss or height in blue. Half of them have a dependence below 0.26 and a spread above 0.11. An
// occlusion computed from the same surface depends on the tilt by up to 0.8, as in some antialiased maps; such maps get
// a warning. `turn` is the difference of the two readings in degrees rms. If it is small, there is no doubt.
enum class BlueDoubt { kNone, kWarned, kRefused };
BlueDoubt blue_doubt(const Evidence& evidence, const Reading& reading) {
  const VectorStatistics& s = reading.statistics;
  if (reading.encoding.rebuild_z || reading.encoding.positive_z || s.beyond_share > 0.005) return BlueDoubt::kNone;
  if (has_one_length(s) || is_blue_constant(evidence, s)) return BlueDoubt::kNone;
  const double turn = s.rebuilt_angle, spread = s.block_length_spread;
  if (s.unit_share_10 < 0.7 && s.z_dependence < 0.26 && spread > 0.1 && turn > 1.5) return BlueDoubt::kRefused;
  if (s.unit_share_10 < 0.85 && s.z_dependence < 0.5 && spread > 0.13 && turn > 3.0) return BlueDoubt::kRefused;
  if (s.unit_share_10 < 0.7 && spread > 0.125 && turn > 2.0) return BlueDoubt::kWarned;
  return BlueDoubt::kNone;
}

std::string blue_doubt_text(const VectorStatistics& s) {
  return fmt::format(
      "blue does not depend on red and green as z would: lengths scatter by {:.0f} % around {:.2f}, the tilt explains "
      "{:.0f} % of the variance of blue, and z from red and green differs by {:.1f} degrees rms; blue may hold "
      "occlusion, smoothness or height",
      100.0 * s.block_length_spread, s.length_mean, 100.0 * s.z_dependence * s.z_dependence, s.rebuilt_angle);
}

// Throws or warns, unless the settings define the meaning of blue.
void check_blue(const std::string& path, const Evidence& evidence, const Reading& reading,
                const NormalMapSettings& settings, std::vector<std::string>& warnings) {
  if (settings.z_range) return;
  const BlueDoubt doubt = blue_doubt(evidence, reading);
  if (doubt == BlueDoubt::kNone) return;
  const std::string text = blue_doubt_text(reading.statistics);
  const std::string advised =
      advice(". Use <two_channel> to read only red and green") + advice(", or <z_range signed> to use blue as z");
  const bool is_refusing = settings.bump_format == BumpFormat::kAuto || settings.refuse_doubts;
  if (doubt == BlueDoubt::kRefused && is_refusing)
    throw Error(ErrorCode::kInput, fmt::format("{}: {}; expected the z of unit vectors{}", path, text, advised));
  warnings.push_back(text + advised);
}

// For a map with x in alpha, --bumpformat cannot help, because alpha is not read. Therefore the message does not
// recommend this option.
[[noreturn]] void refuse_vectors(const std::string& path, const Evidence& evidence, const Reading& reading,
                                 const std::string& why) {
  if (has_x_in_alpha(evidence))
    throw Error(ErrorCode::kInput,
                path +
                    ": found a constant red and an alpha, as in a map with x in alpha (DXT5nm), expected x in red "
                    "and y in green: move alpha to red (oiiotool --no-autopremult IN --ch R=A,G,B=1.0 -o OUT)");
  throw Error(ErrorCode::kInput,
              fmt::format("{}: found neither a normal map nor a height field: {}; expected unit vectors around +Z, or "
                          "grey{}{}",
                          path, why,
                          is_two_channel_plausible(evidence, reading)
                              ? advice(". If blue is not z (occlusion, smoothness, height), use <two_channel>: red and "
                                       "green are the slopes of a surface")
                              : "",
                          advice(". If it is one of these, use <bumpformat normal> or <bumpformat height>")));
}

// Warns about given options that do not apply to this kind of file.
void warn_of_ignored(const std::vector<std::pair<bool, const char*>>& given, const char* what,
                     std::vector<std::string>& warnings) {
  std::vector<std::string> names;
  for (const auto& [is_given, name] : given)
    if (is_given) names.emplace_back(name);
  if (!names.empty())
    warnings.push_back(fmt::format("these settings have no effect on {}", what) + names_as_advice(names));
}

DetectedEncoding height_field(const std::string& reason, const HeightReading& reading,
                              const NormalMapSettings& settings) {
  DetectedEncoding result;
  result.is_height_field = true;
  result.heights = reading;
  result.reason = reason;
  const bool is_signed = settings.is_signed.value_or(false);
  warn_of_ignored({{settings.green.has_value(), "green"},
                   {is_signed, "signed"},
                   {settings.is_signed.has_value() && !is_signed, "unsigned"},
                   {settings.two_channel.has_value(), "two_channel"},
                   {settings.z_range.has_value(), "z_range"},
                   {settings.normal_scale != 1.0f, "normal_scale"}},
                  "a height field", result.warnings);
  return result;
}

DetectedEncoding grey_image(const std::string& path, const Evidence& evidence, const std::string& reason,
                            const NormalMapSettings& settings) {
  if (const std::optional<std::string> why = grey_refusal(evidence))
    throw Error(ErrorCode::kInput,
                fmt::format("{}: found a grey image that is not a height field: {}; expected heights of more than two "
                            "values{}",
                            path, *why, advice(". If it is a height field, use <bumpformat height>")));
  return height_field(reason + "; a grey gloss, mask or albedo looks like a height field",
                      {HeightCoding::kGrey, evidence.survey.no_data()}, settings);
}

// Returns the requested coding.
std::optional<HeightCoding> coding_of(BumpFormat format) {
  switch (format) {
    case BumpFormat::kPacked16: return HeightCoding::kPacked16;
    case BumpFormat::kPacked24: return HeightCoding::kPacked24;
    case BumpFormat::kTerrarium: return HeightCoding::kTerrarium;
    case BumpFormat::kMapbox: return HeightCoding::kMapbox;
    default: return std::nullopt;
  }
}

DetectedEncoding packed_heights(const std::string& path, const Evidence& evidence, HeightCoding coding,
                                const NormalMapSettings& settings) {
  const int channel_count = coding == HeightCoding::kPacked16 ? 2 : 3;
  if (evidence.info().base_type != number_type::kUint8 || evidence.info().channel_count < channel_count)
    throw Error(ErrorCode::kInput, fmt::format("{}: found {}, expected {} channels of 8 bits for {}", path,
                                               evidence.info().format, channel_count, height_coding_name(coding)));
  return height_field(
      coding_of(settings.bump_format)
          ? height_coding_name(coding) + ", as requested"
          : height_coding_name(coding) + ": the heights are continuous, but the single channels contain jumps",
      {coding, std::nullopt}, settings);
}

// Reads the file as a height field, as the settings request.
DetectedEncoding asked_heights(const std::string& path, const Evidence& evidence, const NormalMapSettings& settings) {
  if (is_grey(evidence))
    return height_field(evidence.info().channel_count == 1
                            ? "as requested"
                            : "as requested; each height is the mean of equal colour channels",
                        {HeightCoding::kGrey, evidence.survey.no_data()}, settings);
  if (const std::optional<HeightCoding> packed = find_packed_heights(evidence.image))
    return packed_heights(path, evidence, *packed, settings);
  throw Error(
      ErrorCode::kInput,
      fmt::format(
          "{}: found colours, whose channels differ by {:.3g} of their {} (rms), expected heights as requested: one "
          "channel, or equal channels. Save the channel with the heights as grey (oiiotool IN --ch R -o OUT){}",
          path, evidence.survey.chroma_rms(), is_float_type(evidence.info().sample_type) ? "values" : "range",
          advice("; if the bytes of heights are spread over the channels, use <bumpformat packed16>, packed24, "
                 "terrarium or mapbox")));
}

// The threshold separates two groups of maps (vector_statistics.cpp). Maps with known green reach at least 0.31, and
// other maps reach at most 0.15. With few samples, it is four standard deviations of the correlation of independent
// samples.
std::optional<GreenAxis> green_from_gradients(const VectorStatistics& s) {
  const double threshold = std::max(0.25, 4.0 / std::sqrt(std::max(1.0, s.gradient_sample_count)));
  if (s.gradient_agreement >= threshold) return GreenAxis::kUp;
  if (s.gradient_agreement <= -threshold) return GreenAxis::kDown;
  return std::nullopt;
}

const char* green_name(GreenAxis green) { return green == GreenAxis::kUp ? "up (OpenGL)" : "down (DirectX)"; }

// Warns if the vectors are normals times a constant factor. They are normalised, but a file with other contents would
// be normalised too.
void warn_of_length(const Reading& reading, std::vector<std::string>& warnings) {
  const VectorStatistics& s = reading.statistics;
  if (reading.encoding.rebuild_z || s.unit_share_20 >= 0.5 || !has_one_length(s)) return;
  warnings.push_back(fmt::format(
      "all its vectors have a length of {:.3g} instead of 1, so they are read as scaled normals and normalised",
      s.length_mean));
}

// Warns if the direction of green is unknown, or if the settings contradict the statistics. A green channel with the
// wrong sign turns bumps into dents along y.
void warn_of_green(const NormalMapSettings& settings, std::optional<GreenAxis> found, const VectorStatistics& s,
                   std::vector<std::string>& warnings) {
  if (!settings.green && !found) {
    // If no texel is tilted, green is 0 for both directions.
    if (s.tilted_share > 0.0)
      warnings.emplace_back("the statistics do not show the direction of green, so it is assumed to point up (OpenGL)" +
                            advice(", <green up> or <green down> sets it"));
  } else if (settings.green && found && *settings.green != *found) {
    warnings.push_back(
        fmt::format("green was set to {}, but red and green are the slopes of a surface only if green points {} "
                    "(gradient agreement {:+.2f}){}",
                    green_name(*settings.green), green_name(*found), s.gradient_agreement,
                    advice(fmt::format(": remove the setting or use <green {}> unless you are sure",
                                       choice_name(kGreenAxes, *found)))));
  }
}

std::string describe(const VectorEncoding& encoding, const char* green_note) {
  return fmt::format("normal map, {}, {}green {}{}", encoding.is_signed ? "signed" : "unsigned",
                     encoding.rebuild_z    ? "two channels (z rebuilt), "
                     : encoding.positive_z ? "z from 0 to 1, "
                                           : "",
                     green_name(encoding.green), green_note);
}

// Warns if the direction of green in a set of tiles differs from the direction found in this map.
void warn_of_set(std::optional<GreenAxis> own, std::optional<GreenAxis> of_set, std::vector<std::string>& warnings) {
  if (!own || !of_set || *own == *of_set) return;
  warnings.push_back(
      fmt::format("green is read as {} in all tiles, because the first tile with a clear direction says so, but the "
                  "slopes in this tile show that green points {}{}",
                  green_name(*of_set), green_name(*own), advice(": <green up> or <green down> sets it for all tiles")));
}

}  // namespace

bool is_grey_image(const RawImageInfo& info, const ImageSurvey& survey) {
  constexpr double kChromaMax = 1.0 / 255.0, kChromaOfContrastMax = 0.25;
  if (info.channel_count < 2) return true;
  const double chroma = survey.chroma_rms();
  if (chroma == 0.0) return true;
  if (info.sample_type != SampleType::kUint8 && chroma > kChromaOfContrastMax * survey.grey_deviation()) return false;
  return chroma <= kChromaMax;
}

std::vector<VectorEncoding> likely_encodings(const RawImageInfo& info, const NormalMapSettings& settings) {
  const bool are_heights = settings.bump_format != BumpFormat::kAuto && settings.bump_format != BumpFormat::kNormal;
  if (are_heights || info.channel_count == 1) return {};
  return signedness_candidates(info.sample_type, first_encoding(info, settings), settings);
}

DetectedEncoding detect_encoding(const std::string& path, const RawImage& image, const ImageSurvey& survey,
                                 const NormalMapSettings& settings, int threads, const GreenOfSet& green_of_set) {
  const Evidence evidence{image, survey, threads};
  const int channel_count = image.info().channel_count;
  if (settings.bump_format == BumpFormat::kHeight) return asked_heights(path, evidence, settings);
  if (const std::optional<HeightCoding> coding = coding_of(settings.bump_format))
    return packed_heights(path, evidence, *coding, settings);
  if (channel_count == 1 && settings.two_channel.value_or(false))
    throw Error(
        ErrorCode::kInput,
        fmt::format(
            "{}: found {} with 1 colour channel, expected red and green, which hold x and y of a two-channel map", path,
            image.info().format));
  if (channel_count == 1) {
    if (settings.bump_format == BumpFormat::kNormal)
      throw Error(ErrorCode::kInput,
                  path + ": found 1 colour channel, expected a normal map with 2 or 3 channels as requested");
    return grey_image(path, evidence, "1 channel", settings);
  }
  if (settings.bump_format == BumpFormat::kAuto) {
    if (channel_count == 3 && is_grey(evidence))
      return grey_image(path, evidence, "red, green and blue are equal", settings);
    if (const std::optional<HeightCoding> packed = find_packed_heights(image))
      return packed_heights(path, evidence, *packed, settings);
  }
  if (settings.refuse_doubts && is_grey(evidence))
    throw Error(ErrorCode::kInput, path + ": found a grey image, expected a normal map");

  const Reading reading = best_reading(evidence, settings);
  if (settings.bump_format == BumpFormat::kAuto) {
    if (const std::optional<std::string> why = refusal(reading))
      refuse_vectors(path, evidence, reading, fmt::format("{} ({})", *why, summary(reading)));
  }
  DetectedEncoding result;
  check_blue(path, evidence, reading, settings, result.warnings);
  result.vectors = reading.encoding;
  result.vectors.empty_is_unused = empty_share(evidence, reading) > kUnusedShareNoted;
  const std::optional<GreenAxis> own_green = green_from_gradients(reading.statistics);
  const bool asks_set = green_of_set && !settings.green;
  const std::optional<GreenAxis> found_green = asks_set ? green_of_set(own_green) : own_green;
  result.vectors.green = settings.green.value_or(found_green.value_or(GreenAxis::kUp));
  const char* green_note = settings.green.has_value()             ? ", as requested"
                           : !found_green.has_value()             ? ", undecided"
                           : asks_set && found_green != own_green ? ", as in its set"
                                                                  : "";
  result.description = describe(result.vectors, green_note);
  result.reason = summary(reading);
  result.vectors.tilt = settings.normal_scale;
  if (settings.normal_scale != 1.0f) result.description += fmt::format(", scaled by {:g}", settings.normal_scale);
  const bool is_scaled = settings.height_scale != NormalMapSettings().height_scale;
  warn_of_ignored({{is_scaled, "height_scale"}, {settings.dequantize, "dequantize"}}, "a normal map", result.warnings);
  if (reading.encoding.rebuild_z && channel_count > 2 && !settings.two_channel)
    result.reason +=
        fmt::format(", blue is {:.3g} everywhere, which is not the z of unit vectors", reading.statistics.blue_min);
  if (reading.signed_z_error > 0.0)
    result.reason += fmt::format(
        ", lengths are within {:.2g} % of 1 (rms of tilted texels) if blue is z, and within {:.2g} % if z is 2 * blue "
        "- 1",
        100.0 * reading.statistics.length_error, 100.0 * reading.signed_z_error);
  warn_of_length(reading, result.warnings);
  warn_of_green(settings, found_green, reading.statistics, result.warnings);
  if (asks_set) warn_of_set(own_green, found_green, result.warnings);
  return result;
}

}  // namespace multum
