// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/render/contact_sheet.h"

#include <algorithm>
#include <cmath>

#include "host/foundation/base/error.h"

namespace multum::gl {
namespace {

constexpr int kGlyphWidth = 5;
constexpr int kGlyphHeight = 8;
constexpr int kGlyphAdvance = kGlyphWidth + 1;
constexpr int kMargin = 2;  // margin around a label; this and the glyph's sizes are in pixels at scale 1
constexpr int kGap = 4;
// The usual width of a window that shows a sheet, and the height of letters in it, in pixels.
constexpr double kShownWidth = 1280.0, kShownHeight = 12.0;

int label_height(int scale) { return scale * (kGlyphHeight + 2 * kMargin); }

struct Glyph {
  char letter;
  const char* rows;  // eight rows of five, '#' = ink; the last row is below the line
};

// clang-format off
constexpr Glyph kGlyphs[] = {
    {'a', "...........###.....#.#####...#.####....."},
    {'b', "#....#....####.#...##...##...#####......"},
    {'c', "...........#####....#....#.....####....."},
    {'d', "....#....#.#####...##...##...#.####....."},
    {'e', "...........###.#...#######.....###......"},
    {'f', "..##..#...####..#....#....#....#........"},
    {'g', "...........#####...##...#.####....#.###."},
    {'h', "#....#....####.#...##...##...##...#....."},
    {'i', "..#........##....#....#....#...###......"},
    {'j', "...#........##....#....#....#.#..#..##.."},
    {'k', "#....#....#..#.#.#..##...#.#..#..#......"},
    {'l', ".##....#....#....#....#....#...###......"},
    {'m', "..........##.#.#.#.##.#.##.#.##.#.#....."},
    {'n', "..........####.#...##...##...##...#....."},
    {'o', "...........###.#...##...##...#.###......"},
    {'p', "..........####.#...##...#####.#....#...."},
    {'q', "...........#####...##...#.####....#....#"},
    {'r', "..........#.##.##...#....#....#........."},
    {'s', "...........#####.....###.....#####......"},
    {'t', ".#....#...####..#....#....#.....##......"},
    {'u', "..........#...##...##...##...#.####....."},
    {'v', "..........#...##...##...#.#.#...#......."},
    {'w', "..........#.#.##.#.##.#.##.#.#.#.#......"},
    {'x', "..........#...#.#.#...#...#.#.#...#....."},
    {'y', "..........#...##...##...#.####....#.###."},
    {'z', "..........#####...#...#...#...#####....."},
    {'A', ".###.#...##...#######...##...#.........."},
    {'E', "######....####.#....#....#####.........."},
    {'L', "#....#....#....#....#....#####.........."},
    {'N', "#...###..##.#.##..###...##...#.........."},
    {'T', "#####..#....#....#....#....#............"},
    {'0', ".###.#...##..###.#.###..##...#.###......"},
    {'1', "..#...##....#....#....#....#...###......"},
    {'2', ".###.#...#....#...#...#...#...#####....."},
    {'3', ".###.#...#....#..##.....##...#.###......"},
    {'4', "...#...##..#.#.#..#.#####...#....#......"},
    {'5', "######....####.....#....##...#.###......"},
    {'6', ".###.#....#....####.#...##...#.###......"},
    {'7', "#####....#...#...#...#....#....#........"},
    {'8', ".###.#...##...#.###.#...##...#.###......"},
    {'9', ".###.#...##...#.####....#....#.###......"},
    {'.', "..........................##...##......."},
    {',', "......................#....#...#........"},
    {':', "......##...##........##...##............"},
    {'%', "##..###..#...#...#...#...#..###..##....."},
    {'-', "...............#####...................."},
    {'+', ".......#....#..#####..#....#............"},
    {'/', "....#....#...#...#...#...#....#........."},
    {'(', "...#...#...#....#....#.....#.....#......"},
    {')', ".#.....#.....#....#....#...#...#........"},
    {'|', "..#....#....#....#....#....#....#......."},
    {'=', "..........#####.....#####..............."},
    {'_', "..............................#####....."},
};
// clang-format on

void put_pixel(FloatImage& sheet, int x, int y, float value) {
  if (x < 0 || y < 0 || x >= sheet.width || y >= sheet.height) return;
  float* pixel = &sheet.rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(sheet.width) +
                                  static_cast<std::size_t>(x))];
  pixel[0] = pixel[1] = pixel[2] = value;
  pixel[3] = 1.0f;
}

