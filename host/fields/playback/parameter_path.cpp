// SPDX-License-Identifier: Apache-2.0
#include "host/fields/playback/parameter_path.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cmath>
#include <numbers>
#include <string_view>

#include "host/foundation/base/error.h"
#include "host/foundation/base/nearest_name.h"

namespace multum {
namespace {

constexpr std::size_t kTextMax = 4096;  // limit in characters, far more than any user writes
constexpr int kDepthMax = 64;           // most nested parentheses and signs; each is a recursive call of the parser

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n'; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

}  // namespace

class PathParser {
 public:
  PathParser(const std::string& text, ParameterPath& path) : text_(text), path_(path) {}

  void parse() {
    if (text_.size() > kTextMax)
      throw Error(ErrorCode::kUsage, fmt::format("path: has {} characters, expected up to {}", text_.size(), kTextMax));
    path_.values_.resize(path_.names_.size());
    do {
      auto& steps = path_.values_[parameter()];
      steps_ = &steps;
      sum(0);
      if (takes("..")) {
        sum(0);
        add(ParameterPath::Kind::kBetween);
      }
    } while (takes(","));
    skip_spaces();
    if (at_ < text_.size()) refuse("an operator, '..', ',' or the end");
  }

 private:
  using Kind = ParameterPath::Kind;

  [[noreturn]] void refuse(const std::string& expected) const {
    const std::string found = at_ < text_.size() ? fmt::format("'{}'", text_.substr(at_, 12)) : "the end";
    throw Error(ErrorCode::kUsage,
                fmt::format("path '{}': found {} at character {}, expected {}", text_, found, at_ + 1, expected));
  }
  void skip_spaces() {
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  }
  bool takes(std::string_view token) {
    skip_spaces();
    if (std::string_view(text_).substr(at_, token.size()) != token) return false;
    at_ += token.size();
    return true;
  }
  void expect(std::string_view token) {
    if (!takes(token)) refuse(fmt::format("'{}'", token));
  }
  void add(Kind kind, double number = 0.0) { steps_->push_back({kind, number}); }

  /// Reads a parameter's name and '=', and returns the parameter's number.
  std::size_t parameter() {
    skip_spaces();
    const std::size_t end = text_.find('=', at_);
    if (end == std::string::npos) refuse("NAME=VALUE");
    const std::string name(trimmed(std::string_view(text_).substr(at_, end - at_)));
    for (std::size_t p = 0; p < path_.names_.size(); ++p) {
      if (path_.names_[p] != name) continue;
      if (!path_.values_[p].empty())
        throw Error(ErrorCode::kUsage, fmt::format("path '{}': has '{}' twice, expected it once", text_, name));
      at_ = end + 1;
      return p;
    }
    const std::string nearest = nearest_name(name, path_.names_);
    throw Error(ErrorCode::kUsage, fmt::format("path '{}': unknown parameter '{}'{}, expected one of: {}", text_, name,
                                               nearest.empty() ? "" : " (did you mean '" + nearest + "'?)",
                                               fmt::join(path_.names_, ", ")));
  }

  void sum(int depth) {
    product(depth);
    while (true) {
      if (takes("+")) {
        product(depth);
        add(Kind::kAdd);
      } else if (takes("-")) {
        product(depth);
        add(Kind::kSubtract);
      } else return;
    }
  }
  void product(int depth) {
    factor(depth);
    while (true) {
      if (takes("*")) {
        factor(depth);
        add(Kind::kMultiply);
      } else if (takes("/")) {
        factor(depth);
        add(Kind::kDivide);
      } else return;
    }
  }
  void factor(int depth) {
    if (depth > kDepthMax) refuse(fmt::format("at most {} levels of parentheses and signs", kDepthMax));
    if (takes("-")) {
      factor(depth + 1);
      return add(Kind::kNegate);
    }
    if (takes("(")) {
      sum(depth + 1);
      return expect(")");
    }
    skip_spaces();
    if (at_ < text_.size() && (is_digit(text_[at_]) || text_[at_] == '.')) return number();
    const std::size_t begin = at_;
    while (at_ < text_.size() && text_[at_] >= 'a' && text_[at_] <= 'z') ++at_;
    const std::string_view word = std::string_view(text_).substr(begin, at_ - begin);
    if (word == "t") return add(Kind::kTime);
    if (word == "pi") return add(Kind::kNumber, std::numbers::pi);
    if (word != "sin" && word != "cos") {
      at_ = begin;
      refuse("a number, t, pi, sin, cos, '-' or '('");
    }
    const Kind kind = word == "sin" ? Kind::kSin : Kind::kCos;
    expect("(");
    sum(depth + 1);
    expect(")");
    add(kind);
  }
  static bool is_digit(char c) { return c >= '0' && c <= '9'; }

  /// Reads digits with at most one point. The point must not be the first of a range's two points.
  void number() {
    const std::size_t begin = at_;
    const auto digits = [&] {
      while (at_ < text_.size() && is_digit(text_[at_])) ++at_;
    };
    digits();
    if (at_ < text_.size() && text_[at_] == '.' && text_.compare(at_, 2, "..") != 0) {
      ++at_;
      digits();
    }
    double value = 0.0;
    const auto [end, error] = std::from_chars(text_.data() + begin, text_.data() + at_, value);
    if (error != std::errc() || end != text_.data() + at_) {
      at_ = begin;
      refuse("a number");
    }
    add(Kind::kNumber, value);
  }

  const std::string& text_;
  ParameterPath& path_;
  std::vector<ParameterPath::Step>* steps_ = nullptr;
  std::size_t at_ = 0;
};

ParameterPath::ParameterPath(const std::string& text, const std::vector<std::string>& names) : names_(names) {
  PathParser(text, *this).parse();
}

std::vector<double> ParameterPath::at(const PathTime& time) const {
  std::vector<double> result;
  for (std::size_t p = 0; p < values_.size(); ++p) {
    std::vector<double> stack = {0.0};  // bottom of the stack: the value if there are no steps
    const auto pop = [&] {
      const double value = stack.back();
      stack.pop_back();
      return value;
    };
    for (const Step& step : values_[p]) {
      if (step.kind == Kind::kNumber || step.kind == Kind::kTime) {
        stack.push_back(step.kind == Kind::kTime ? time.seconds : step.number);
        continue;
      }
      const double last = pop();
      switch (step.kind) {
        case Kind::kNegate: stack.push_back(-last); continue;
        case Kind::kSin: stack.push_back(std::sin(last)); continue;
        case Kind::kCos: stack.push_back(std::cos(last)); continue;
        default: break;
      }
      const double first = pop();
      switch (step.kind) {
        case Kind::kAdd: stack.push_back(first + last); break;
        case Kind::kSubtract: stack.push_back(first - last); break;
        case Kind::kMultiply: stack.push_back(first * last); break;
        case Kind::kDivide: stack.push_back(first / last); break;
        default: stack.push_back(first + (last - first) * time.share);
      }
    }
    result.push_back(stack.back());
    if (!std::isfinite(result.back()))
      throw Error(ErrorCode::kUsage, fmt::format("path: '{}' is {} at t = {}, expected a finite number", names_[p],
                                                 result.back(), time.seconds));
  }
  return result;
}

}  // namespace multum
