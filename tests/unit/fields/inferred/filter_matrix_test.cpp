// SPDX-License-Identifier: Apache-2.0
// Tests the file of a filter matrix. Its bytes must be as docs/reference/inferred_textures.md says, and for every kind
// of damage a message must name the fault. The refusal of an incomplete read is not tested, because that needs a disk
// that fails between two reads.
#include "host/fields/inferred/filter_matrix.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/unit/foundation/base/file_limit.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::expect_error;
using testing::Names;
using testing::read_bytes;
using testing::TemporaryFolder;
using testing::write_bytes;

// The matrix is for 3 rows of a 4 x 3 picture; a texture of 5 x 3 has 18 texels. The middle row is empty.
FilterMatrix small_matrix() {
  FilterMatrix m;
  m.width = 4;
  m.height = 3;
  m.supersampling = 2;
  m.texture_width = 5;
  m.texture_height = 3;
  m.wrap_s = WrapMode::kPeriodic;
  m.wrap_t = WrapMode::kMirror;
  m.anisotropy = 2.5f;
  m.has_mips = false;
  m.provenance = {"software \"1\"", "renderer\n2", "view ü", "object", "mesh hash", "matrix hash", "key \\"};
  m.rows_rejected = (std::uint64_t{1} << 33) + 5;
  m.pixels = {1, 6, 11};
  m.coverage = {0.25f, 1.0f, 0.75f};
  m.row_begin = {0, 2, 2, 5};
  m.columns = {0, 17, 3, 4, 16};
  m.weights = {1.0f / 3.0f, 2.0f / 3.0f, 1e-9f, 0.99f, -0.0f};
  return m;
}

void expect_same(const FilterMatrix& found, const FilterMatrix& expected) {
  EXPECT_EQ(found.width, expected.width);
  EXPECT_EQ(found.height, expected.height);
  EXPECT_EQ(found.supersampling, expected.supersampling);
  EXPECT_EQ(found.texture_width, expected.texture_width);
  EXPECT_EQ(found.texture_height, expected.texture_height);
  EXPECT_EQ(found.wrap_s, expected.wrap_s);
  EXPECT_EQ(found.wrap_t, expected.wrap_t);
  EXPECT_EQ(found.anisotropy, expected.anisotropy);
  EXPECT_EQ(found.has_mips, expected.has_mips);
  EXPECT_EQ(found.provenance.software, expected.provenance.software);
  EXPECT_EQ(found.provenance.renderer, expected.provenance.renderer);
  EXPECT_EQ(found.provenance.view, expected.provenance.view);
  EXPECT_EQ(found.provenance.object, expected.provenance.object);
  EXPECT_EQ(found.provenance.mesh_hash, expected.provenance.mesh_hash);
  EXPECT_EQ(found.provenance.view_matrix, expected.provenance.view_matrix);
  EXPECT_EQ(found.rows_rejected, expected.rows_rejected);
  EXPECT_EQ(found.pixels, expected.pixels);
  EXPECT_EQ(found.coverage, expected.coverage);
  EXPECT_EQ(found.row_begin, expected.row_begin);
  EXPECT_EQ(found.columns, expected.columns);
  ASSERT_EQ(found.weights.size(), expected.weights.size());
  if (!found.weights.empty()) {
    EXPECT_EQ(std::memcmp(found.weights.data(), expected.weights.data(), 4 * found.weights.size()), 0) << "every bit";
  }
}

TEST(FilterMatrixTest, EveryFieldComesBack) {
  const TemporaryFolder folder;
  FilterMatrix matrix = small_matrix();
  write_filter_matrix(matrix, folder / "a.filter");
  expect_same(read_filter_matrix(folder / "a.filter"), matrix);
  for (const WrapMode wrap : {WrapMode::kBlack, WrapMode::kClamp, WrapMode::kPeriodic, WrapMode::kMirror}) {
    matrix.wrap_s = wrap;
    matrix.has_mips = !matrix.has_mips;
    write_filter_matrix(matrix, folder / "a.filter");
    expect_same(read_filter_matrix(folder / "a.filter"), matrix);
  }
  EXPECT_EQ(folder.names(), Names{"a.filter"});
}

TEST(FilterMatrixTest, AnObjectOutOfSightHasNoRows) {
  const TemporaryFolder folder;
  FilterMatrix matrix = small_matrix();
  matrix.pixels.clear();
  matrix.coverage.clear();
  matrix.row_begin = {0};
  matrix.columns.clear();
  matrix.weights.clear();
  write_filter_matrix(matrix, folder / "a.filter");
  expect_same(read_filter_matrix(folder / "a.filter"), matrix);
}