void draw_glyph(FloatImage& sheet, const Glyph& glyph, int left, int top, int scale, float value) {
  for (int y = 0; y < kGlyphHeight * scale; ++y)
    for (int x = 0; x < kGlyphWidth * scale; ++x)
      if (glyph.rows[y / scale * kGlyphWidth + x / scale] == '#') put_pixel(sheet, left + x, top + y, value);
}

/// Returns the width of the longest label in pixels at scale 1.
int widest_label(const std::vector<std::vector<SheetCell>>& rows) {
  int width = 0;
  for (const std::vector<SheetCell>& row : rows)
    for (const SheetCell& cell : row)
      width = std::max(width, kMargin + kGlyphAdvance * static_cast<int>(cell.label.size()));
  return width;
}

void draw_text(FloatImage& sheet, const std::string& text, int left, int top, int scale, float value) {
  for (std::size_t i = 0; i < text.size(); ++i)
    for (const Glyph& glyph : kGlyphs)
      if (glyph.letter == text[i])
        draw_glyph(sheet, glyph, left + scale * static_cast<int>(i) * kGlyphAdvance, top, scale, value);
}

void draw_cell(FloatImage& sheet, const SheetCell& cell, int left, int top, int scale, float label_value) {
  draw_text(sheet, cell.label, left + scale * kMargin, top + scale * kMargin, scale, label_value);
  const auto row = 4 * static_cast<std::ptrdiff_t>(cell.image.width);
  for (int y = 0; y < cell.image.height; ++y) {
    const auto to = 4 * (static_cast<std::ptrdiff_t>(top + label_height(scale) + y) * sheet.width + left);
    std::copy_n(cell.image.rgba.begin() + y * row, row, sheet.rgba.begin() + to);
  }
}

FloatImage black_image(int width, int height) {
  FloatImage made{width, height, {}};
  made.rgba.assign(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.0f);
  for (std::size_t i = 3; i < made.rgba.size(); i += 4) made.rgba[i] = 1.0f;
  return made;
}

}  // namespace

FloatImage make_contact_sheet(const std::vector<std::vector<SheetCell>>& rows, float label_value) {
  MULTUM_CHECK(!rows.empty() && !rows[0].empty());
  // No label is cut. Small pictures get smaller letters. If these are still too wide, the cell is wider than the
  // picture.
  const int label_width = widest_label(rows), image_width = rows[0][0].image.width;
  const double sheet_width = static_cast<double>(rows[0].size()) * (image_width + kGap);
  const int readable = static_cast<int>(std::ceil(kShownHeight / kGlyphHeight * sheet_width / kShownWidth));
  const int scale = std::clamp(image_width / std::max(label_width, 1), 1, std::max(readable, 2));
  const int cell_width = std::max(image_width, scale * label_width) + kGap;
  const int cell_height = rows[0][0].image.height + label_height(scale) + kGap;
  FloatImage sheet = black_image(static_cast<int>(rows[0].size()) * cell_width - kGap,
                                 static_cast<int>(rows.size()) * cell_height - kGap);
  for (std::size_t y = 0; y < rows.size(); ++y) {
    MULTUM_CHECK(rows[y].size() <= rows[0].size());
    for (std::size_t x = 0; x < rows[y].size(); ++x) {
      MULTUM_CHECK(rows[y][x].image.width == rows[0][0].image.width &&
                   rows[y][x].image.height == rows[0][0].image.height);
      draw_cell(sheet, rows[y][x], static_cast<int>(x) * cell_width, static_cast<int>(y) * cell_height, scale,
                label_value);
    }
  }
  return sheet;
}

FloatImage difference_legend(int width, int height, float gain, float white) {
  FloatImage made = black_image(width, height);
  const std::string name = "difference from the reference", least = "0",
                    most = std::to_string(std::lround(100.0f / gain)) + " % of white";
  const int letters = static_cast<int>(name.size()) * kGlyphAdvance + 2 * kMargin;
  const int scale = std::max(1, width / letters), left = scale * kMargin, right = width - left;
  const int line = label_height(scale), top = std::max(0, (height - 4 * line) / 2);
  draw_text(made, name, left, top, scale, white);
  for (int y = top + line; y < std::min(height, top + 3 * line); ++y)
    for (int x = left; x < right; ++x) {
      const float share = static_cast<float>(x - left) / static_cast<float>(std::max(1, right - left - 1));
      put_pixel(made, x, y, white * share);
    }
  draw_text(made, least, left, top + 3 * line + scale * kMargin, scale, white);
  draw_text(made, most, right - scale * kGlyphAdvance * static_cast<int>(most.size()), top + 3 * line + scale * kMargin,
            scale, white);
  return made;
}

}  // namespace multum::gl
