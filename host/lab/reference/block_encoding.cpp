// SPDX-License-Identifier: Apache-2.0
#include "host/lab/reference/block_encoding.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <random>
#include <vector>

#include "kernels/shared/block_encoding.h"

namespace multum::reference {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

double square(double x) { return x * x; }

// The texels of a line. Each texel has `channels` values.
struct LineTexels {
  int channels;
  std::vector<std::array<double, 3>> texels;
};

struct LineFormat {
  int bits;         // number of bits of a code
  bool has_p;       // whether one additional bit follows the code
  int p;            // value of this bit
  int index_count;  // number of indices: 4, 8 or 16
};

int decoded(int code, const LineFormat& format) {
  const int total = format.bits + (format.has_p ? 1 : 0), value = format.has_p ? 2 * code + format.p : code;
  int wide = value << (8 - total);
  if (total < 8) wide |= value >> (2 * total - 8);
  return wide;
}

using Codes = std::array<int, 6>;  // codes of both endpoints, channel by channel

// Chooses the best index for each texel.
double error_of(const LineTexels& line, const LineFormat& format, const Codes& codes) {
  std::array<std::array<int, 3>, 16> palette{};
  for (int i = 0; i < format.index_count; ++i) {
    const int weight = (128 * i + format.index_count - 1) / (2 * (format.index_count - 1));  // 64 i / (n - 1), rounded
    for (std::size_t c = 0; c < static_cast<std::size_t>(line.channels); ++c) {
      const int low = decoded(codes[2 * c], format), high = decoded(codes[2 * c + 1], format);
      palette[static_cast<std::size_t>(i)][c] = ((64 - weight) * low + weight * high + 32) / 64;
    }
  }
  double sum = 0.0;
  for (const auto& texel : line.texels) {
    double least = kNone;
    for (std::size_t i = 0; i < static_cast<std::size_t>(format.index_count); ++i) {
      double error = 0.0;
      for (std::size_t c = 0; c < static_cast<std::size_t>(line.channels); ++c)
        error += square(texel[c] - palette[i][c]);
      least = std::min(least, error);
    }
    sum += least;
  }
  return sum;
}

// Starts with two of the texels as endpoints, and changes the endpoints at random. Then descends in steps that change
// one code, or both codes of one channel.
double line_error(const LineTexels& line, const LineFormat& format, int start_count, std::mt19937& random) {
  if (line.texels.empty()) return 0.0;
  const int top = (1 << format.bits) - 1;
  double best = kNone;
  for (int start = 0; start < start_count; ++start) {
    Codes codes{};
    const auto any = [&] { return line.texels[random() % line.texels.size()]; };
    const std::array<double, 3> ends[2] = {any(), any()};
    for (std::size_t c = 0; c < static_cast<std::size_t>(line.channels); ++c)
      for (std::size_t e = 0; e < 2; ++e)
        codes[2 * c + e] = std::clamp(static_cast<int>(std::lround(ends[e][c] * top / 255.0)), 0, top);
    double error = error_of(line, format, codes);
    for (int step = std::max(1, top / 32); step >= 1; step /= 2) {
      for (bool is_better = true; is_better;) {
        is_better = false;
        for (std::size_t c = 0; c < static_cast<std::size_t>(line.channels); ++c)
          for (int move = 0; move < 9; ++move) {
            Codes tried = codes;
            tried[2 * c] = std::clamp(codes[2 * c] + (move / 3 - 1) * step, 0, top);
            tried[2 * c + 1] = std::clamp(codes[2 * c + 1] + (move % 3 - 1) * step, 0, top);
            const double moved = error_of(line, format, tried);
            if (moved >= error) continue;
            error = moved;
            codes = tried;
            is_better = true;
          }
      }
    }
    best = std::min(best, error);
  }
  return best;
}

LineTexels texels_of(const BlockColours& colours, unsigned mask) {
  LineTexels line{3, {}};
  for (std::size_t i = 0; i < 16; ++i)
    if ((mask >> i & 1u) != 0) line.texels.push_back({colours[0][i], colours[1][i], colours[2][i]});
  return line;
}

// Encodes one channel separately, and the other two channels together.
double separate_error(const BlockColours& colours, std::size_t alone, const LineFormat& pair, const LineFormat& one,
                      std::mt19937& random) {
  LineTexels two{2, {}}, single{1, {}};
  for (std::size_t i = 0; i < 16; ++i) {
    two.texels.push_back({colours[(alone + 1) % 3][i], colours[(alone + 2) % 3][i], 0.0});
    single.texels.push_back({colours[alone][i], 0.0, 0.0});
  }
  return line_error(two, pair, 24, random) + line_error(single, one, 24, random);
}

}  // namespace

double least_scalar_error(const BlockValues& values) {
  double least = kNone;
  for (int low = 0; low <= 255; ++low)
    for (int high = low; high <= 255; ++high)
      for (const int steps : {5, 7}) {
        double sum = 0.0;
        for (const double value : values) {
          double nearest = steps == 5 ? std::min(square(value), square(255.0 - value)) : kNone;
          for (int i = 0; i <= (high > low ? steps : 0); ++i)
            nearest = std::min(nearest, square(value - (low + static_cast<double>(high - low) * i / steps)));
          sum += nearest;
          if (sum >= least) break;
        }
        least = std::min(least, sum);
      }
  return least;
}

double colour_error_by_search(const BlockColours& colours) {
  constexpr unsigned kMasks[] = MULTUM_BC7_PARTITION_MASKS;
  std::mt19937 random(7);
  double best = line_error(texels_of(colours, 0xffff), {7, true, 1, 16}, 32, random);
  for (std::size_t alone = 0; alone < 3; ++alone) {
    best = std::min(best, separate_error(colours, alone, {7, false, 0, 4}, {8, false, 0, 4}, random));
    best = std::min(best, separate_error(colours, alone, {5, false, 0, 4}, {6, false, 0, 8}, random));
    best = std::min(best, separate_error(colours, alone, {5, false, 0, 8}, {6, false, 0, 4}, random));
  }
  for (const unsigned mask : kMasks) {
    double sum = 0.0;
    for (const unsigned own : {mask, ~mask & 0xffffu}) {
      double least = kNone;
      for (const int p : {0, 1})
        least = std::min(least, line_error(texels_of(colours, own), {6, true, p, 8}, 4, random));
      sum += least;
      if (sum >= best) break;
    }
    best = std::min(best, sum);
  }
  return best;
}

}  // namespace multum::reference
