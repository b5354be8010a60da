// SPDX-License-Identifier: Apache-2.0
// Codes the quantized wavelet coefficients of a plane, bit plane by bit plane, starting with the highest. Every prefix
// then gives all coefficients to some precision. Each bit plane has a pass that finds new coefficients, and a pass that
// refines the coefficients found in earlier planes. The first pass descends a quadtree over each band. A node is
// significant if a coefficient under it is significant (set partitioning: Pearlman et al. 2004, "Efficient,
// low-complexity image coding with a set-partitioning embedded block coder"). The contexts of a node are its neighbours
// and three nodes at the same place: in the next coarser band, in the coarser image of the pyramid over parameters, and
// in luma. These contexts are similar to embedded zero-block coding (Hsiang and Woods 2000).
#pragma once

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "host/fields/codec/decoder/context_table.h"
#include "host/fields/codec/decoder/symbol_coder.h"
#include "host/fields/codec/decoder/wavelet_transform.h"

namespace multum {

/// The known bits of one plane of an image, and the quadtrees over its bands. If there are no bands, all coefficients
/// are zero and unknown.
class WaveletPlane {
 public:
  static constexpr int kBitPlanes = 20;

  WaveletPlane() = default;
  WaveletPlane(std::size_t width, std::size_t height);

  struct Level {
    std::size_t width = 0, height = 0;
    std::vector<std::uint8_t> significant;
  };
  struct Tree {
    WaveletBand band;
    std::vector<Level> levels;  // level 0: coefficients; the last level is a single node
    int coarser = -1;           // index of the tree of the same kind of band, one level coarser
  };

  bool is_empty() const { return trees_.empty(); }
  std::size_t width() const { return width_; }
  std::vector<Tree>& trees() { return trees_; }
  const std::vector<Tree>& trees() const { return trees_; }

  /// The magnitude, the sign (1 is negative) and the lowest known bit plane of each significant coefficient,
  /// [height][width].
  std::vector<std::uint32_t> magnitudes;
  std::vector<std::uint8_t> negative, known;

  /// Calls visit(place) for each significant coefficient, row by row. If visit returns false, stops and returns false.
  /// Significant coefficients are rare, so whole words of bits are skipped.
  template <class Visit>
  bool over_found(Visit visit) const {
    for (std::size_t word = 0; word < found_.size(); ++word)
      for (std::uint64_t bits = found_[word]; bits != 0; bits &= bits - 1)
        if (!visit(64 * word + static_cast<std::size_t>(std::countr_zero(bits)))) return false;
    return true;
  }
  /// Marks a coefficient as significant.
  void find(std::size_t at, int bit_plane, bool is_negative) {
    found_[at / 64] |= std::uint64_t{1} << at % 64;
    negative[at] = is_negative ? 1 : 0;
    magnitudes[at] = 1u << bit_plane;
    known[at] = static_cast<std::uint8_t>(bit_plane);
  }
  bool significant(std::size_t tree, std::size_t level, std::size_t x, std::size_t y) const;

 private:
  std::size_t width_ = 0;
  std::vector<Tree> trees_;
  std::vector<std::uint64_t> found_;  // one bit per coefficient, set if it is significant
};

/// The encoder's exact plane, with whole magnitudes and signs, and with the largest magnitude under each node.
struct WaveletSource {
  const std::vector<std::int32_t>* values = nullptr;             // [height][width]; null in a decoder
  std::vector<std::vector<std::vector<std::uint32_t>>> largest;  // [tree][level][node]
};

/// The other known planes. Each pointer is null if the plane is missing.
struct WaveletSurroundings {
  const WaveletPlane* parent = nullptr;  // the same plane of the coarser image
  const WaveletPlane* luma = nullptr;
  bool has_parent = false;
  std::size_t plane = 0;
};

class WaveletSyntax {
 public:
  /// Codes the number of bit planes of the plane, 0 to WaveletPlane::kBitPlanes.
  template <class Port>
  int bit_planes(SymbolCoder<Port>& coder, const WaveletSource& source, std::size_t plane) {
    std::uint32_t highest = 0;
    for (const auto& tree : source.largest)
      highest = std::max(highest, static_cast<std::uint32_t>(std::bit_width(tree.back().front())));
    highest = coder.number(highest, bit_planes_[plane > 0 ? 1 : 0]);
    return static_cast<int>(std::min<std::uint32_t>(highest, WaveletPlane::kBitPlanes));
  }