// Computes CRC-64/XZ bit by bit. The polynomial is x^64 + x^62 + ... of ECMA-182 in reflected form, and the initial
// value and the final XOR are all ones.
std::uint64_t crc64_xz(const std::string& bytes) {
  std::uint64_t value = ~std::uint64_t{0};
  for (const char byte : bytes) {
    value ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ ((value & 1) != 0 ? 0xc96c5795d7870f42u : 0);
  }
  return ~value;
}

// Holds the three parts of a file, which a test joins in a wrong way.
struct Parts {
  std::string first_line = "multum filter matrix 1";
  nlohmann::json header;
  std::string lists;

  explicit Parts(const FilterMatrix& matrix) {
    const TemporaryFolder folder;
    write_filter_matrix(matrix, folder / "a.filter");
    const std::string bytes = read_bytes(folder / "a.filter");
    const std::size_t head = bytes.find('\n') + 1, body = bytes.find('\n', head) + 1;
    EXPECT_EQ(bytes.substr(0, head), first_line + "\n");
    header = nlohmann::json::parse(bytes.substr(head, body - head));
    lists = bytes.substr(body);
  }
  std::string bytes() const { return first_line + "\n" + header.dump() + "\n" + lists; }
};

TEST(FilterMatrixTest, TheFileIsAsTheFormatPageSays) {
  EXPECT_EQ(crc64_xz("123456789"), 0x995dc9bbdf1939fau) << "the check value of CRC-64/XZ";
  const Parts parts(small_matrix());
  const std::uint32_t expected[] = {1,           6,          11,          // pixels
                                    0x3e800000u, 0x3f800000, 0x3f400000,  // coverage: 1/4, 1, 3/4
                                    0,           2,          2,          5, 0, 17, 3, 4, 16};
  std::string bytes;
  for (const std::uint32_t value : expected)
    for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>(value >> shift & 255u));
  ASSERT_EQ(parts.lists.size(), bytes.size() + 5 * 4);
  EXPECT_EQ(parts.lists.substr(0, bytes.size()), bytes);
  EXPECT_EQ(parts.lists.substr(bytes.size(), 4), "\xab\xaa\xaa\x3e") << "1/3";
  char checksum[17];
  std::snprintf(checksum, sizeof(checksum), "%016llx", static_cast<unsigned long long>(crc64_xz(parts.lists)));
  const nlohmann::json header = {{"width", 4},
                                 {"height", 3},
                                 {"supersampling", 2},
                                 {"textureWidth", 5},
                                 {"textureHeight", 3},
                                 {"wrapS", "periodic"},
                                 {"wrapT", "mirror"},
                                 {"anisotropy", 2.5},
                                 {"hasMips", false},
                                 {"software", "software \"1\""},
                                 {"renderer", "renderer\n2"},
                                 {"view", "view ü"},
                                 {"object", "object"},
                                 {"meshHash", "mesh hash"},
                                 {"viewMatrixHash", "matrix hash"},
                                 {"key", "key \\"},
                                 {"rowsRejected", 8589934597},
                                 {"rows", 3},
                                 {"entries", 5},
                                 {"checksum", checksum}};
  EXPECT_EQ(parts.header, header);
}

// ---- Refusals

class FilterMatrixRefusalTest : public ::testing::Test {
 protected:
  void refuse_bytes(const std::string& bytes, const std::vector<std::string>& words) const {
    const std::string path = folder_ / "bad.filter";
    write_bytes(path, bytes);
    std::vector<std::string> parts = {path + ": "};
    parts.insert(parts.end(), words.begin(), words.end());
    expect_error(ErrorCode::kInput, parts, [&] { read_filter_matrix(path); });
  }
  // The changed matrix is written normally, so that its checksum is right.
  void refuse_matrix(const std::function<void(FilterMatrix&)>& change, const std::string& words) const {
    FilterMatrix matrix = small_matrix();
    change(matrix);
    SCOPED_TRACE(words);
    refuse_bytes(Parts(matrix).bytes(), {words});
  }
  void refuse_header(const std::string& key, const nlohmann::json& value, const std::vector<std::string>& said) const {
    Parts parts = whole_;
    parts.header[key] = value;
    SCOPED_TRACE(key + " = " + value.dump());
    refuse_bytes(parts.bytes(), said);
  }
  const TemporaryFolder folder_;
  const Parts whole_ = Parts(small_matrix());
};

