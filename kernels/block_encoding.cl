// SPDX-License-Identifier: Apache-2.0
// Encodes blocks of 4 x 4 texels as BC4 and BC7 (Khronos Data Format Specification 1.3, chapters 18 and 20). Searches
// for the codes with the least sum of squared differences. BC5 is two blocks of BC4.
//
// BC4 stores two endpoints of 8 bits, and one index of 3 bits per texel. An index selects one of eight values from
// endpoint to endpoint, or one of six such values and the constants 0 and 1. The search begins with the best of several
// pairs of endpoints, and moves these endpoints by ever smaller steps until no neighbouring pair has a lower error. In
// BC7, every block has its own mode. Mode 6, which has one line through the colours with 16 steps, is tried first. The
// search stops if the error of mode 6 is at most the error of rounding to 8 bits. Otherwise the kernel also tries a
// separate channel (modes 4 and 5, by rotation) and two lines (mode 1). A line is first placed along the texels'
// principal axis, and then fitted by least squares to the indices of the texels. Finally, the codes of the best line
// are improved one by one. Modes with three lines are not used. Alpha is 255. If the third channel is stored as alpha,
// blue is 255, and modes 4, 5 and 6 swap blue and alpha.
//
// Values range from 0 to 255 and are not rounded. On every device, the texels of a block are the lanes of a vector.

#include "device/numerics.clh"
#include "shared/block_encoding.h"

#ifdef __clang__
#pragma clang diagnostic ignored "-Wpsabi"  // wide vectors are safe as arguments, because all functions here are
                                            // inlined
#endif

// The expected sum of squared differences if the 48 values of a block are rounded to 8 bits. This is 48 / 12.
#define ROUNDING_ERROR 4.0f

static inline float sum_of(float16 v) {
  const float8 a = v.lo + v.hi;
  const float4 b = a.lo + a.hi;
  return (b.x + b.y) + (b.z + b.w);
}

static inline float least_of(float16 v) {
  const float8 a = fmin(v.lo, v.hi);
  const float4 b = fmin(a.lo, a.hi);
  return fmin(fmin(b.x, b.y), fmin(b.z, b.w));
}

static inline float most_of(float16 v) { return -least_of(-v); }

// The bits of a block, starting at the lowest bit of the first word.
typedef struct BlockBits {
  uint words[4];
  int at;
} BlockBits;

static inline void put_bits(BlockBits* bits, uint value, int count) {
  const int word = bits->at >> 5, shift = bits->at & 31;
  bits->words[word] |= value << shift;
  if (shift + count > 32) bits->words[word + 1] |= value >> (32 - shift);
  bits->at += count;
}

// ------------------------------------------------------------------------------------------------------------ BC4

// Two endpoints, which are whole numbers from 0 to 255, with low <= high. If `has_limits`, there are six values from
// low to high, plus 0 and 255.
typedef struct ScalarEnds {
  float low, high, error;
} ScalarEnds;

// Returns the number of the nearest step from low to high for each value. There are steps 0 to 5, or 0 to 7.
static inline float16 scalar_steps(float16 v, float low, float high, float step_count) {
  const float scale = high > low ? step_count / (high - low) : 0.0f;
  return rint(clamp((v - low) * scale, 0.0f, step_count));
}

static inline float scalar_error(float16 v, float low, float high, int has_limits) {
  const float step_count = has_limits ? 5.0f : 7.0f;
  const float16 d =
      v - fma(scalar_steps(v, low, high, step_count), (float16)((high - low) / step_count), (float16)(low));
  float16 square = d * d;
  if (has_limits) square = fmin(square, fmin(v * v, (255.0f - v) * (255.0f - v)));
  return sum_of(square);
}

static inline void try_ends(float16 v, float low, float high, int has_limits, ScalarEnds* best) {
  low = clamp(rint(low), 0.0f, 255.0f);
  high = clamp(rint(high), 0.0f, 255.0f);
  // The order of the endpoints tells the decoder whether there are eight or six values, so eight values need two
  // different endpoints.
  if (low > high || (low == high && !has_limits)) return;
  const float error = scalar_error(v, low, high, has_limits);
  if (error < best->error) {
    best->low = low;
    best->high = high;
    best->error = error;
  }
}

