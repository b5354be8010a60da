// SPDX-License-Identifier: Apache-2.0
#include "host/target/tradeoff_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "host/html/html_page.h"

namespace multum {
namespace {

constexpr const char* kTradeoffStyle = R"(
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(22rem, 100%), 1fr)); gap: 1.4rem; }
.plots svg { max-width: none; } svg .axis { stroke: var(--line); } svg .front { fill: none; stroke: var(--text);
  stroke-width: 1.4; } svg .grid { stroke: var(--line); stroke-dasharray: 2 3; } svg .mark { stroke-width: 1.4;
  stroke: var(--soft); fill: var(--back); } svg .onfront { fill: var(--heat); stroke: var(--heat); }
svg .over { opacity: .3; }
svg .title { fill: var(--text); font-weight: 600; }
pre { overflow-x: auto; padding: .5rem .7rem; border: 1px solid var(--line); font-size: .88rem; margin: .4rem 0; }
code { font-size: .92em; } .pictures { display: grid; gap: .9rem;
  grid-template-columns: repeat(auto-fill, minmax(min(15rem, 100%), 1fr)); }
.pictures img { width: 100%; image-rendering: auto; }
table.sortable th { cursor: pointer; } table.sortable th[aria-sort]::after { content: " \25B2"; }
table.sortable th[aria-sort=descending]::after { content: " \25BC"; }
table.sortable { font-size: .86rem; }
table.sortable th, table.sortable td { padding-left: .35rem; padding-right: .35rem; }
table.sortable td.text:first-child { min-width: 11rem; }
@media print { .plots { grid-template-columns: 1fr 1fr; } pre { white-space: pre-wrap; } table { font-size: 7.5pt; } }
)";

// A click on a head sorts by that column, another the other way; cells without a number come last.
constexpr const char* kScript = R"(<script>
for (const table of document.querySelectorAll("table.sortable"))
  table.rows[0].querySelectorAll("th").forEach((head, column) => {
    head.tabIndex = 0;
    const sort = () => {
      const up = head.getAttribute("aria-sort") !== "ascending";
      table.querySelectorAll("th").forEach(other => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", up ? "ascending" : "descending");
      const isText = head.classList.contains("text");
      const key = row => {
        const text = row.cells[column].textContent, number = parseFloat(text);
        return isText ? text : isNaN(number) ? Infinity * (up ? 1 : -1) : number;
      };
      const rows = [...table.rows].slice(1);
      rows.sort((a, b) => (key(a) < key(b) ? -1 : key(a) > key(b) ? 1 : 0) * (up ? 1 : -1));
      rows.forEach(row => row.parentNode.appendChild(row));
    };
    head.onclick = sort;
    head.onkeydown = event => { if (event.key === "Enter") sort(); };
  });
</script>
)";

std::string base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= bytes.size() - i ? kDigits[group >> (18 - 6 * k) & 63u] : '=';
  }
  return text;
}

std::string percent(double share) { return fmt::format("{:.2f}", 100.0 * share); }
std::string percent_if(double share) { return share < 0.0 ? "-" : percent(share); }
std::string millis(double seconds) { return fmt::format("{:.0f}", 1e3 * seconds); }
constexpr double kMiB = 1 << 20;
std::string mebi(std::uint64_t bytes) { return fmt::format("{:.2f}", static_cast<double>(bytes) / kMiB); }

// "12.3 +- 0.1 %, 14.1 % in its picture".
std::string errors_text(const TradeoffRow& row) {
  return error_text(row.reached.error, row.reached.confidence) +
         (row.rendered < 0.0 ? "" : fmt::format(", {} % in its picture", percent(row.rendered)));
}