TEST_F(FilterMatrixRefusalTest, OtherFiles) {
  expect_error(ErrorCode::kInput, {folder_ / "none", "cannot be read"}, [&] { read_filter_matrix(folder_ / "none"); });
  expect_error(ErrorCode::kInput, {folder_.path(), "is a folder"}, [&] { read_filter_matrix(folder_.path()); });
  for (const char* first_line :
       {"", "multum filter matrix 2", "multum filter matrix 1 ", "%%MatrixMarket", "\x89PNG"}) {
    Parts parts = whole_;
    parts.first_line = first_line;
    refuse_bytes(parts.bytes(), {"not a filter matrix", "first line", "'multum filter matrix 1'"});
  }
  refuse_bytes("", {"not a filter matrix"});
}

TEST_F(FilterMatrixRefusalTest, HeadersThatAreDamaged) {
  refuse_bytes("multum filter matrix 1", {"header", "damaged"});
  refuse_bytes("multum filter matrix 1\n", {"header", "damaged"});
  refuse_bytes("multum filter matrix 1\n{\"width\": 4,\n" + whole_.lists, {"header", "damaged", "parse error"});
  refuse_bytes("multum filter matrix 1\n[]\n" + whole_.lists, {"header", "damaged"});
  for (const auto& [key, value] : whole_.header.items()) {
    SCOPED_TRACE(key);
    Parts missing = whole_;
    missing.header.erase(key);
    refuse_bytes(missing.bytes(), {"header", "damaged", "'" + key + "' not found"});
    refuse_header(key, value.is_string() ? nlohmann::json(4) : nlohmann::json("4"), {"header", "damaged"});
  }
  for (const char* key : {"wrapS", "wrapT"})
    for (const char* name : {"", "Clamp", "repeat"}) refuse_header(key, name, {"header", "unknown wrap mode"});
}

TEST_F(FilterMatrixRefusalTest, HeadersOutOfRange) {
  for (const char* key : {"width", "height", "textureWidth", "textureHeight"})
    for (const int side : {0, -4, 16385}) refuse_header(key, side, {"side", std::to_string(side), "1 to 16384"});
  for (const int value : {0, -1, 9})
    refuse_header("supersampling", value, {"supersampling", std::to_string(value), "1 to 8"});
  for (const double value : {0.0, 0.5, -1.0, 16.5}) refuse_header("anisotropy", value, {"1 to 16"});
}

TEST_F(FilterMatrixRefusalTest, FilesCutShort) {
  const std::string bytes = whole_.bytes();
  const std::size_t lists = bytes.size() - whole_.lists.size();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    SCOPED_TRACE(size);
    const char* words = size < whole_.first_line.size() ? "not a filter matrix"
                        : size + 1 < lists              ? "header is damaged"
                                                        : "incomplete";
    refuse_bytes(bytes.substr(0, size), {words});
  }
  refuse_bytes(bytes + "x", {"incomplete", "81 bytes", "80", "3 rows", "5 entries"});
  refuse_header("rows", 4, {"92", "4 rows", "5 entries"});
  refuse_header("entries", 4, {"72", "3 rows", "4 entries"});
  // These sizes would overflow or take all memory.
  for (const char* key : {"rows", "entries"})
    for (const std::uint64_t count : {std::uint64_t{1} << 31, (std::uint64_t{1} << 31) + 1, std::uint64_t{1} << 62,
                                      std::numeric_limits<std::uint64_t>::max()})
      refuse_header(key, count, {"incomplete"});
}

TEST_F(FilterMatrixRefusalTest, AFlippedBitInAnyByteOfTheLists) {
  for (std::size_t i = 0; i < whole_.lists.size(); ++i) {
    SCOPED_TRACE(i);
    Parts damaged = whole_;
    damaged.lists[i] = static_cast<char>(damaged.lists[i] ^ (1 << (i * 5 % 8)));
    refuse_bytes(damaged.bytes(), {"damaged", "checksum"});
  }
  refuse_header("checksum", "0000000000000000", {"damaged", "checksum"});
}