// Fits the endpoints by least squares to the texels' current steps. Only texels with weight 1 count. All others have
// weight 0.
static inline void fit_ends(float16 v, float16 weight, float* low, float* high, float step_count) {
  const float16 u = scalar_steps(v, *low, *high, step_count) / step_count;
  const float count = sum_of(weight), mean_u = sum_of(weight * u) / fmax(count, 1.0f);
  const float mean_v = sum_of(weight * v) / fmax(count, 1.0f);
  const float16 du = u - mean_u;
  const float spread = sum_of(weight * du * du);
  if (spread < 1e-6f) return;
  const float slope = sum_of(weight * du * (v - mean_v)) / spread;
  *low = mean_v - mean_u * slope;
  *high = *low + slope;
}

// Moves one endpoint, or both, by `step` as long as the error decreases.
static inline void climb(float16 v, float step, int has_limits, ScalarEnds* best) {
  for (int turn = 0; turn < 32; ++turn) {
    const ScalarEnds from = *best;
    for (int move = 0; move < 9; ++move)
      if (move != 4)
        try_ends(v, fma(step, (float)(move / 3 - 1), from.low), fma(step, (float)(move % 3 - 1), from.high), has_limits,
                 best);
    if (best->error >= from.error) return;
  }
}

static inline ScalarEnds scalar_ends(float16 v, int has_limits) {
  // Values at the limits use the codes for 0 and 255, and are left out of the fit.
  const float16 weight = has_limits ? select((float16)(1.0f), (float16)(0.0f),
                                             isless(v, (float16)(4.0f)) | isgreater(v, (float16)(251.0f)))
                                    : (float16)(1.0f);
  const float16 inside = select(v, (float16)(clamp(sum_of(weight * v) / fmax(sum_of(weight), 1.0f), 0.0f, 255.0f)),
                                isequal(weight, (float16)(0.0f)));
  const float least = least_of(inside), most = most_of(inside), step_count = has_limits ? 5.0f : 7.0f;
  ScalarEnds best = {0.0f, 255.0f, scalar_error(v, 0.0f, 255.0f, has_limits)};
  try_ends(v, floor(least), ceil(most), has_limits, &best);
  try_ends(v, floor(least), floor(least) + 1.0f, has_limits, &best);
  // Tries ranges that leave out up to one step at either end, and fits each range twice.
  for (int start = 0; start < 9; ++start) {
    const float margin = (most - least) / (2.0f * step_count);
    float low = fma(margin, (float)(start / 3), least), high = fma(-margin, (float)(start % 3), most);
    for (int turn = 0; turn < 2; ++turn) {
      fit_ends(v, weight, &low, &high, step_count);
      try_ends(v, low, high, has_limits, &best);
    }
  }
  for (float step = 8.0f; step >= 1.0f; step *= 0.5f) climb(v, step, has_limits, &best);
  return best;
}

// One work-item handles one block.
//   values [block][16]   0 to 255
//   blocks [block]       written
// The kernel is compute bound. It evaluates a block's error some 200 times.
__kernel void encode_scalar_blocks(__global const float* values, __global uint2* blocks, int block_count) {
  const int item = (int)get_global_id(0);
  if (item >= block_count) return;
  const float16 v = vload16(item, values);
  ScalarEnds ends = scalar_ends(v, 0);
  int has_limits = 0;
  if (ends.error > 0.0f) {
    const ScalarEnds other = scalar_ends(v, 1);
    has_limits = other.error < ends.error;
    if (has_limits) ends = other;
  }
  const float step_count = has_limits ? 5.0f : 7.0f;
  const float16 step = scalar_steps(v, ends.low, ends.high, step_count);
  const float16 d = v - fma(step, (float16)((ends.high - ends.low) / step_count), (float16)(ends.low));
  float steps[16], squares[16], texels[16];
  vstore16(step, 0, steps);
  vstore16(d * d, 0, squares);
  vstore16(v, 0, texels);
  BlockBits bits = {{0, 0, 0, 0}, 0};
  // With eight values, the first endpoint is the higher one. With six values, it is the lower one. Indices count from
  // the first endpoint.
  put_bits(&bits, (uint)(has_limits ? ends.low : ends.high), 8);
  put_bits(&bits, (uint)(has_limits ? ends.high : ends.low), 8);
  for (int i = 0; i < MULTUM_BLOCK_TEXELS; ++i) {
    const int last = (int)step_count, from_first = has_limits ? (int)steps[i] : last - (int)steps[i];
    int index = from_first == 0 ? 0 : from_first == last ? 1 : from_first + 1;
    if (has_limits) {
      const float below = texels[i] * texels[i], above = (255.0f - texels[i]) * (255.0f - texels[i]);
      if (fmin(below, above) < squares[i]) index = below < above ? 6 : 7;
    }
    put_bits(&bits, (uint)index, 3);
  }
  blocks[item] = (uint2)(bits.words[0], bits.words[1]);
}

