// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inferred/filter_matrix.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "host/fields/inferred/texture_mapping.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/checksum.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/files/output_file.h"
#include "host/foundation/base/files/regular_file.h"

namespace multum {
namespace {

// The file contains this line, one line of JSON, and the five lists as little-endian 32-bit values.
constexpr const char* kFirstLine = "multum filter matrix 1";
constexpr std::uint64_t kEntriesMax = std::uint64_t{1} << 31;

// Calls `visit` with each list.
template <typename Matrix, typename Visit>
void for_each_list(Matrix& m, const Visit& visit) {
  visit(m.pixels);
  visit(m.coverage);
  visit(m.row_begin);
  visit(m.columns);
  visit(m.weights);
}

std::string checksum_of(const FilterMatrix& matrix) {
  Checksum checksum;
  for_each_list(matrix, [&](const auto& list) { checksum.update(list.data(), list.size() * 4); });
  return checksum.text();
}

nlohmann::json full_header(const FilterMatrix& m) {
  const FilterMatrixProvenance& p = m.provenance;
  return {{"width", m.width},
          {"height", m.height},
          {"supersampling", m.supersampling},
          {"textureWidth", m.texture_width},
          {"textureHeight", m.texture_height},
          {"wrapS", wrap_mode_name(m.wrap_s)},
          {"wrapT", wrap_mode_name(m.wrap_t)},
          {"anisotropy", m.anisotropy},
          {"hasMips", m.has_mips},
          {"software", p.software},
          {"renderer", p.renderer},
          {"view", p.view},
          {"object", p.object},
          {"meshHash", p.mesh_hash},
          {"viewMatrixHash", p.view_matrix},
          {"key", p.key},
          {"rowsRejected", m.rows_rejected},
          {"rows", m.row_count()},
          {"entries", m.columns.size()},
          {"checksum", checksum_of(m)}};
}

std::uint64_t count_of(const nlohmann::json& json, const char* key) {
  const nlohmann::json& count = json.at(key);
  if (count.is_number_unsigned()) return count.get<std::uint64_t>();
  return static_cast<std::uint64_t>(json_integer(json, key, 0, INT64_MAX));
}

void read_header(const nlohmann::json& json, FilterMatrix& m) {
  m.width = json_int(json, "width");
  m.height = json_int(json, "height");
  m.supersampling = json_int(json, "supersampling");
  m.texture_width = json_int(json, "textureWidth");
  m.texture_height = json_int(json, "textureHeight");
  m.wrap_s = parse_wrap_mode(json.at("wrapS").get<std::string>()).value();
  m.wrap_t = parse_wrap_mode(json.at("wrapT").get<std::string>()).value();
  m.anisotropy = json.at("anisotropy").get<float>();
  m.has_mips = json.at("hasMips").get<bool>();
  FilterMatrixProvenance& p = m.provenance;
  p.software = json.at("software").get<std::string>();
  p.renderer = json.at("renderer").get<std::string>();
  p.view = json.at("view").get<std::string>();
  p.object = json.at("object").get<std::string>();
  p.mesh_hash = json.at("meshHash").get<std::string>();
  p.view_matrix = json.at("viewMatrixHash").get<std::string>();
  p.key = json.at("key").get<std::string>();
  m.rows_rejected = count_of(json, "rowsRejected");
}

// Checks everything that the solver assumes.
void check_contents(const FilterMatrix& m, const std::string& path) {
  for (int side : {m.width, m.height, m.texture_width, m.texture_height})
    if (side < 1 || side > kGpuSideMax)
      refuse_file(path, fmt::format("a side is {}, expected 1 to {}", side, kGpuSideMax));
  if (m.supersampling < 1 || m.supersampling > 8)
    refuse_file(path, fmt::format("its supersampling is {}, expected 1 to 8", m.supersampling));
  if (!(m.anisotropy >= 1.0f && m.anisotropy <= 16.0f))
    refuse_file(path, fmt::format("its anisotropy is {}, expected 1 to 16", m.anisotropy));
  const auto texels = static_cast<std::uint32_t>(m.layout().texel_count);
  const auto pixel_count = static_cast<std::uint32_t>(m.width) * static_cast<std::uint32_t>(m.height);
  if (m.row_begin.front() != 0 || m.row_begin.back() != m.columns.size())
    refuse_file(path, "its rows do not cover all entries");
  for (std::size_t r = 0; r < m.row_count(); ++r) {
    if (m.row_begin[r] > m.row_begin[r + 1]) refuse_file(path, fmt::format("row {} ends before it begins", r));
    if (m.pixels[r] >= pixel_count) refuse_file(path, fmt::format("row {} is for a pixel outside the picture", r));
    if (!(m.coverage[r] > 0.0f && m.coverage[r] <= 1.0f))
      refuse_file(path, fmt::format("row {} has coverage {}, expected above 0 and at most 1", r, m.coverage[r]));
  }
  for (std::size_t i = 0; i < m.columns.size(); ++i) {
    if (m.columns[i] >= texels)
      refuse_file(path, fmt::format("entry {} is for texel {} of {}", i, m.columns[i], texels));
    if (!std::isfinite(m.weights[i])) refuse_file(path, fmt::format("entry {} is not finite", i));
  }
}

// Replaces line breaks, because a comment ends with its line and names from glTF files may contain any character.
std::string in_one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  return text;
}

}  // namespace