// "33 MiB on the GPU, 20 ms a frame": the budgets that are set.
std::string budgets_text(const TradeoffJob& job) {
  std::vector<std::string> parts;
  if (job.bytes_max) parts.push_back(fmt::format("{:.4g} MiB on the GPU", static_cast<double>(*job.bytes_max) / kMiB));
  if (job.frame_ms_max) parts.push_back(fmt::format("{:.4g} ms a frame", *job.frame_ms_max));
  if (job.bake_seconds_max) parts.push_back(fmt::format("{:.4g} ms of baking", 1e3 * *job.bake_seconds_max));
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string fitting_text(const TradeoffResult& result) {
  return fmt::format("{} of {} settings",
                     std::count_if(result.rows.begin(), result.rows.end(),
                                   [](const TradeoffRow& row) { return row.is_measured && row.fits; }),
                     result.setting_count());
}

bool is_asked(const TradeoffJob& job) { return job.error || job.bake_seconds || job.has_budget(); }

std::string map_name(const TradeoffJob& job) { return std::filesystem::path(job.bake.input).filename().string(); }

// In quotes where a shell would not take it as one word.
std::string shell_word(const std::string& text) {
  const bool is_plain = !text.empty() && text.find_first_not_of(
                                             "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                             "0123456789_./-+:=,@") == std::string::npos;
  if (is_plain) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string bake_command(const TradeoffJob& job, const TradeoffRow& row) {
  const std::string name = map_name(job), stem = std::filesystem::path(name).stem().string();
  std::string command =
      fmt::format("multum bake {} {} -o {}", shell_word(name), row.options, shell_word(stem + ".ndf.exr"));
  if (job.has_roughness())
    command += std::string(job.bake.roughness_is_gloss ? " --gloss " : " --roughness ") +
               shell_word(std::filesystem::path(job.bake.roughness).filename().string());
  // What the map was read with, where that was said.
  if (job.bake.reading.green) command += *job.bake.reading.green == GreenAxis::kUp ? " --green up" : " --green down";
  if (!row.view.empty())
    command += fmt::format("\nmultum-view {} {} -o picture.png", shell_word(stem + ".ndf.exr"), row.view);
  return command;
}

// A cost, as a plot and a table have it.
struct Cost {
  const char* title;  // of the plot
  const char* axis;
  std::function<double(const TradeoffRow&)> of;  // > 0 where there is one
  bool TradeoffRow::*front;
};

const std::vector<Cost>& costs() {
  static const std::vector<Cost> all = {
      {"Bake time", "milliseconds", [](const TradeoffRow& row) { return 1e3 * row.bake_seconds; },
       &TradeoffRow::on_time_front},
      {"Memory on the GPU", "MiB", [](const TradeoffRow& row) { return static_cast<double>(row.gpu_bytes) / kMiB; },
       &TradeoffRow::on_size_front},
      {"Frame time", "milliseconds", [](const TradeoffRow& row) { return row.frame_ms; },
       &TradeoffRow::on_frame_front}};
  return all;
}

// 1, 2 and 5 times powers of ten that lie in the range: ticks of a logarithmic axis.
std::vector<double> ticks(double low, double high) {
  std::vector<double> all;
  for (int decade = static_cast<int>(std::floor(std::log10(low))); std::pow(10.0, decade) <= high; ++decade)
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double value = digit * std::pow(10.0, decade);
      if (value >= low && value <= high) all.push_back(value);
    }
  if (all.size() <= 7) return all;
  std::vector<double> powers;  // over many decades these are enough
  for (const double value : all)
    if (std::abs(std::log10(value) - std::round(std::log10(value))) < 1e-9) powers.push_back(value);
  return powers.size() >= 2 ? powers : all;
}

// Shapes tell the groups apart on paper too.
constexpr const char* kShapes[] = {"circle", "square", "diamond", "triangle", "cross", "down", "bar", "plus"};

std::string mark(const std::string& shape, double x, double y, const std::string& classes, const std::string& title) {
  const auto at = [&](double dx, double dy) { return fmt::format("{:.1f},{:.1f}", x + dx, y + dy); };
  std::string points;
  if (shape == "circle")
    return fmt::format("<circle class=\"{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\"><title>{}</title></circle>", classes,
                       x, y, title);
  if (shape == "square") points = at(-3.6, -3.6) + " " + at(3.6, -3.6) + " " + at(3.6, 3.6) + " " + at(-3.6, 3.6);
  else if (shape == "diamond") points = at(0, -5) + " " + at(5, 0) + " " + at(0, 5) + " " + at(-5, 0);
  else if (shape == "triangle") points = at(0, -5) + " " + at(4.6, 3.8) + " " + at(-4.6, 3.8);
  else if (shape == "down") points = at(0, 5) + " " + at(4.6, -3.8) + " " + at(-4.6, -3.8);
  else if (shape == "bar") points = at(-2, -5) + " " + at(2, -5) + " " + at(2, 5) + " " + at(-2, 5);
  else if (shape == "plus") points = at(-5, -2) + " " + at(5, -2) + " " + at(5, 2) + " " + at(-5, 2);
  else
    points = at(-4, -4) + " " + at(0, -1.5) + " " + at(4, -4) + " " + at(1.5, 0) + " " + at(4, 4) + " " + at(0, 1.5) +
             " " + at(-4, 4) + " " + at(-1.5, 0);
  return fmt::format("<polygon class=\"{}\" points=\"{}\"><title>{}</title></polygon>", classes, points, title);
}

class TradeoffPage {
 public:
  TradeoffPage(const TradeoffJob& job, const TradeoffResult& result) : job_(job), result_(result) {
    for (const TradeoffRow& row : result.rows)
      if (row.is_measured && std::find(groups_.begin(), groups_.end(), row.group) == groups_.end())
        groups_.push_back(row.group);
  }

  std::string html() const {
    return html_page("What accuracy costs: " + html_escaped(map_name(job_)),
                     summary() + plots() + fronts() + all_rows() + others() + pictures() + notes() + kScript,
                     kTradeoffStyle);
  }

 private:
  static std::string name_of(const TradeoffRow& row) {
    return row.options + (row.view.empty() ? "" : ", drawn with " + row.view);
  }

  std::string summary() const {
    std::string html = fmt::format(
        "<p>{} settings for <b>{}</b>, {} &times; {} texels, measured for {} on {}{}. Errors are relative L1, "
        "in %, in the mean over mip levels 2 and up{}.</p>\n",
        result_.setting_count(), html_escaped(map_name(job_)), result_.width, result_.height,
        html_escaped(job_.brdf.id.text()), html_escaped(result_.device),
        result_.renderer.empty() ? "" : ", drawn by " + html_escaped(result_.renderer),
        result_.renderer.empty() ? "" : "; settings are ranked by the error of their pictures, which see all levels");
    if (job_.has_budget())
      html += fmt::format("<p>Budget: {}. {} keep to it; the others are struck out.</p>\n", budgets_text(job_),
                          fitting_text(result_));
    if (!is_asked(job_)) return html;
    std::string asked = job_.error          ? fmt::format("an error of {:.4g} %", 100.0 * *job_.error)
                        : job_.bake_seconds ? fmt::format("{:.0f} ms of baking", 1e3 * *job_.bake_seconds)
                                            : "";
    if (job_.has_budget()) asked += (asked.empty() ? "" : " within ") + budgets_text(job_);
    if (!result_.chosen) return html + fmt::format("<p><b>No settings reach {}.</b></p>\n", asked);
    const TradeoffRow& row = result_.rows[*result_.chosen];
    return html + fmt::format(
                      "<h2>For {}</h2>\n<p>{} (mean over levels; the worst is level {} with {} %) in {} ms, {} MiB on "
                      "the GPU: the {} settings that meet this.</p>\n"
                      "<pre>{}</pre>\n",
                      asked, html_escaped(errors_text(row)), row.reached.worst_level,
                      percent(row.reached.worst_level_error), millis(row.bake_seconds), mebi(row.gpu_bytes),
                      job_.error ? "cheapest" : "most accurate", html_escaped(bake_command(job_, row)));
  }

  std::string shape_of(const std::string& group) const {
    const auto at = static_cast<std::size_t>(std::find(groups_.begin(), groups_.end(), group) - groups_.begin());
    return kShapes[at % std::size(kShapes)];
  }

  std::string plots() const {
    std::string html =
        "<h2>Error against cost</h2>\n<p>Both axes are logarithmic; lower and further left is better. "
        "The line is the front: nothing is both cheaper and nearer to the reference. Point at a mark for "
        "its settings.</p>\n<div class=\"plots\">\n";
    for (const Cost& cost : costs()) html += plot(cost);
    html += "<figure>" + legend() + "</figure>\n</div>\n";
    return html;
  }

  std::string legend() const {
    std::string svg = fmt::format("<svg viewBox=\"0 0 360 {}\" role=\"img\" aria-label=\"what marks stand for\">",
                                  22 * (groups_.size() + (job_.has_budget() ? 1 : 0)) + 34);
    double y = 14.0;
    for (const std::string& group : groups_) {
      svg += mark(shape_of(group), 14.0, y, "mark", html_escaped(group));
      svg += fmt::format("<text x=\"30\" y=\"{:.0f}\">{}</text>", y + 4, html_escaped(group));
      y += 22.0;
    }
    if (job_.has_budget()) {
      svg += mark("circle", 14.0, y, "mark over", "beyond the budget");
      svg += fmt::format("<text x=\"30\" y=\"{:.0f}\">pale: beyond the budget</text>", y + 4);
      y += 22.0;
    }
    svg += mark("circle", 14.0, y, "mark onfront", "on the front");
    return svg + fmt::format("<text x=\"30\" y=\"{:.0f}\">filled: on the front</text></svg>", y + 4);
  }

  std::string plot(const Cost& cost) const {
    std::vector<const TradeoffRow*> rows;
    for (const TradeoffRow& row : result_.rows)
      if (row.is_measured && cost.of(row) > 0.0 && row.ranked_error() > 0.0) rows.push_back(&row);
    if (rows.empty()) return "";
    std::sort(rows.begin(), rows.end(),
              [&](const TradeoffRow* a, const TradeoffRow* b) { return cost.of(*a) < cost.of(*b); });
    constexpr double kWidth = 400, kHeight = 300, kLeft = 46, kTop = 26, kRight = 12, kBottom = 40;
    double x_low = HUGE_VAL, x_high = 0.0, y_low = HUGE_VAL, y_high = 0.0;
    for (const TradeoffRow* row : rows) {
      x_low = std::min(x_low, cost.of(*row) / 1.2), x_high = std::max(x_high, cost.of(*row) * 1.2);
      y_low = std::min(y_low, row->ranked_error() / 1.15), y_high = std::max(y_high, row->ranked_error() * 1.15);
    }
    const auto place = [](double value, double low, double high) {
      return (std::log(value) - std::log(low)) / (std::log(high) - std::log(low));
    };
    const auto x = [&](double value) { return kLeft + (kWidth - kLeft - kRight) * place(value, x_low, x_high); };
    const auto y = [&](double value) {
      return kHeight - kBottom - (kHeight - kTop - kBottom) * place(value, y_low, y_high);
    };
    std::string svg = fmt::format(
        "<figure><svg viewBox=\"0 0 {0} {1}\" role=\"img\" aria-label=\"error against {2}\"><text class=\"title\" "
        "x=\"{3}\" y=\"14\">{4}</text>",
        kWidth, kHeight, html_escaped(cost.title), kLeft, html_escaped(cost.title));
    for (const double tick : ticks(x_low, x_high))
      svg += fmt::format(
          "<line class=\"grid\" x1=\"{0:.1f}\" y1=\"{1}\" x2=\"{0:.1f}\" y2=\"{2}\"/><text x=\"{0:.1f}\" "
          "y=\"{3}\" text-anchor=\"middle\">{4:g}</text>",
          x(tick), kTop, kHeight - kBottom, kHeight - kBottom + 14, tick);
    for (const double tick : ticks(100.0 * y_low, 100.0 * y_high))
      svg += fmt::format(
          "<line class=\"grid\" x1=\"{0}\" y1=\"{1:.1f}\" x2=\"{2}\" y2=\"{1:.1f}\"/><text x=\"{3}\" "
          "y=\"{4:.1f}\" text-anchor=\"end\">{5:g}</text>",
          kLeft, y(tick / 100.0), kWidth - kRight, kLeft - 5, y(tick / 100.0) + 4, tick);
    svg += fmt::format(
        "<line class=\"axis\" x1=\"{0}\" y1=\"{1}\" x2=\"{0}\" y2=\"{2}\"/><line class=\"axis\" x1=\"{0}\" "
        "y1=\"{2}\" x2=\"{3}\" y2=\"{2}\"/><text x=\"{3}\" y=\"{4}\" text-anchor=\"end\">{5}</text>"
        "<text x=\"4\" y=\"{6}\">error, %</text>",
        kLeft, kTop, kHeight - kBottom, kWidth - kRight, kHeight - 8, cost.axis, kHeight - 8);
    std::string line;
    double last_y = 0.0;
    for (const TradeoffRow* row : rows) {
      if (!(row->*cost.front)) continue;
      if (!line.empty()) line += fmt::format(" {:.1f},{:.1f}", x(cost.of(*row)), last_y);
      last_y = y(row->ranked_error());
      line += fmt::format(" {:.1f},{:.1f}", x(cost.of(*row)), last_y);
    }
    svg += fmt::format("<polyline class=\"front\" points=\"{}\"/>", line);
    for (const TradeoffRow* row : rows)
      svg += mark(shape_of(row->group), x(cost.of(*row)), y(row->ranked_error()),
                  std::string(row->*cost.front ? "mark onfront" : "mark") + (row->fits ? "" : " over"),
                  html_escaped(fmt::format("{}: {} %, {:.4g} {}", name_of(*row), percent(row->ranked_error()),
                                           cost.of(*row), cost.axis)));
    return svg + "</svg></figure>\n";
  }

  std::string fronts() const {
    std::string html =
        "<h2>Settings to copy</h2>\n<p>Those on a front of error against bake time, memory or frame "
        "time, the most accurate first.</p>\n";
    std::vector<const TradeoffRow*> rows;
    for (const TradeoffRow& row : result_.rows)
      if (row.on_time_front || row.on_size_front || row.on_frame_front) rows.push_back(&row);
    std::sort(rows.begin(), rows.end(),
              [](const auto* a, const auto* b) { return a->ranked_error() < b->ranked_error(); });
    for (const TradeoffRow* row : rows) {
      std::string fronts_text;
      for (const Cost& cost : costs())
        if (row->*cost.front) fronts_text += (fronts_text.empty() ? "" : ", ") + std::string(cost.title);
      html += fmt::format(
          "<p class=\"soft\"><b>{}</b>; {} ms to bake, {} MiB on the GPU{}; front of: {}{}</p>\n"
          "<pre>{}</pre>\n",
          html_escaped(errors_text(*row)), millis(row->bake_seconds), mebi(row->gpu_bytes),
          row->frame_ms < 0.0 ? "" : fmt::format(", {:.1f} ms a frame", row->frame_ms),
          fronts_text + (row->fits ? "" : "; beyond the budget"), warnings_html(*row),
          html_escaped(bake_command(job_, *row)));
    }
    return html;
  }

  static std::string warnings_html(const TradeoffRow& row) {
    std::string html;
    for (const std::string& warning : row.warnings) html += "<br>Warning: " + html_escaped(warning);
    return html;
  }

  std::string all_rows() const {
    std::vector<HtmlRow> rows;
    for (const TradeoffRow& row : result_.rows) {
      if (!row.is_measured) continue;
      const std::string best = row.on_time_front || row.on_size_front || row.on_frame_front ? "*" : "";
      const std::string name = "<code>" + html_escaped(row.options) + "</code>" +
                               (row.view.empty() ? "" : " <code>" + html_escaped(row.view) + "</code>");
      rows.push_back({row.fits ? name : "<s>" + name + "</s>", html_escaped(row.group),
                      best + percent(row.reached.error), percent(row.reached.confidence), percent(row.centre),
                      percent(row.midway), percent(row.between), percent_if(row.rendered), millis(row.bake_seconds),
                      row.frame_ms < 0.0 ? "-" : fmt::format("{:.1f}", row.frame_ms), mebi(row.file_bytes),
                      mebi(row.gpu_bytes)});
    }
    return "<h2>All of them</h2>\n<p>Click a heading to sort. Bold: on a front.</p>\n" +
           html_table({{"settings", true},
                       {"varied", true},
                       {"error"},
                       {"&plusmn;&nbsp;95&nbsp;%"},
                       {"centres"},
                       {"midway"},
                       {"between levels"},
                       {"rendered"},
                       {"bake, ms"},
                       {"frame, ms"},
                       {"file, MiB"},
                       {"GPU, MiB"}},
                      rows, " class=\"sortable\"");
  }

  std::string others() const {
    std::vector<HtmlRow> rows;
    for (const TradeoffRow& row : result_.rows)
      if (!row.is_measured)
        rows.push_back({"<code>" + html_escaped(row.options) + "</code>", "<code>" + html_escaped(row.view) + "</code>",
                        html_escaped(row.group), row.has_error ? percent(row.reached.error) : "-",
                        row.has_error ? percent(row.reached.confidence) : "-", percent_if(row.rendered),
                        row.frame_ms < 0.0 ? "-" : fmt::format("{:.1f}", row.frame_ms)});
    if (rows.empty() || job_.viewer.empty()) return "";
    return "<h2>Shading formulas and BRDF terms</h2>\n<p>Formulas that only the renderer has are known by their "
           "pictures alone. A row with <code>--brdf</code> is compared with a reference of that BRDF.</p>\n" +
           html_table({{"baked with", true},
                       {"drawn with", true},
                       {"varied", true},
                       {"error"},
                       {"&plusmn;&nbsp;95&nbsp;%"},
                       {"rendered"},
                       {"frame, ms"}},
                      rows, " class=\"sortable\"");
  }

  static std::string figure(const std::string& png, const std::string& caption) {
    return fmt::format("<figure><img alt=\"\" src=\"data:image/png;base64,{}\"><figcaption>{}</figcaption></figure>\n",
                       base64(png), caption);
  }

  std::string pictures() const {
    if (result_.truth.empty()) return "";
    std::string html = fmt::format(
        "<h2>Pictures</h2>\n<p>{} &times; {} pixels of a plane that runs to the horizon. The reference shades every "
        "finest normal under what the trilinear filter covers ({} samples a pixel).</p>\n<div class=\"pictures\">\n",
        job_.width, job_.height, job_.samples);
    html += figure(result_.truth, "<b>truth</b>");
    for (const TradeoffRow& row : result_.rows) {
      const bool is_shown = row.on_time_front || row.on_size_front || row.on_frame_front || row.group == "moments" ||
                            row.group == "hierarchy";
      if (is_shown && !row.picture.empty())
        html +=
            figure(row.picture, fmt::format("<b>{} % off</b>: {}", percent(row.rendered), html_escaped(name_of(row))));
    }
    return html + "</div>\n";
  }

  std::string notes() const {
    return fmt::format(
        "<h2>How it is measured</h2>\n<ul><li>Truth: the average of the BRDF over every finest normal that a texel "
        "covers, in double; 12 pairs of light and view; what is stored is rounded as stored, filtered as hardware "
        "filters, shaded as the runtime shades (docs/ACCURACY.md).</li>\n<li>Error: texel centres and midpoints in x "
        "and y, levels 2 and up, each level weighing the same. &plusmn;: 95 % interval over the texels that were "
        "looked at, at most about 2048 a level (stratified standard error of a ratio, Cochran 1977).</li>\n<li>Memory: "
        "of the baked file's textures. With --first-level the finest levels are the normal map's, which a renderer has "
        "beside them: they are counted as BC5, a byte a texel.</li>\n<li>Bake "
        "time: fitting or averaging, rounding and writing, without reading and measuring, once each. Frame time: one "
        "picture of {} &times; {} pixels, the quicker of two. Times are this machine's and move with what else it "
        "does.</li>\n<li>The "
        "sweep took {:.0f} s. multum {}.</li></ul>\n",
        job_.width, job_.height, result_.seconds, MULTUM_VERSION);
  }

  const TradeoffJob& job_;
  const TradeoffResult& result_;
  std::vector<std::string> groups_;
};

}  // namespace

std::string tradeoff_page(const TradeoffJob& job, const TradeoffResult& result) {
  return TradeoffPage(job, result).html();
}

std::string tradeoff_json(const TradeoffJob& job, const TradeoffResult& result) {
  nlohmann::ordered_json json = {{"software", std::string("multum ") + MULTUM_VERSION},
                                 {"map", map_name(job)},
                                 {"width", result.width},
                                 {"height", result.height},
                                 {"brdf", job.brdf.id.text()},
                                 {"device", result.device},
                                 {"renderer", result.renderer},
                                 {"seconds", result.seconds}};
  if (result.chosen) json["chosen"] = *result.chosen;
  if (job.bytes_max) json["budget"]["gpu_bytes"] = *job.bytes_max;
  if (job.frame_ms_max) json["budget"]["frame_ms"] = *job.frame_ms_max;
  if (job.bake_seconds_max) json["budget"]["bake_seconds"] = *job.bake_seconds_max;
  json["rows"] = nlohmann::ordered_json::array();
  for (const TradeoffRow& row : result.rows) {
    nlohmann::ordered_json one = {{"group", row.group},
                                  {"bake", row.options},
                                  {"view", row.view},
                                  {"command", bake_command(job, row)},
                                  {"bake_seconds", row.bake_seconds},
                                  {"file_bytes", row.file_bytes},
                                  {"gpu_bytes", row.gpu_bytes}};
    if (row.normals_bytes > 0) one["normal_map_bytes"] = row.normals_bytes;
    if (job.has_budget()) one["fits"] = row.fits;
    if (!row.warnings.empty()) one["warnings"] = row.warnings;
    if (row.has_error)
      one.update({{"relative_l1", row.reached.error},
                  {"confidence_95", row.reached.confidence},
                  {"worst_level", row.reached.worst_level},
                  {"worst_level_relative_l1", row.reached.worst_level_error}});
    if (row.is_measured)
      one.update(
          {{"centre", row.centre},
           {"midway", row.midway},
           {"between_levels", row.between},
           {"fronts",
            {{"bake_time", row.on_time_front}, {"gpu_bytes", row.on_size_front}, {"frame_time", row.on_frame_front}}}});
    if (row.rendered >= 0.0) one.update({{"rendered_relative_l1", row.rendered}, {"frame_ms", row.frame_ms}});
    json["rows"].push_back(std::move(one));
  }
  return json.dump(2) + "\n";
}

std::string tradeoff_markdown(const TradeoffResult& result) {
  std::string text =
      "| settings | drawn with | error | 95 % | centres | midway | between levels | rendered | bake, ms | frame, ms | "
      "GPU, MiB |\n"
      "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n";
  for (const TradeoffRow& row : result.rows) {
    const auto if_measured = [&](double share) { return row.is_measured ? percent(share) : std::string("-"); };
    const auto if_known = [&](double share) { return row.has_error ? percent(share) : std::string("-"); };
    text += fmt::format("| `{}` | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", row.options,
                        row.view.empty() ? "" : "`" + row.view + "`", if_known(row.reached.error),
                        if_known(row.reached.confidence), if_measured(row.centre), if_measured(row.midway),
                        if_measured(row.between), percent_if(row.rendered), millis(row.bake_seconds),
                        row.frame_ms < 0.0 ? "-" : fmt::format("{:.1f}", row.frame_ms), mebi(row.gpu_bytes));
  }
  return text;
}

std::string tradeoff_text(const TradeoffJob& job, const TradeoffResult& result) {
  std::string text = "on a front of error against bake time, memory or frame time:\n";
  for (const TradeoffRow& row : result.rows) {
    if ((!row.on_time_front && !row.on_size_front && !row.on_frame_front) || !row.fits) continue;
    text += fmt::format("  {:>16}  {:>6} ms  {:>8} MiB  {}  {} {}\n", errors_text(row), millis(row.bake_seconds),
                        mebi(row.gpu_bytes), row.frame_ms < 0.0 ? "" : fmt::format("{:6.1f} ms a frame", row.frame_ms),
                        row.options, row.view);
  }
  if (job.has_budget()) text += fmt::format("within {}: {}\n", budgets_text(job), fitting_text(result));
  if (!is_asked(job)) return text;
  if (!result.chosen) return text + "no settings meet this\n";
  const TradeoffRow& chosen = result.rows[*result.chosen];
  text += fmt::format("chosen: {}; mean over levels 2 and up, the worst is level {} with {} %\n", chosen.options,
                      chosen.reached.worst_level, percent(chosen.reached.worst_level_error));
  return text;
}

}  // namespace multum