// ------------------------------------------------------------------------------------------------------------ BC7

// The texels of a block, given by the address of their channel values, a mask of the texels that count (one bit each),
// and the channel that is replaced by 255 (-1 if there is none). Values are read again at each use, so that registers
// stay free for other data.
typedef struct Colours {
  __global const float* values;
  uint mask;
  int without;
} Colours;

static inline float16 channel_of(Colours c, int channel) {
  return channel == c.without ? (float16)(255.0f) : vload16(channel, c.values);
}

// Returns 1 for texels in the mask and 0 for the others.
static inline float16 subset_weight(uint mask) {
  const int16 lanes = (int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  return convert_float16(((int16)((int)mask) >> lanes) & 1);
}

// The storage of an endpoint's channels. It has `bits` per channel and, if has_p, one more low bit p that all three
// channels share.
typedef struct EndPrecision {
  int bits, has_p;
} EndPrecision;

// A line, given by the codes of both endpoints per channel, without the p bits, and the error that these codes give.
typedef struct CodedLine {
  int codes[2][3];
  int p[2];
  float error;
} CodedLine;

// Expands a code to 8 bits, which are its own bits, followed by a copy of its highest bits.
static inline float decoded(int code, int p, EndPrecision precision) {
  const int total = precision.bits + precision.has_p, value = precision.has_p ? code << 1 | p : code;
  return (float)(value << (8 - total) | value >> (2 * total - 8));
}

static inline int nearest_code(float value, int p, EndPrecision precision) {
  const int total = precision.bits + precision.has_p;
  const float exact = clamp(value, 0.0f, 255.0f) * (float)((1 << total) - 1) / 255.0f;
  const float code = precision.has_p ? 0.5f * (exact - (float)p) : exact;
  return clamp((int)rint(code), 0, (1 << precision.bits) - 1);
}

// Returns the weight of an index of 2, 3 or 4 bits, in 64ths of the way from end to end.
static inline float16 index_weight(float16 index, float last) { return rint(index * (64.0f / last)); }

static inline float16 interpolated(float low, float high, float16 weight) {
  return floor(fma((float16)(high - low), weight, (float16)(64.0f * low + 32.0f)) * (1.0f / 64.0f));
}

static inline float16 line_indices(Colours c, float4 low, float4 high, float last) {
  const float4 d = high - low;
  const float square = dot(d, d);
  const float scale = square > 0.0f ? last / square : 0.0f;
  float16 along = (channel_of(c, 0) - low.x) * d.x;
  along = fma(channel_of(c, 1) - low.y, (float16)(d.y), along);
  along = fma(channel_of(c, 2) - low.z, (float16)(d.z), along);
  return rint(clamp(along * scale, 0.0f, last));
}

static inline float4 line_end(const CodedLine* line, int end, EndPrecision precision) {
  return (float4)(decoded(line->codes[end][0], line->p[end], precision),
                  decoded(line->codes[end][1], line->p[end], precision),
                  decoded(line->codes[end][2], line->p[end], precision), 0.0f);
}

static inline float line_error(Colours c, const CodedLine* line, EndPrecision precision, float last) {
  const float4 low = line_end(line, 0, precision), high = line_end(line, 1, precision);
  const float16 weight = index_weight(line_indices(c, low, high, last), last);
  const float lows[3] = {low.x, low.y, low.z}, highs[3] = {high.x, high.y, high.z};
  float16 square = (float16)(0.0f);
  for (int channel = 0; channel < 3; ++channel) {
    const float16 d = channel_of(c, channel) - interpolated(lows[channel], highs[channel], weight);
    square = fma(d, d, square);
  }
  return sum_of(subset_weight(c.mask) * square);
}

// The sums of the channels, and the sums of products for the upper triangle of the covariance: xx, xy, xz, yy, yz, zz.
typedef struct ColourSums {
  float count, x, y, z, xx, xy, xz, yy, yz, zz;
} ColourSums;

static inline ColourSums colour_sums(Colours c) {
  const float16 weight = subset_weight(c.mask);
  const float16 x = channel_of(c, 0), y = channel_of(c, 1), z = channel_of(c, 2);
  const float16 wx = weight * x, wy = weight * y, wz = weight * z;
  ColourSums s;
  s.count = sum_of(weight);
  s.x = sum_of(wx);
  s.y = sum_of(wy);
  s.z = sum_of(wz);
  s.xx = sum_of(wx * x);
  s.xy = sum_of(wx * y);
  s.xz = sum_of(wx * z);
  s.yy = sum_of(wy * y);
  s.yz = sum_of(wy * z);
  s.zz = sum_of(wz * z);
  return s;
}

// Replaces the sums by means, and the sums of products by sums of products about the mean.
static inline ColourSums centred(ColourSums s) {
  const float share = 1.0f / fmax(s.count, 1.0f);
  s.xx -= s.x * s.x * share;
  s.xy -= s.x * s.y * share;
  s.xz -= s.x * s.z * share;
  s.yy -= s.y * s.y * share;
  s.yz -= s.y * s.z * share;
  s.zz -= s.z * s.z * share;
  s.x *= share;
  s.y *= share;
  s.z *= share;
  return s;
}

// Returns the axis of the largest spread as a unit vector. Power iteration computes it, starting with the largest
// column.
static inline float4 principal_axis(ColourSums s) {
  float4 axis = s.xx >= s.yy && s.xx >= s.zz ? (float4)(s.xx, s.xy, s.xz, 0.0f)
                : s.yy >= s.zz               ? (float4)(s.xy, s.yy, s.yz, 0.0f)
                                             : (float4)(s.xz, s.yz, s.zz, 0.0f);
  for (int i = 0; i < 6; ++i) {
    const float length = sqrt(dot(axis, axis));
    if (length < 1e-6f) return (float4)(0.577350269f, 0.577350269f, 0.577350269f, 0.0f);
    axis /= length;
    axis = (float4)(fma(s.xx, axis.x, fma(s.xy, axis.y, s.xz * axis.z)),
                    fma(s.xy, axis.x, fma(s.yy, axis.y, s.yz * axis.z)),
                    fma(s.xz, axis.x, fma(s.yz, axis.y, s.zz * axis.z)), 0.0f);
  }
  const float length = sqrt(dot(axis, axis));
  return length < 1e-6f ? (float4)(0.577350269f, 0.577350269f, 0.577350269f, 0.0f) : axis / length;
}

// Estimates the least sum of squared distances from a line. This is the total spread minus its largest eigenvalue.
static inline float line_residual(ColourSums s) {
  s = centred(s);
  const float4 axis = principal_axis(s);
  const float along = fma(axis.x, fma(s.xx, axis.x, 2.0f * fma(s.xy, axis.y, s.xz * axis.z)),
                          fma(axis.y, fma(s.yy, axis.y, 2.0f * s.yz * axis.z), s.zz * axis.z * axis.z));
  return fmax(s.xx + s.yy + s.zz - along, 0.0f);
}

static inline void quantize(float4 low, float4 high, EndPrecision precision, CodedLine* line) {
  const float ends[2][3] = {{low.x, low.y, low.z}, {high.x, high.y, high.z}};
  for (int end = 0; end < 2; ++end)
    for (int c = 0; c < 3; ++c) line->codes[end][c] = nearest_code(ends[end][c], line->p[end], precision);
}

// Fits a line for a given p by least squares, starting from the principal axis.
static inline CodedLine fitted_line(Colours c, EndPrecision precision, int p, float last) {
  const ColourSums s = centred(colour_sums(c));
  const float4 mean = (float4)(s.x, s.y, s.z, 0.0f), axis = principal_axis(s);
  float16 along = (channel_of(c, 0) - mean.x) * axis.x;
  along = fma(channel_of(c, 1) - mean.y, (float16)(axis.y), along);
  along = fma(channel_of(c, 2) - mean.z, (float16)(axis.z), along) * subset_weight(c.mask);
  float4 low = mean + axis * least_of(along), high = mean + axis * most_of(along);
  CodedLine best, tried;
  best.error = INFINITY;
  tried.p[0] = tried.p[1] = p;
  for (int turn = 0; turn < 4; ++turn) {
    quantize(low, high, precision, &tried);
    tried.error = line_error(c, &tried, precision, last);
    if (tried.error >= best.error) break;
    best = tried;
    // Fits the endpoints by least squares to these indices.
    const float16 u =
        index_weight(line_indices(c, line_end(&tried, 0, precision), line_end(&tried, 1, precision), last), last) *
        (1.0f / 64.0f);
    const float16 weight = subset_weight(c.mask);
    const float mean_u = sum_of(weight * u) / fmax(s.count, 1.0f);
    const float16 du = weight * (u - mean_u);
    const float spread = sum_of(du * du);
    if (spread < 1e-6f) break;
    const float4 slope = (float4)(sum_of(du * (channel_of(c, 0) - mean.x)), sum_of(du * (channel_of(c, 1) - mean.y)),
                                  sum_of(du * (channel_of(c, 2) - mean.z)), 0.0f) /
                         spread;
    low = mean - mean_u * slope;
    high = low + slope;
  }
  return best;
}

__constant char kFirstMoves[8] = {1, -1, 0, 0, 1, -1, 1, -1};
__constant char kSecondMoves[8] = {0, 0, 1, -1, 1, -1, -1, 1};

// Moves each code, and both codes of a channel together, one step up or down, until a round finds no lower error.
static inline CodedLine climbed_line(Colours c, EndPrecision precision, float last, CodedLine best) {
  CodedLine tried;
  for (int turn = 0; turn < 3; ++turn) {
    const float before = best.error;
    for (int move = 0; move < 24; ++move) {
      const int channel = move % 3, kind = move / 3;  // kind: which endpoints move up or down
      tried = best;
      tried.codes[0][channel] = clamp(best.codes[0][channel] + kFirstMoves[kind], 0, (1 << precision.bits) - 1);
      tried.codes[1][channel] = clamp(best.codes[1][channel] + kSecondMoves[kind], 0, (1 << precision.bits) - 1);
      tried.error = line_error(c, &tried, precision, last);
      if (tried.error < best.error) best = tried;
    }
    if (best.error >= before) break;
  }
  return best;
}

// A separate channel, given by the codes of both endpoints and the error that these codes give.
typedef struct CodedScalar {
  int codes[2];
  float error;
} CodedScalar;

static inline float16 scalar_values(float16 v, const CodedScalar* s, int bits, float last, float16* index) {
  const EndPrecision precision = {bits, 0};
  const float low = decoded(s->codes[0], 0, precision), high = decoded(s->codes[1], 0, precision);
  const float scale = high != low ? last / (high - low) : 0.0f;
  *index = rint(clamp((v - low) * scale, 0.0f, last));
  return interpolated(low, high, index_weight(*index, last));
}

static inline CodedScalar fitted_scalar(float16 v, int bits, float last) {
  const EndPrecision precision = {bits, 0};
  float low = least_of(v), high = most_of(v);
  const float mean = sum_of(v) * (1.0f / 16.0f);
  CodedScalar best, tried;
  float16 index;
  best.error = INFINITY;
  for (int turn = 0; turn < 3; ++turn) {
    tried.codes[0] = nearest_code(low, 0, precision);
    tried.codes[1] = nearest_code(high, 0, precision);
    const float16 d = v - scalar_values(v, &tried, bits, last, &index);
    tried.error = sum_of(d * d);
    if (tried.error >= best.error) break;
    best = tried;
    const float16 u = index_weight(index, last) * (1.0f / 64.0f);
    const float mean_u = sum_of(u) * (1.0f / 16.0f);
    const float spread = sum_of((u - mean_u) * (u - mean_u));
    if (spread < 1e-6f) break;
    const float slope = sum_of((u - mean_u) * (v - mean)) / spread;
    low = mean - mean_u * slope;
    high = low + slope;
  }
  for (int turn = 0; turn < 8; ++turn) {
    const CodedScalar from = best;
    for (int move = 0; move < 9; ++move) {
      tried.codes[0] = clamp(from.codes[0] + move / 3 - 1, 0, (1 << bits) - 1);
      tried.codes[1] = clamp(from.codes[1] + move % 3 - 1, 0, (1 << bits) - 1);
      const float16 d = v - scalar_values(v, &tried, bits, last, &index);
      tried.error = sum_of(d * d);
      if (tried.error < best.error) best = tried;
    }
    if (best.error >= from.error) break;
  }
  return best;
}

static inline void store_indices(float16 index, int* indices) { vstore16(convert_int16(index), 0, indices); }

// Reverses the indices of a line if the highest bit of the anchor texel's index is set, because that bit is not stored.
// Returns 1 if the caller must swap the line's ends.
static inline int turn_anchor(int* indices, int anchor, uint mask, int last) {
  if (indices[anchor] <= last / 2) return 0;
  for (int i = 0; i < MULTUM_BLOCK_TEXELS; ++i)
    if (mask >> i & 1) indices[i] = last - indices[i];
  return 1;
}

static inline void swap_ends(CodedLine* line) {
  const CodedLine from = *line;
  for (int end = 0; end < 2; ++end) {
    line->p[end] = from.p[1 - end];
    for (int c = 0; c < 3; ++c) line->codes[end][c] = from.codes[1 - end][c];
  }
}

static inline void put_indices(BlockBits* bits, const int* indices, int bit_count, int other_anchor) {
  for (int i = 0; i < MULTUM_BLOCK_TEXELS; ++i)
    put_bits(bits, (uint)indices[i], i == 0 || i == other_anchor ? bit_count - 1 : bit_count);
}

// Writes mode 6, with endpoints of 7 bits and 16 steps. The bit p is 1, so that the unused channel is 255. The unused
// channel is alpha, or blue if the third channel is alpha.
static inline BlockBits mode_6_block(Colours c, CodedLine line, int third_is_alpha) {
  const EndPrecision precision = {7, 1};
  int indices[16];
  store_indices(line_indices(c, line_end(&line, 0, precision), line_end(&line, 1, precision), 15.0f), indices);
  if (turn_anchor(indices, 0, 0xffff, 15)) swap_ends(&line);
  BlockBits bits = {{0, 0, 0, 0}, 0};
  put_bits(&bits, 1u << 6, 7);
  for (int channel = 0; channel < 4; ++channel)
    for (int end = 0; end < 2; ++end) {
      const int source = third_is_alpha && channel > 1 ? 5 - channel : channel;  // source 3 is the constant 255
      put_bits(&bits, source == 3 ? 127u : (uint)line.codes[end][source], 7);
    }
  put_bits(&bits, 3, 2);
  put_indices(&bits, indices, 4, -1);
  return bits;
}

// Modes 4 and 5. The channel `alone` has its own endpoints and indices. It is stored as alpha, and alpha is stored in
// its place.
typedef struct SeparateMode {
  int mode, colour_bits, scalar_bits;
  int colour_last, scalar_last;  // last step: 3 or 7
} SeparateMode;

typedef struct SeparateFit {
  CodedLine line;
  CodedScalar scalar;
} SeparateFit;

static inline Colours without(Colours c, int alone) {
  c.without = alone;
  return c;
}

// A decoder swaps alpha with the channel that the rotation names. If the third channel is alpha, it is therefore stored
// in the place of `alone`. The line has the constant 255 in that place. This constant is stored as blue.
static inline BlockBits separate_block(Colours c, int alone, SeparateMode m, SeparateFit fit, int third_is_alpha) {
  const EndPrecision precision = {m.colour_bits, 0};
  int colour[16], scalar[16];
  float16 index;
  store_indices(line_indices(without(c, alone), line_end(&fit.line, 0, precision), line_end(&fit.line, 1, precision),
                             (float)m.colour_last),
                colour);
  if (turn_anchor(colour, 0, 0xffff, m.colour_last)) swap_ends(&fit.line);
  scalar_values(channel_of(c, alone), &fit.scalar, m.scalar_bits, (float)m.scalar_last, &index);
  store_indices(index, scalar);
  if (turn_anchor(scalar, 0, 0xffff, m.scalar_last)) {
    const int code = fit.scalar.codes[0];
    fit.scalar.codes[0] = fit.scalar.codes[1];
    fit.scalar.codes[1] = code;
  }
  BlockBits bits = {{0, 0, 0, 0}, 0};
  put_bits(&bits, 1u << m.mode, m.mode + 1);
  put_bits(&bits, third_is_alpha && alone == 2 ? 0u : (uint)(alone + 1), 2);
  if (m.mode == 4) put_bits(&bits, m.colour_last == 7, 1);  // selects which indices have 3 bits
  for (int channel = 0; channel < 3; ++channel)
    for (int end = 0; end < 2; ++end) {
      const int source = !third_is_alpha ? channel : channel == 2 ? alone : channel == alone ? 2 : channel;
      put_bits(&bits, (uint)fit.line.codes[end][source], m.colour_bits);
    }
  for (int end = 0; end < 2; ++end) put_bits(&bits, (uint)fit.scalar.codes[end], m.scalar_bits);
  // Indices of 2 bits come first. In mode 5, all indices have 2 bits, and the indices of the colours come first.
  const int scalar_first = m.colour_last == 7;
  put_indices(&bits, scalar_first ? scalar : colour, 2, -1);
  put_indices(&bits, scalar_first ? colour : scalar, m.mode == 4 ? 3 : 2, -1);
  return bits;
}

// Returns the channel to leave out so that the other channels are closest to a line.
static inline int channel_alone(Colours c) {
  int alone = 0;
  float least = INFINITY;
  for (int channel = 0; channel < 3; ++channel) {
    const float residual = line_residual(colour_sums(without(c, channel)));
    if (residual < least) {
      least = residual;
      alone = channel;
    }
  }
  return alone;
}

static inline ColourSums difference(ColourSums a, ColourSums b) {
  ColourSums d;
  d.count = a.count - b.count;
  d.x = a.x - b.x, d.y = a.y - b.y, d.z = a.z - b.z;
  d.xx = a.xx - b.xx, d.xy = a.xy - b.xy, d.xz = a.xz - b.xz;
  d.yy = a.yy - b.yy, d.yz = a.yz - b.yz, d.zz = a.zz - b.zz;
  return d;
}

__constant ushort kPartitionMasks[MULTUM_BC7_PARTITIONS] = MULTUM_BC7_PARTITION_MASKS;
__constant uchar kAnchors[MULTUM_BC7_PARTITIONS] = MULTUM_BC7_ANCHORS;

// Returns the two partitions whose pairs of lines leave the least residual.
static inline int2 best_partitions(Colours c) {
  const ColourSums all = colour_sums(c);
  float first = INFINITY, second = INFINITY;
  int2 found = (int2)(0, 1);
  for (int partition = 0; partition < MULTUM_BC7_PARTITIONS; ++partition) {
    Colours subset = c;
    subset.mask = kPartitionMasks[partition];
    const ColourSums ones = colour_sums(subset);
    const float residual = line_residual(ones) + line_residual(difference(all, ones));
    if (residual < first) {
      second = first;
      found.y = found.x;
      first = residual;
      found.x = partition;
    } else if (residual < second) {
      second = residual;
      found.y = partition;
    }
  }
  return found;
}

// Fits mode 1, which has two lines, endpoints of 6 bits, one p per line, and 8 steps.
static inline BlockBits mode_1_block(Colours c, int partition, CodedLine* lines) {
  const EndPrecision precision = {6, 1};
  const int anchor = kAnchors[partition];
  const uint mask = kPartitionMasks[partition];
  int of_line[16], indices[16];
  for (int line = 0; line < 2; ++line) {
    const uint own = line == 0 ? ~mask & 0xffff : mask;
    store_indices(line_indices(c, line_end(&lines[line], 0, precision), line_end(&lines[line], 1, precision), 7.0f),
                  of_line);
    if (turn_anchor(of_line, line == 0 ? 0 : anchor, own, 7)) swap_ends(&lines[line]);
    for (int i = 0; i < MULTUM_BLOCK_TEXELS; ++i)
      if (own >> i & 1) indices[i] = of_line[i];
  }
  BlockBits bits = {{0, 0, 0, 0}, 0};
  put_bits(&bits, 2, 2);
  put_bits(&bits, (uint)partition, 6);
  for (int channel = 0; channel < 3; ++channel)
    for (int line = 0; line < 2; ++line)
      for (int end = 0; end < 2; ++end) put_bits(&bits, (uint)lines[line].codes[end][channel], 6);
  put_bits(&bits, (uint)lines[0].p[0], 1);
  put_bits(&bits, (uint)lines[1].p[0], 1);
  put_indices(&bits, indices, 3, anchor);
  return bits;
}

static inline CodedLine better_p(Colours c, EndPrecision precision, float last) {
  const CodedLine zero = fitted_line(c, precision, 0, last), one = fitted_line(c, precision, 1, last);
  return zero.error <= one.error ? zero : one;
}

static inline Colours subset_of(Colours c, int partition, int line) {
  const uint mask = kPartitionMasks[partition];
  c.mask = line == 0 ? ~mask & 0xffff : mask;
  return c;
}

// Modes 4 and 5 with their bits and steps. Each row has the mode, colour bits, scalar bits, colour steps and scalar
// steps. separate_fit() returns the best fit before codes are improved one by one. `choice` is the index of this fit in
// the table.
__constant SeparateMode kSeparateModes[3] = {{5, 7, 8, 3, 3}, {4, 5, 6, 3, 7}, {4, 5, 6, 7, 3}};

static inline SeparateFit separate_fit(Colours c, int alone, int* choice) {
  SeparateFit best;
  float error = INFINITY;
  for (int m = 0; m < 3; ++m) {
    const SeparateMode mode = kSeparateModes[m];
    const EndPrecision precision = {mode.colour_bits, 0};
    SeparateFit fit;
    fit.line = fitted_line(without(c, alone), precision, 0, (float)mode.colour_last);
    fit.scalar = fitted_scalar(channel_of(c, alone), mode.scalar_bits, (float)mode.scalar_last);
    if (fit.line.error + fit.scalar.error >= error) continue;
    error = fit.line.error + fit.scalar.error;
    best = fit;
    *choice = m;
  }
  return best;
}

// Returns the error that mode 6 cannot avoid. The bit p of mode 6 is 1, so it stores 0 as 1. A channel that is 0
// everywhere, such as metalness, always has this error, so the search does not continue because of it.
static inline float unreachable_error(Colours c) {
  float error = 0.0f;
  for (int channel = 0; channel < 3; ++channel) error += most_of(channel_of(c, channel)) == 0.0f ? 16.0f : 0.0f;
  return error;
}

// One work-item handles one block.
//   values [block][channel][16]   red, green, and blue or alpha, 0 to 255
//   blocks [block]                written
// If third_is_alpha, the third channel is alpha, and blue is 255. third_is_alpha is an argument, because a second
// kernel would be slower: the compiler does not inline functions that two kernels call. Without inlining, BC7 takes 1.5
// times as long (PoCL 3.1, AVX2). The kernel is compute bound. It evaluates a block's error some 50 times if mode 6 is
// good enough, and otherwise some 200 times.
__kernel void encode_colour_blocks(__global const float* values, __global uint4* blocks, int block_count,
                                   int third_is_alpha) {
  const int item = (int)get_global_id(0);
  if (item >= block_count) return;
  Colours c;
  c.values = values + (size_t)item * (3 * MULTUM_BLOCK_TEXELS);
  c.without = -1;
  c.mask = 0xffff;
  const EndPrecision seven = {7, 1}, six = {6, 1};
  const CodedLine line = climbed_line(c, seven, 15.0f, fitted_line(c, seven, 1, 15.0f));
  BlockBits bits = mode_6_block(c, line, third_is_alpha);
  if (line.error > ROUNDING_ERROR) {
    int choice = 0;
    const int alone = channel_alone(c);
    SeparateFit fit = separate_fit(c, alone, &choice);
    int partition = 0;
    CodedLine lines[2];
    lines[0].error = lines[1].error = INFINITY;  // mode 1 cannot store alpha
    const int is_near = fmin(fit.line.error + fit.scalar.error, line.error - unreachable_error(c)) <= ROUNDING_ERROR;
    if (!third_is_alpha && !is_near) {
      const int2 partitions = best_partitions(c);
      for (int k = 0; k < 2; ++k) {
        const int tried = k == 0 ? partitions.x : partitions.y;
        const CodedLine zero = better_p(subset_of(c, tried, 0), six, 7.0f);
        const CodedLine one = better_p(subset_of(c, tried, 1), six, 7.0f);
        if (zero.error + one.error >= lines[0].error + lines[1].error) continue;
        partition = tried;
        lines[0] = zero;
        lines[1] = one;
      }
    }
    // Only the candidate with the lower error is improved further.
    if (fit.line.error + fit.scalar.error < lines[0].error + lines[1].error) {
      const SeparateMode mode = kSeparateModes[choice];
      const EndPrecision precision = {mode.colour_bits, 0};
      fit.line = climbed_line(without(c, alone), precision, (float)mode.colour_last, fit.line);
      if (fit.line.error + fit.scalar.error < line.error) bits = separate_block(c, alone, mode, fit, third_is_alpha);
    } else {
      for (int l = 0; l < 2; ++l) lines[l] = climbed_line(subset_of(c, partition, l), six, 7.0f, lines[l]);
      if (lines[0].error + lines[1].error < line.error) bits = mode_1_block(c, partition, lines);
    }
  }
  blocks[item] = (uint4)(bits.words[0], bits.words[1], bits.words[2], bits.words[3]);
}