void write_filter_matrix(const FilterMatrix& matrix, const std::string& path) {
  AtomicFile file(path);
  OutputFile out(file);
  const std::string head = std::string(kFirstLine) + "\n" + json_text(full_header(matrix)) + "\n";
  write_or_throw(out, head.data(), head.size());
  for_each_list(matrix, [&](const auto& list) { write_or_throw(out, list.data(), list.size() * 4); });
  out.close();
  file.commit();
}

FilterMatrix read_filter_matrix(const std::string& path) {
  RegularFileStream file(path);
  std::string first, header;
  if (!file) refuse_file(path, "cannot be read");
  if (!std::getline(file, first) || first != kFirstLine)
    refuse_file(path, fmt::format("is not a filter matrix: its first line is not '{}'", kFirstLine));
  std::getline(file, header);
  FilterMatrix m;
  std::string checksum;
  try {
    if (holds_nul(header)) refuse_file(path, "has a NUL in its header");
    const nlohmann::json json = nlohmann::json::parse(header);
    read_header(json, m);
    const std::uint64_t rows = count_of(json, "rows"), entries = count_of(json, "entries");
    checksum = json.at("checksum").get<std::string>();
    const auto begin = file.tellg();
    file.seekg(0, std::ios::end);
    const auto bytes = static_cast<std::uint64_t>(file.tellg() - begin);
    if (rows > kEntriesMax || entries > kEntriesMax || bytes != 4 * (3 * rows + 1 + 2 * entries))
      refuse_file(
          path, fmt::format("is incomplete or damaged: found lists of {} bytes, expected {} for {} rows and {} entries",
                            bytes, 4 * (3 * rows + 1 + 2 * entries), rows, entries));
    file.seekg(begin);
    m.pixels.resize(rows);
    m.coverage.resize(rows);
    m.row_begin.resize(rows + 1);
    m.columns.resize(entries);
    m.weights.resize(entries);
  } catch (const nlohmann::json::exception& error) {
    refuse_file(path, std::string("its header is damaged: ") + error.what());
  } catch (const Error& error) {
    if (std::string_view(error.what()).starts_with(path)) throw;
    refuse_file(path, std::string("its header is damaged: ") + error.what());
  } catch (const std::bad_optional_access&) {
    refuse_file(path, "its header names an unknown wrap mode");
  }
  for_each_list(m, [&](auto& list) {
    file.read(reinterpret_cast<char*>(list.data()), static_cast<std::streamsize>(list.size() * 4));
  });
  if (!file) refuse_file(path, "cannot be read completely");
  if (checksum_of(m) != checksum) refuse_file(path, "is damaged: its checksum differs from the one in its header");
  check_contents(m, path);
  return m;
}

std::string filter_matrix_key(const std::string& path) {
  RegularFileStream file(path);
  std::string first, header;
  if (!std::getline(file, first) || first != kFirstLine || !std::getline(file, header)) return "";
  const nlohmann::json json = nlohmann::json::parse(header, nullptr, false);
  return json.is_object() && json.contains("key") && json["key"].is_string() ? json["key"].get<std::string>() : "";
}

void write_matrix_market(const FilterMatrix& matrix, const std::string& path) {
  std::string text = fmt::format(
      "%%MatrixMarket matrix coordinate real general\n"
      "% rows: pixels of {} x {} that '{}' covers in view '{}'; columns: texels of {} x {} and its mip levels\n"
      "% {}; {}\n"
      "{} {} {}\n",
      matrix.width, matrix.height, in_one_line(matrix.provenance.object), in_one_line(matrix.provenance.view),
      matrix.texture_width, matrix.texture_height, in_one_line(matrix.provenance.software),
      in_one_line(matrix.provenance.renderer), matrix.row_count(), matrix.layout().texel_count, matrix.columns.size());
  for (std::size_t r = 0; r < matrix.row_count(); ++r)
    for (std::uint32_t i = matrix.row_begin[r]; i < matrix.row_begin[r + 1]; ++i)
      fmt::format_to(std::back_inserter(text), "{} {} {:.9g}\n", r + 1, matrix.columns[i] + 1, matrix.weights[i]);
  write_text_file(path, text);
}

}  // namespace multum
