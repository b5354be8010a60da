// SPDX-License-Identifier: Apache-2.0
// Tests real files if MULTUM_SHARED_DATA names their folder. Each file in its MANIFEST.md must read as the manifest
// says, and each file under bad/ must open or fail in bounded time and memory. The expected results come from the
// manifest's rows, not from names, so that another set of the same form works too.
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>

#include "host/foundation/base/processes/sanitizers.h"
#include "tests/fixtures/shared_data.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

namespace fs = std::filesystem;

enum class Expected { kNormalMap, kHeightField, kNoNormalMap };

struct ManifestRow {
  std::string file;
  Expected expected;
  std::string green;  // is "up", "down" or empty
};

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> result;
  std::size_t begin = line.find('|');
  while (begin != std::string::npos) {
    const std::size_t end = line.find('|', begin + 1);
    if (end == std::string::npos) break;
    const std::string cell = line.substr(begin + 1, end - begin - 1);
    const std::size_t first = cell.find_first_not_of(' ');
    result.push_back(first == std::string::npos ? "" : cell.substr(first, cell.find_last_not_of(' ') - first + 1));
    begin = end;
  }
  return result;
}

// | file | KiB | format; green up (0.6), ... | content | source | licence |
std::optional<ManifestRow> parse_row(const std::string& line) {
  const std::vector<std::string> row = cells(line);
  if (row.size() < 4 || !(row[0].starts_with("normal/") || row[0].starts_with("height/")) || row[0].ends_with(".npz"))
    return std::nullopt;
  ManifestRow result{row[0], Expected::kNoNormalMap, ""};
  if (row[2].find("green ") != std::string::npos || row[3].find("normals") != std::string::npos) {
    result.expected = Expected::kNormalMap;
  } else if (row[2].find(" 1 channel") != std::string::npos || row[3].find("height") != std::string::npos) {
    result.expected = Expected::kHeightField;
  }
  if (row[2].find("green up") != std::string::npos) result.green = "up";
  if (row[2].find("green down") != std::string::npos) result.green = "down";
  return result;
}

std::vector<ManifestRow> manifest_rows() {
  std::ifstream manifest(shared_data() + "/MANIFEST.md");
  std::vector<ManifestRow> rows;
  for (std::string line; std::getline(manifest, line);)
    if (const std::optional<ManifestRow> row = parse_row(line)) rows.push_back(*row);
  return rows;
}

void expect_as_described(const ManifestRow& row, const NormalMap& map) {
  const NormalMapReport& report = map.report;
  const bool is_height_field = report.encoding.starts_with("height field");
  // A grey colour map cannot be distinguished from a height map, and the message says so.
  const bool expect_height_field = row.expected != Expected::kNormalMap;
  EXPECT_EQ(is_height_field, expect_height_field) << report.encoding << ": " << report.encoding_reason;
  if (!row.green.empty()) {
    EXPECT_NE(report.encoding.find("green " + row.green), std::string::npos) << report.encoding_reason;
    EXPECT_EQ(report.encoding.find("undecided"), std::string::npos) << report.encoding_reason;
  }
  std::cout << row.file << ": " << report.encoding << " (" << report.encoding_reason << "); unused "
            << report.unused_texels << ", repaired " << report.nonfinite_repaired << " + "
            << report.zero_length_repaired << " + " << report.below_horizon_repaired << '\n';
  for (const std::string& warning : report.warnings) std::cout << "  warning: " << warning << '\n';
}

TEST(SharedData, EveryFileOfTheManifestIsUnderstood) {
  if (shared_data().empty()) GTEST_SKIP() << "MULTUM_SHARED_DATA names no folder of real maps";
  const std::vector<ManifestRow> rows = manifest_rows();
  ASSERT_GE(rows.size(), 10u) << "no table in " << shared_data() << "/MANIFEST.md";
  int refused_count = 0;
  NormalMapSettings settings;  // prints how the borders of real maps meet
  settings.wrap_s_origin = settings.wrap_t_origin = WrapOrigin::kFound;
  for (const ManifestRow& row : rows) {
    SCOPED_TRACE(row.file);
    try {
      expect_as_described(row, read_map(shared_data() + "/" + row.file, settings));
    } catch (const Error& error) {
      EXPECT_EQ(row.expected, Expected::kNoNormalMap) << error.what();
      EXPECT_EQ(error.code(), ErrorCode::kInput);
      std::cout << row.file << ": refused: " << error.what() << '\n';
      ++refused_count;
    }
  }
  std::cout << rows.size() << " files, " << refused_count << " refused\n";
}