  /// Codes the plane's bits, starting with its highest bit plane. Calls `ended` after every symbol, and stops when
  /// `ended` returns true. Before decoding, `plane` has its size and no significant coefficient.
  template <class Port, class Ended>
  void plane(SymbolCoder<Port>& coder, WaveletPlane& plane, int bit_planes, const WaveletSource& source,
             const WaveletSurroundings& around, Ended ended) {
    for (int p = bit_planes - 1; p >= 0; --p) {
      for (std::size_t t = 0; t < plane.trees().size(); ++t) {
        Visit<Port, Ended> visit{coder, plane, source, around, ended, t, p, bit_planes - 1 - p};
        const std::size_t top = plane.trees()[t].levels.size() - 1;
        if (!find(visit, top, 0, 0, false, 0)) return;
      }
      if (!refine(coder, plane, source, around, ended, p)) return;
    }
  }

 private:
  static constexpr std::size_t kLevels = 5, kDepths = 7;

  template <class Port, class Ended>
  struct Visit {
    SymbolCoder<Port>& coder;
    WaveletPlane& plane;
    const WaveletSource& source;
    const WaveletSurroundings& around;
    Ended& ended;
    std::size_t tree;
    int bit_plane;
    int below_highest;
  };

  /// Codes which coefficients under a node become significant. If `certain`, at least one of them does. Returns false
  /// at the stream's end.
  template <class Port, class Ended>
  bool find(Visit<Port, Ended>& visit, std::size_t level, std::size_t x, std::size_t y, bool certain,
            std::size_t found) {
    auto& tree = visit.plane.trees()[visit.tree];
    auto& nodes = tree.levels[level];
    auto& state = nodes.significant[y * nodes.width + x];
    const bool is_new = state == 0;
    if (is_new) {
      bool now = certain;
      if (!certain) {
        const bool is_here = visit.source.values != nullptr &&
                             visit.source.largest[visit.tree][level][y * nodes.width + x] >> visit.bit_plane > 0;
        now = significance(visit, level, x, y, found, is_here);
        if (visit.ended()) return false;
      }
      if (!now) return true;
      state = 1;
    }
    if (level == 0) return !is_new || sign(visit, x, y);
    const auto& below = tree.levels[level - 1];
    const std::size_t x_end = std::min(2 * x + 2, below.width), y_end = std::min(2 * y + 2, below.height);
    std::size_t found_below = 0;
    for (std::size_t cy = 2 * y; cy < y_end; ++cy)
      for (std::size_t cx = 2 * x; cx < x_end; ++cx) {
        const bool is_last = cy + 1 == y_end && cx + 1 == x_end;
        if (!find(visit, level - 1, cx, cy, is_new && is_last && found_below == 0, found_below)) return false;
        found_below += tree.levels[level - 1].significant[cy * below.width + cx];
      }
    return true;
  }

