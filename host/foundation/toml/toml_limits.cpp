// SPDX-License-Identifier: Apache-2.0
// Cuts the text into keys, headers and values in the same way as toml++. At the first error, toml++ stops. So it does
// not matter how the scan divides the text after an error.
//
//     [a.b]                              depth 2                          items 1 (the table) + 2
//     c.d = [1, {e.f = "x.y"}]  # g.h    depth 2 + 2 + 1 (array) + 1 (table) + 2    items + 2 + 1 + 1 + 1 + 2 + 1
#include "host/foundation/toml/toml_limits.h"

#include <algorithm>
#include <cstdint>
#include <set>
#include <vector>

#include <fmt/format.h>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

class TomlScan {
 public:
  TomlScan(const std::string& path, std::string_view text, const TomlLimits& limits)
      : path_(path), text_(text), limits_(limits) {}

  void run() {
    if (text_.starts_with("\xef\xbb\xbf")) at_ = 3;  // byte order mark
    while (at_ < text_.size()) step();
  }

 private:
  // An open element: the document, or an array or inline table in it.
  struct Level {
    bool is_table;
    int key_parts = 0;  // parts of the current key, or of the key of the current value
  };

  void step() {
    const char c = text_[at_];
    switch (c) {
      case '\n': end_line(); return;
      case ' ':
      case '\t':
      case '\r': ++at_; return;
      case '#': at_ = std::min(text_.find('\n', at_), text_.size()); return;
      case '"':
      case '\'':
        skip_string(c);
        count_token();
        return;
      case '.':
      case '=': separate(c); return;
      case ',':
        ++at_;
        if (open_.size() > 1 && open_.back().is_table) begin_key();
        return;
      case '[':
      case '{': open(c); return;
      case ']':
      case '}': close(); return;
      default:
        at_ = std::min(text_.find_first_of(in_key_ ? " \t\r\n.=,[]{}#\"'" : " \t\r\n,[]{}#\"'", at_), text_.size());
        count_token();
    }
  }

  void end_line() {
    ++at_;
    ++line_;
    if (open_.size() > 1) return;  // the array continues
    in_header_ = false;
    begin_key();
  }

  void begin_key() {
    depth_ -= open_.back().key_parts;
    open_.back().key_parts = 0;
    in_key_ = true;
  }

  // Handles '.' and '=' in a key. In values, these characters have no meaning. Values that begin with one of them are
  // also handled here.
  void separate(char c) {
    ++at_;
    if (in_key_ && c == '.' && ++dots_ > limits_.dot_max) refuse("dots in keys and headers", limits_.dot_max);
    if (c == '=') in_key_ = false;
  }

  // Counts a part of a key or header, or a value.
  void count_token() {
    count_item();
    if (!in_key_) return;
    int& parts = in_header_ ? header_parts_ : open_.back().key_parts;
    if (++parts > limits_.key_part_max)
      refuse(in_header_ ? "parts of a table's name" : "parts of a dotted key", limits_.key_part_max);
    deepen();
  }

  void count_item() {
    if (++items_ > limits_.item_max) refuse("keys and values", limits_.item_max);
  }

  void deepen() {
    if (++depth_ > limits_.depth_max) refuse("levels of nested tables and arrays", limits_.depth_max);
  }

  void open(char c) {
    count_item();
    if (c == '[' && in_key_ && !in_header_ && open_.size() == 1 && open_.back().key_parts == 0) {
      begin_header();
      return;
    }
    ++at_;
    deepen();
    open_.push_back({c == '{'});
    in_key_ = c == '{';
  }

  // Begins [name] or [[name]]. The keys that follow belong to this table.
  void begin_header() {
    is_array_of_tables_ = text_.substr(at_, 2) == "[[";
    at_ += is_array_of_tables_ ? 2 : 1;
    header_begin_ = at_;
    depth_ -= header_parts_;
    header_parts_ = 0;
    in_header_ = true;
  }

  void close() {
    if (in_header_ && is_array_of_tables_) {
      array_names_.insert(text_.substr(header_begin_, at_ - header_begin_));
      if (array_names_.size() > limits_.array_name_max) refuse("names of [[tables]]", limits_.array_name_max);
    }
    ++at_;
    in_header_ = false;
    if (open_.size() == 1) return;
    depth_ -= 1 + open_.back().key_parts;
    open_.pop_back();
    in_key_ = false;
  }

  // Moves at_ from the opening quote past the closing one. An unclosed string ends with its line, or with the text.
  void skip_string(char quote) {
    const std::string three(3, quote);
    const bool is_multi_line = text_.substr(at_, 3) == three;
    const bool has_escapes = quote == '"';
    for (at_ += is_multi_line ? 3 : 1; at_ < text_.size(); ++at_) {
      if (text_[at_] == '\n') {
        if (!is_multi_line) return;
        ++line_;
      } else if (text_[at_] == '\\' && has_escapes) {
        if (at_ + 1 < text_.size() && text_[at_ + 1] != '\n') ++at_;
      } else if (text_[at_] == quote && !is_multi_line) {
        ++at_;
        return;
      } else if (text_[at_] == quote && text_.substr(at_, 3) == three) {
        // Up to two more quotes belong to the string.
        at_ += 3;
        for (int more = 0; more < 2 && at_ < text_.size() && text_[at_] == quote; ++more) ++at_;
        return;
      }
    }
  }

  template <typename Number>
  [[noreturn]] void refuse(const char* what, Number most) const {
    throw Error(ErrorCode::kInput,
                fmt::format("{}:{}: found more than {} {}, expected at most {}", path_, line_, most, what, most));
  }

  const std::string& path_;
  const std::string_view text_;
  const TomlLimits& limits_;
  std::size_t at_ = 0;
  std::uint64_t line_ = 1;
  std::vector<Level> open_ = {{true}};
  bool in_key_ = true;
  bool in_header_ = false;
  bool is_array_of_tables_ = false;
  std::size_t header_begin_ = 0;
  int header_parts_ = 0;
  int depth_ = 0;  // parts of the header, plus parts of the key of each open level, plus brackets
  std::size_t items_ = 0, dots_ = 0;
  std::set<std::string_view> array_names_;
};

}  // namespace

void check_toml_limits(const std::string& path, std::string_view text, const TomlLimits& limits) {
  if (text.size() > limits.byte_max)
    throw Error(ErrorCode::kInput, fmt::format("{}: found more than {} bytes, expected at most {}", path,
                                               limits.byte_max, limits.byte_max));
  TomlScan(path, text, limits).run();
}

}  // namespace multum