TEST_F(FilterMatrixRefusalTest, ContentsThatAreNoMatrix) {
  refuse_matrix([](FilterMatrix& m) { m.row_begin = {1, 2, 2, 5}; }, "its rows do not cover all entries");
  refuse_matrix([](FilterMatrix& m) { m.row_begin = {0, 2, 2, 4}; }, "its rows do not cover all entries");
  refuse_matrix([](FilterMatrix& m) { m.row_begin = {0, 2, 2, 6}; }, "its rows do not cover all entries");
  refuse_matrix([](FilterMatrix& m) { m.row_begin = {0, 3, 2, 5}; }, "row 1 ends before it begins");
  refuse_matrix([](FilterMatrix& m) { m.row_begin = {0, 2, 4000000000u, 5}; }, "row 2 ends before it begins");
  refuse_matrix([](FilterMatrix& m) { m.pixels[2] = 12; }, "row 2 is for a pixel outside the picture");
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
  for (const float coverage : {0.0f, -0.5f, 1.0001f, kNan, kInf})
    refuse_matrix([&](FilterMatrix& m) { m.coverage[1] = coverage; }, "row 1 has coverage ");
  refuse_matrix([](FilterMatrix& m) { m.columns[1] = 18; }, "entry 1 is for texel 18 of 18");
  refuse_matrix([](FilterMatrix& m) { m.columns[0] = 0xffffffffu; }, "entry 0 is for texel 4294967295 of 18");
  for (const float weight : {kNan, kInf, -kInf})
    refuse_matrix([&](FilterMatrix& m) { m.weights[3] = weight; }, "entry 3 is not finite");
}

// ---- Matrix Market

TEST(MatrixMarketTest, TheTextHoldsTheSameEntries) {
  const TemporaryFolder folder;
  const FilterMatrix matrix = small_matrix();
  write_matrix_market(matrix, folder / "a.mtx");
  EXPECT_EQ(folder.names(), Names{"a.mtx"});
  std::istringstream text(read_bytes(folder / "a.mtx"));
  std::string line, comments;
  ASSERT_TRUE(std::getline(text, line));
  EXPECT_EQ(line, "%%MatrixMarket matrix coordinate real general");
  while (text.peek() == '%') {
    ASSERT_TRUE(std::getline(text, line));
    comments += line + "\n";
  }
  // A line break in the name of the renderer would end the comment.
  for (const char* words : {"4 x 3", "'object'", "'view ü'", "5 x 3", "software \"1\"", "renderer 2\n"})
    EXPECT_NE(comments.find(words), std::string::npos) << words << " is not in\n" << comments;
  std::size_t rows = 0, columns = 0, entries = 0;
  ASSERT_TRUE(text >> rows >> columns >> entries);
  EXPECT_EQ(rows, 3u);
  EXPECT_EQ(columns, 18u);
  ASSERT_EQ(entries, 5u);
  for (std::size_t r = 0; r < 3; ++r)
    for (std::uint32_t i = matrix.row_begin[r]; i < matrix.row_begin[r + 1]; ++i) {
      std::size_t row = 0, column = 0;
      std::string value;
      ASSERT_TRUE(text >> row >> column >> value);
      EXPECT_EQ(row, r + 1);
      EXPECT_EQ(column, matrix.columns[i] + 1);
      EXPECT_EQ(std::strtof(value.c_str(), nullptr), matrix.weights[i]) << "nine digits identify a float";
    }
  EXPECT_FALSE(text >> line) << line;
}

// ---- Places that cannot be written

TEST(FilterMatrixTest, NothingStaysOfWhatCannotBeWritten) {
  const TemporaryFolder folder;
  const FilterMatrix matrix = small_matrix();
  for (const auto write : {write_filter_matrix, write_matrix_market}) {
    expect_error(ErrorCode::kEnvironment, {folder / "none/a", "does not exist"},
                 [&] { write(matrix, folder / "none/a"); });
    expect_error(ErrorCode::kUsage, {folder.path(), "is a folder"}, [&] { write(matrix, folder.path()); });
  }
  EXPECT_EQ(folder.names(), Names{});
  write_filter_matrix(matrix, folder / "a.filter");
  const auto size = static_cast<rlim_t>(std::filesystem::file_size(folder / "a.filter"));
  // A limit on file sizes acts like a full disk. The earlier file is kept.
  write_bytes(folder / "a.filter", "old");
  for (const rlim_t bytes : {rlim_t{0}, rlim_t{100}, size - 1}) {
    const testing::FileLimit full(bytes);
    expect_error(ErrorCode::kEnvironment, {folder / "a.filter", "writing failed"},
                 [&] { write_filter_matrix(matrix, folder / "a.filter"); });
  }
  EXPECT_EQ(folder.names(), Names{"a.filter"});
  EXPECT_EQ(read_bytes(folder / "a.filter"), "old");
}

}  // namespace
}  // namespace multum