  template <class Port, class Ended>
  bool significance(Visit<Port, Ended>& visit, std::size_t level, std::size_t x, std::size_t y, std::size_t found,
                    bool is_here) {
    const auto& plane = visit.plane;
    const auto& tree = plane.trees()[visit.tree];
    const auto at = [&](std::size_t nx, std::size_t ny) -> std::size_t {  // wraps around below zero and then exceeds
                                                                          // every width
      return plane.significant(visit.tree, level, nx, ny) ? 1 : 0;
    };
    const std::size_t row = at(x - 1, y) + at(x + 1, y), column = at(x, y - 1) + at(x, y + 1);
    const std::size_t corners = at(x - 1, y - 1) + at(x + 1, y - 1) + at(x - 1, y + 1) + at(x + 1, y + 1);
    const bool high_x = tree.band.kind == 1;
    const std::size_t along = high_x ? column : row, across = high_x ? row : column;
    std::size_t coarser = 0;
    if (tree.coarser >= 0) {
      const auto above = static_cast<std::size_t>(tree.coarser);
      const bool is_leaf = level == 0;
      coarser = plane.significant(above, is_leaf ? 0 : level - 1, is_leaf ? x / 2 : x, is_leaf ? y / 2 : y) ? 1 : 0;
    }
    const auto there = [&](const WaveletPlane* other) -> std::size_t {
      return other != nullptr && !other->is_empty() && other->significant(visit.tree, level, x, y) ? 1 : 0;
    };
    const std::size_t parent = !visit.around.has_parent ? 2 : there(visit.around.parent);
    const std::size_t luma = there(visit.around.luma), chroma = visit.around.plane > 0 ? 1 : 0;
    const std::size_t l = std::min(level, kLevels - 1), depth = static_cast<std::size_t>(tree.band.depth);
    const auto kind = static_cast<std::size_t>(tree.band.kind);
    const std::size_t order = std::min<std::size_t>(static_cast<std::size_t>(visit.below_highest), 5);
    return visit.coder.bit(
        is_here,
        {&near_[chroma][l][kind == 3   ? 1
                           : kind == 0 ? 2
                                       : 0][along][across],
         &other_[chroma][l][coarser][parent][luma][std::min<std::size_t>(row + column, 2)],
         &place_[chroma][std::min(depth, kDepths - 1)][kind][l][order], &corner_[chroma][l][corners][found]},
        find_mixer_[chroma][l]);
  }

  template <class Port, class Ended>
  bool sign(Visit<Port, Ended>& visit, std::size_t x, std::size_t y) {
    auto& plane = visit.plane;
    const auto& band = plane.trees()[visit.tree].band;
    const std::size_t at = (band.y + y) * plane.width() + band.x + x;
    const bool negative = visit.source.values != nullptr && (*visit.source.values)[at] < 0;
    const auto sign_at = [&](bool there, std::size_t place) -> std::size_t {
      return !there || plane.magnitudes[place] == 0 ? 0 : plane.negative[place] ? 2 : 1;
    };
    bool coded = false;
    if (band.kind == 0)
      coded = visit.coder.bit(negative, sign_[sign_at(x > 0, at - 1)][sign_at(y > 0, at - plane.width())]);
    else coded = visit.coder.even_bit(negative);
    if (visit.ended()) return false;
    plane.find(at, visit.bit_plane, coded);
    return true;
  }

  template <class Port, class Ended>
  bool refine(SymbolCoder<Port>& coder, WaveletPlane& plane, const WaveletSource& source,
              const WaveletSurroundings& around, Ended& ended, int p) {
    return plane.over_found([&](std::size_t at) {
      if (plane.known[at] == p) return true;
      const bool bit = source.values != nullptr && (std::abs((*source.values)[at]) >> p & 1) != 0;
      const auto length = static_cast<std::size_t>(std::bit_width(plane.magnitudes[at]) - p - 1);
      const bool coded = coder.bit(bit, refine_[around.plane > 0 ? 1 : 0][std::min<std::size_t>(length, 4)]);
      if (ended()) return false;
      plane.magnitudes[at] |= (coded ? 1u : 0u) << p;
      plane.known[at] = static_cast<std::uint8_t>(p);
      return true;
    });
  }

  std::array<std::array<AdaptiveBit, 17>, 2> bit_planes_;
  ContextTable<2, kLevels, 3, 3, 3> near_;
  ContextTable<2, kLevels, 2, 3, 2, 3> other_;
  ContextTable<2, kDepths, 4, kLevels, 6> place_;
  ContextTable<2, kLevels, 5, 4> corner_;
  ContextTable<2, 5> refine_;
  ContextTable<3, 3> sign_;
  std::array<std::array<BitMixer, kLevels>, 2> find_mixer_;
};

}  // namespace multum