// The slopes of a terrain must agree in size and sign, whether the terrain is given as heights or as normals.
TEST(SharedData, HeightsAndNormalsOfOneTerrainAgree) {
  const std::string folder = shared_data() + "/height/";
  if (shared_data().empty() || !fs::exists(folder + "jacksboro_height_u16.png"))
    GTEST_SKIP() << "MULTUM_SHARED_DATA names no folder with the Jacksboro terrain";
  const NormalMap expected = read_map(folder + "jacksboro_normal_x4_signed_half.exr");
  for (const char* name : {"jacksboro_normal_x4_gl_u16.png", "jacksboro_normal_x4_gl_u16.tif"}) {
    const NormalMap other = read_map(folder + name);
    for (std::size_t i = 0; i < other.x.size(); ++i) ASSERT_NEAR(other.y[i], expected.y[i], 1e-3) << name;
  }
  // The exact scale of the normals is not stated, so it is fitted twice: to heights in metres, and to 16-bit heights
  // with a range of 840 metres. The two fits must agree.
  double fitted[2] = {0.0, 0.0};
  for (const int source : {0, 1}) {
    const NormalMap heights =
        read_map(folder + (source == 0 ? "jacksboro_height_m_float.exr" : "jacksboro_height_u16.png"));
    double xy = 0.0, xx = 0.0, yy = 0.0;
    for (int row = 1; row + 1 < heights.height; ++row) {
      for (int column = 1; column + 1 < heights.width; ++column) {
        const auto i = static_cast<std::size_t>(row * heights.width + column);
        for (const auto& [a, b] : {std::pair{heights.x[i] / heights.z[i], expected.x[i] / expected.z[i]},
                                   std::pair{heights.y[i] / heights.z[i], expected.y[i] / expected.z[i]}}) {
          xy += static_cast<double>(a) * static_cast<double>(b);
          xx += static_cast<double>(a) * static_cast<double>(a);
          yy += static_cast<double>(b) * static_cast<double>(b);
        }
      }
    }
    EXPECT_GT(xy / std::sqrt(xx * yy), 0.95);
    fitted[source] = xy / xx;
  }
  EXPECT_NEAR(fitted[1] / fitted[0], 840.0, 1.0);
}

// Runs in a separate process, because it may crash. The process has 4 GB of address space and 20 s.
[[noreturn]] void read_under_limits(const std::string& path) {
#ifndef MULTUM_SHADOW_MEMORY  // the shadow memory of the sanitizer needs terabytes of address space
  const rlimit limit{rlim_t{4} << 30, rlim_t{4} << 30};
  if (setrlimit(RLIMIT_AS, &limit) != 0) _exit(3);
#endif
  alarm(20);
  try {
    read_map(path);
  } catch (const Error& error) {
    const bool names_file = std::string(error.what()).find(fs::path(path).filename().string()) != std::string::npos;
    _exit(names_file ? 0 : 2);
  }
  _exit(0);
}

TEST(SharedDataDeathTest, DamagedAndHostileFilesEndInAnError) {
  if (shared_data().empty()) GTEST_SKIP() << "MULTUM_SHARED_DATA names no folder of damaged files";
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  int file_count = 0;
  for (const char* kind : {"image", "exr"}) {
    for (const fs::directory_entry& entry : fs::directory_iterator(shared_data() + "/bad/" + kind)) {
      SCOPED_TRACE(entry.path().filename().string());
      EXPECT_EXIT(read_under_limits(entry.path().string()), ::testing::ExitedWithCode(0), "");
      ++file_count;
    }
  }
  EXPECT_GT(file_count, 0);
}

}  // namespace
}  // namespace multum::testing
