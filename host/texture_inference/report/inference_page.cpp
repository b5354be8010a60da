// SPDX-License-Identifier: Apache-2.0
#include "host/texture_inference/report/inference_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include "host/base/files/atomic_file.h"
#include "host/html/html_page.h"

namespace multum {
namespace {

// Seconds a point of the parameter space in the paper's table "System Performance": texture coordinate optimisation
// .93 s, obtaining matrix A 2.15 min, solving for textures 2.68 min.
constexpr double kPaperMapping = 0.93, kPaperProbing = 2.15 * 60.0, kPaperSolving = 2.68 * 60.0;

// Three figures; negative: there is none.
std::string mse_text(double value) {
  if (!(value >= 0.0)) return "&ndash;";
  return value < 9.995 ? fmt::format("{:.2f}", value)
                       : fmt::format(fmt::runtime(value < 99.95 ? "{:.1f}" : "{:.0f}"), value);
}

std::string seconds_text(double seconds) {
  return seconds < 9.95 ? fmt::format("{:.2f}", seconds) : fmt::format("{:.1f}", seconds);
}

std::string counted(std::size_t count, const std::string& what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

class InferencePage {
 public:
  InferencePage(const InferenceReport& report, const ReportPictures& pictures)
      : report_(report), job_(report.job), pictures_(pictures), layers_(summarise_layers(report)) {}

  std::string html() const {
    const std::string title =
        "Inferred textures of " + html_escaped(std::filesystem::path(job_.path).filename().string());
    return html_page(title, summary() + frame_pictures() + object_table() + comparison() + heat_maps() +
                                object_pictures() + textures() + times() + mappings() + doubtful() + foot());
  }

 private:
  std::string object_name(std::size_t k) const { return html_escaped(job_.objects[k].name); }
  std::string sample_name(int sample) const {
    return html_escaped(job_.samples[static_cast<std::size_t>(sample)].name);
  }

  std::string summary() const {
    std::size_t textures = 0, there = 0;
    double sum = 0.0, forward = 0.0, pixels = 0.0, held_out = 0.0, held_out_pixels = 0.0;
    bool has_forward = !layers_.empty();
    for (const LayerSummary& one : layers_) {
      textures += static_cast<std::size_t>(one.textures);
      there += static_cast<std::size_t>(one.textures_there);
      sum += one.squared_error * one.pixel_count;
      forward += one.forward_squared_error * one.pixel_count;
      pixels += one.pixel_count;
      held_out += one.held_out_squared_error * one.held_out_pixel_count;
      held_out_pixels += one.held_out_pixel_count;
      has_forward = has_forward && one.forward_squared_error >= 0.0;
    }
    std::vector<std::string> grid;
    for (const AnimationParameter& p : job_.parameters)
      grid.push_back(fmt::format("{} {}", p.count, html_escaped(p.name)));
    std::string html = fmt::format(
        "<p>{} of {} were inferred from {} of {} &times; {} pixels ({}), so that a GL renderer that draws the "
        "objects with them shows those pictures again (Hakura et al. 2000).",
        counted(textures, "texture"), counted(job_.objects.size(), "object"),
        counted(job_.samples.size(), "ray-traced picture"), job_.width, job_.height, fmt::join(grid, " &times; "));
    html += "</p>\n" + frame_summary();
    if (pixels > 0.0) {
      html += fmt::format("<p>By itself, each texture fits the pixels of its layer with a mean squared error of {}",
                          mse_text(sum / pixels));
      if (has_forward)
        html += fmt::format(
            ". Forward mapping, which puts the same pixels into textures without knowing how the GL filters them, "
            "has {}: {:.1f} times as much",
            mse_text(forward / pixels), forward / std::max(sum, 1e-12));
      html += ".";
      if (held_out_pixels > 0.0)
        html += fmt::format(" In pictures that were held out it is {}.", mse_text(held_out / held_out_pixels));
      html += "</p>\n";
    }
    return html + time_summary(textures, there) +
           "<p class=\"soft\">Mean squared errors (MSE) are of 8-bit sRGB values, 0 to 255, the mean of red, green and "
           "blue over pixels, of all samples together.</p>\n";
  }

  std::string time_summary(std::size_t textures, std::size_t there) const {
    const StageSeconds& s = report_.result.seconds;
    if (there == textures)
      return "<p>All textures were there already from an earlier run: times of this one say nothing of inferring "
             "them.</p>\n";
    std::string html;
    if (there > 0)
      html = fmt::format("<p>{} of the textures were there already from an earlier run; times are of the others.</p>\n",
                         there);
    return html +
           fmt::format(
               "<p>Measuring what the GL's filter does took {} s, solving for the textures {} s, all stages together "
               "{} s. The paper reports 2.15 min and 2.68 min for one point of the parameter space, of which there are "
               "{} here, for another scene on machines of its time.</p>\n",
               seconds_text(s.probing), seconds_text(s.systems + s.solving), seconds_text(total_seconds()),
               job_.samples.size());
  }

  std::string frame_summary() const {
    if (report_.frames == nullptr) return "<p>No frames were drawn with them (<code>--no-frames</code>).</p>\n";
    const FrameMean mean = mean_frame_error(*report_.frames);
    double uncovered = 0.0, not_finite = 0.0;
    for (const FrameErrors& frame : report_.frames->frames) {
      uncovered += frame.uncovered_pixels;
      not_finite += frame.not_finite_pixels;
    }
    if (!(mean.pixel_count > 0.0)) return "<p>No frame has a pixel that objects cover wholly.</p>\n";
    const double rms = std::sqrt(mean.squared_error);
    std::string html = fmt::format(
        "<p><b>{} drawn with them by multum-view are off by a mean squared error of {}</b>, a root mean square of {} "
        "of 255 steps{}.",
        counted(report_.frames->frames.size(), "frame"), mse_text(mean.squared_error), mse_text(rms),
        rms > 0.0 ? fmt::format(" (PSNR {:.1f} dB)", 20.0 * std::log10(255.0 / rms)) : "");
    if (uncovered > 0.0)
      html += fmt::format(" {:.0f} of {:.0f} pixels are not covered wholly by objects and are left out.", uncovered,
                          uncovered + not_finite + mean.pixel_count);
    if (not_finite > 0.0) html += fmt::format(" {:.0f} pixels are left out because they are not numbers.", not_finite);
    return html + "</p>\n";
  }

  // `scale`: CSS pixels a pixel, so that small objects can be seen.
  static std::string picture(const ReportPicture& one, int scale, const std::string& alt, const std::string& caption) {
    return fmt::format(
        "<figure><img src=\"{}\" width=\"{}\" height=\"{}\" alt=\"{}\"><figcaption>{}</figcaption></figure>\n",
        html_escaped(one.file), scale * one.width, scale * one.height, alt, caption);
  }

  static std::string three(const PictureRow& row, const std::string& what) {
    const int scale = std::clamp(std::min(380 / row.error.width, 340 / row.error.height), 1, 8);
    const std::string zoom = scale > 1 ? fmt::format(", {} times enlarged", scale) : "";
    return "<div class=\"three\">\n" +
           picture(row.ray_traced, scale, what + ", ray-traced", "<b>ray-traced</b>" + zoom) +
           picture(row.rendered, scale, what + ", drawn with inferred textures",
                   "<b>drawn with inferred textures</b>") +
           picture(row.error, scale, what + ", absolute error times 20",
                   fmt::format("<b>error &times; 20</b>, black for none; MSE {}", mse_text(row.squared_error))) +
           "</div>\n";
  }

  std::string frame_pictures() const {
    if (!pictures_.has_frame) return "";
    return fmt::format("<h2>The frame {}</h2>\n", sample_name(report_.sample)) +
           three(pictures_.frame, "the whole frame " + sample_name(report_.sample)) +
           "<p class=\"soft\">Pixels that objects do not cover wholly are transparent in the error.</p>\n";
  }

  std::string object_pictures() const {
    if (!pictures_.has_frame) return "";
    std::string html = fmt::format(
        "<h2>Objects in {}</h2>\n<p>Pixels that the object covers wholly, as in figure 6 of the paper; others "
        "are transparent.</p>\n",
        sample_name(report_.sample));
    for (std::size_t k = 0; k < pictures_.objects.size(); ++k) {
      if (pictures_.objects[k].error.width == 0) continue;
      html += "<h3>" + object_name(k) + "</h3>\n" + three(pictures_.objects[k], object_name(k));
    }
    return html;
  }

  std::string textures() const {
    if (pictures_.textures.empty()) return "";
    std::string html = fmt::format(
        "<h2>Textures of {}</h2>\n<p>The finest level of each, as sRGB. What no pixel sees "
        "is filled from coarser levels by pyramidal regularisation.</p>\n"
        "<div class=\"thumbs\">\n",
        sample_name(report_.sample));
    for (const ReportPictures::Texture& one : pictures_.textures) {
      const std::string name = object_name(one.object) + " " + html_escaped(job_.layers[one.layer].name);
      html += picture(one.picture, 1, "texture of " + name,
                      fmt::format("<b>{}</b>, {} &times; {} texels", name, one.picture.width, one.picture.height));
    }
    return html + "</div>\n";
  }

  std::string object_table() const {
    bool has_held_out = false;
    for (const LayerSummary& one : layers_) has_held_out = has_held_out || one.held_out_squared_error >= 0.0;
    std::vector<HtmlColumn> columns = {{"object", true}, {"layer", true},     {"textures"}, {"texels"},
                                       {"MSE"},          {"forward mapping"}, {"ratio"}};
    if (has_held_out) columns.push_back({"held out"});
    columns.insert(columns.end(), {{"worst sample"}, {"iterations, median"}, {"at most"}, {"not converged"}});
    if (report_.frames != nullptr) columns.push_back({"in frames"});
    std::vector<HtmlRow> rows;
    for (const LayerSummary& one : layers_) {
      const bool is_first = rows.empty() || layers_[rows.size() - 1].object != one.object;
      const bool is_known = one.textures_there < one.textures;
      HtmlRow row = {is_first ? object_name(one.object) : "",
                     html_escaped(job_.layers[one.layer].name),
                     std::to_string(one.textures),
                     texel_count_text(report_, one, " &times; "),
                     mse_text(one.squared_error),
                     mse_text(one.forward_squared_error),
                     one.forward_squared_error > 0.0 && one.squared_error >= 0.0
                         ? fmt::format("{:.2f}", one.squared_error / one.forward_squared_error)
                         : "&ndash;"};
      if (has_held_out) row.push_back(mse_text(one.held_out_squared_error));
      row.push_back(one.worst_sample < 0
                        ? "&ndash;"
                        : mse_text(one.worst_squared_error) + " (" + sample_name(one.worst_sample) + ")");
      row.push_back(is_known ? fmt::format("{:g}", one.iterations_median) : "&ndash;");
      row.push_back(is_known ? std::to_string(one.iterations_max) : "&ndash;");
      row.push_back(std::to_string(one.not_converged));
      if (report_.frames != nullptr) {
        const FrameMean mean = mean_object_error(*report_.frames, one.object);
        row.push_back(is_first && mean.pixel_count > 0.0 ? mse_text(mean.squared_error) : "");
      }
      rows.push_back(row);
    }
    return "<h2>Objects and layers</h2>\n<p>MSE is of each layer by itself, over the pixels that its textures were "
           "solved for; in frames all layers are added, and pixels are those that the object covers wholly. The ratio "
           "is to forward mapping.</p>\n" +
           html_table(columns, rows);
  }

  // The least of each column, of those that are there.
  std::string comparison() const {
    if (report_.comparison == nullptr || report_.comparison->rows.empty()) return "";
    const InferenceComparison& c = *report_.comparison;
    std::vector<HtmlColumn> columns = {{"inferred with", true}};
    std::vector<double> least(job_.objects.size(), -1.0);
    for (std::size_t k = 0; k < job_.objects.size(); ++k) {
      columns.push_back({object_name(k)});
      for (const ComparisonRow& row : c.rows)
        if (row.squared_errors[k] >= 0.0 && (least[k] < 0.0 || row.squared_errors[k] < least[k]))
          least[k] = row.squared_errors[k];
    }
    std::vector<HtmlRow> rows;
    for (const ComparisonRow& one : c.rows) {
      HtmlRow row = {html_escaped(one.name)};
      for (std::size_t k = 0; k < job_.objects.size(); ++k)
        row.push_back((one.squared_errors[k] >= 0.0 && one.squared_errors[k] <= least[k] ? "*" : "") +
                      mse_text(one.squared_errors[k]));
      rows.push_back(row);
    }
    return fmt::format(
               "<h2>What the choices cost</h2>\n<p>Each object's layers inferred from the one picture {} in "
               "several ways, as in figure 6 of the paper: MSE of all layers added, "
               "over wholly covered pixels; the least is bold. Bilinear filtering fits best at the very view "
               "that it was inferred for and at no other.</p>\n",
               html_escaped(c.sample)) +
           html_table(columns, rows);
  }

  std::string heat_maps() const {
    if (report_.frames == nullptr || report_.frames->frames.empty()) return "";
    std::string html =
        "<h2>Frames by sample</h2>\n<p>MSE of each frame over the grid of parameters, and of each object "
        "over its wholly covered pixels. Every map has its own scale; the frame that is shown above is "
        "outlined.";
    if (report_.settings.hold_out >= 2)
      html +=
          " Where views were held out, textures that serve several views are shown on one that they were not "
          "solved for.";
    html += "</p>\n<div class=\"charts\">\n";
    html += heat_map("whole frames",
                     [](const FrameErrors& frame) { return frame.pixel_count > 0.0 ? frame.squared_error : -1.0; });
    for (std::size_t k = 0; k < job_.objects.size(); ++k)
      html += heat_map(object_name(k), [k](const FrameErrors& frame) {
        return frame.object_pixel_counts[k] > 0.0 ? frame.object_squared_errors[k] : -1.0;
      });
    return html + "</div>\n";
  }

  // Columns are the last parameter, which samples follow fastest; rows are all others together.
  std::string heat_map(const std::string& what, const std::function<double(const FrameErrors&)>& value_of) const {
    const std::vector<FrameErrors>& frames = report_.frames->frames;
    double least = -1.0, most = -1.0;
    for (const FrameErrors& frame : frames) {
      const double value = value_of(frame);
      if (value < 0.0) continue;
      least = least < 0.0 ? value : std::min(least, value);
      most = std::max(most, value);
    }
    if (most < 0.0) return "";
    const int columns = job_.parameters.empty() ? 1 : job_.parameters.back().count;
    const int rows = static_cast<int>(job_.samples.size()) / columns;
    const double cell_width = std::clamp(336.0 / columns, 4.0, 42.0),
                 cell_height = cell_width < 30.0 ? cell_width : 24.0;
    const double left = 44.0, top = 20.0;
    std::string svg =
        fmt::format(
            "<svg viewBox=\"0 0 {:g} {:g}\" role=\"img\" aria-label=\"MSE of {} by sample, {} to {}"
            "\">",
            left + columns * cell_width + 4.0, top + rows * cell_height + 4.0, what, mse_text(least), mse_text(most)) +
        axes(rows, columns, cell_height);
    for (const FrameErrors& frame : frames) {
      const double value = value_of(frame);
      const double x = left + frame.sample % columns * cell_width, y = top + frame.sample / columns * cell_height;
      const std::string box = fmt::format("x=\"{:g}\" y=\"{:g}\" width=\"{:g}\" height=\"{:g}\"", x + 0.5, y + 0.5,
                                          cell_width - 1.0, cell_height - 1.0);
      if (value < 0.0) {
        svg +=
            fmt::format("<rect class=\"none\" {}><title>{}: not seen</title></rect>", box, sample_name(frame.sample));
      } else {
        const double share = most > least ? (value - least) / (most - least) : 0.0;
        svg += fmt::format("<rect class=\"cell\" {} fill-opacity=\"{:.3f}\"><title>{}: MSE {}</title></rect>", box,
                           0.08 + 0.57 * share, sample_name(frame.sample), mse_text(value));
        if (cell_width >= 30.0)
          svg += fmt::format("<text class=\"value\" x=\"{:g}\" y=\"{:g}\" text-anchor=\"middle\">{}</text>",
                             x + 0.5 * cell_width, y + 0.5 * cell_height + 4.0, mse_text(value));
      }
      if (frame.sample == report_.sample) svg += fmt::format("<rect class=\"shown\" {}/>", box);
    }
    return fmt::format("<figure>{}</svg><figcaption><b>{}</b>, {} to {}</figcaption></figure>\n", svg, what,
                       mse_text(least), mse_text(most));
  }

  std::string axes(int rows, int columns, double cell_height) const {
    const double left = 44.0, top = 20.0;
    if (job_.parameters.empty()) return "";
    std::vector<std::string> others;
    for (std::size_t d = 0; d + 1 < job_.parameters.size(); ++d)
      others.push_back(html_escaped(job_.parameters[d].name));
    std::string svg = fmt::format("<text x=\"{:g}\" y=\"9\">{} 0 to {}</text>", left,
                                  html_escaped(job_.parameters.back().name), columns - 1);
    if (!others.empty()) svg += fmt::format("<text x=\"0\" y=\"9\">{}</text>", fmt::join(others, ", "));
    const int step = std::max(1, static_cast<int>(std::ceil(12.0 / cell_height)));  // labels are 12 high
    for (int row = 0; row < rows && !others.empty(); row += step) {
      std::vector<int> at = job_.samples[static_cast<std::size_t>(row * columns)].at;
      at.pop_back();
      svg += fmt::format("<text x=\"{:g}\" y=\"{:g}\" text-anchor=\"end\">{}</text>", left - 6.0,
                         top + (row + 0.5) * cell_height + 4.0, fmt::join(at, ","));
    }
    return svg;
  }

  double total_seconds() const {
    const StageSeconds& s = report_.result.seconds;
    return s.mapping + s.probing + s.segmentation + s.systems + s.solving + s.baseline + s.rendering;
  }

  std::string times() const {
    const StageSeconds& s = report_.result.seconds;
    const auto points = static_cast<double>(job_.samples.size());
    const auto row = [&](const char* name, double seconds, double paper) {
      return HtmlRow{name, seconds_text(seconds), fmt::format("{:.3f}", seconds / points),
                     paper > 0.0 ? seconds_text(paper) : ""};
    };
    return "<h2>Time</h2>\n<p>The paper's are for one point of its parameter space.</p>\n" +
           html_table({{"stage", true}, {"seconds"}, {"a sample"}, {"the paper's, a sample"}},
                      {row("texture coordinates", s.mapping, kPaperMapping),
                       row("measuring filter matrices", s.probing, kPaperProbing),
                       row("taking pictures apart into objects", s.segmentation, 0.0),
                       row("setting up systems", s.systems, 0.0), row("solving for textures", s.solving, kPaperSolving),
                       row("forward mapping, to compare with", s.baseline, 0.0),
                       row("drawing and comparing frames", s.rendering, 0.0), row("together", total_seconds(), 0.0)});
  }

  std::string mappings() const {
    std::vector<HtmlRow> rows;
    for (std::size_t k = 0; k < job_.objects.size(); ++k)
      for (std::size_t block = 0; block < report_.result.mappings[k].size(); ++block) {
        const TextureMapping& m = report_.result.mappings[k][block];
        HtmlRow row = {block == 0 ? object_name(k) : ""};
        if (report_.result.blocks.size() > 1) row.push_back(html_escaped(report_.result.blocks[block]));
        const HtmlRow figures = mapping_figures(m);
        row.insert(row.end(), figures.begin(), figures.end());
        rows.push_back(row);
      }
    std::vector<HtmlColumn> columns = {{"object", true}};
    if (report_.result.blocks.size() > 1) columns.push_back({"samples", true});
    columns.insert(columns.end(),
                   {{"texels"}, {"stretch"}, {"rounds of scaling"}, {"cut at"}, {"visible pixels"}, {"degenerate"}});
    return "<h2>Texture coordinates</h2>\n<p>An affine map of each object's own coordinates, for all samples that "
           "share "
           "it. Stretch is how many pixels a texel becomes at most.</p>\n" +
           html_table(columns, rows);
  }

  static HtmlRow mapping_figures(const TextureMapping& m) {
    if (m.width == 0) return {"not seen"};
    std::vector<std::string> cuts;
    for (std::size_t d = 0; d < 2; ++d)
      if (m.has_cut[d]) cuts.push_back(fmt::format("{} = {:.3f}", d == 0 ? "u" : "v", m.cut[d]));
    return {fmt::format("{} &times; {}", m.width, m.height),
            fmt::format("{:.3f}", m.stretch_max),
            std::to_string(m.stretch_rounds),
            cuts.empty() ? "none" : fmt::format("{}", fmt::join(cuts, ", ")),
            std::to_string(m.visible_pixels),
            std::to_string(m.degenerate_pixels)};
  }

  std::string doubtful() const {
    const SegmentationReport& s = report_.result.segmentation;
    const AnimationInferResult& r = report_.result;
    return "<h2>Counts</h2>\n" +
           html_table({{"what", true}, {"count"}},
                      {{"pixels of objects' layers that were not finite", std::to_string(s.not_finite_pixels)},
                       {"negative ones", std::to_string(s.negative_pixels)},
                       {"of these, repaired from neighbours", std::to_string(s.repaired_pixels)},
                       {"of these, dropped", std::to_string(s.dropped_pixels)},
                       {"mixed pixels, taken apart", std::to_string(s.mixed_pixels)},
                       {"of these, without a wholly covered pixel nearby", std::to_string(s.unguided_pixels)},
                       {"values below 0 after that, set to 0", std::to_string(s.clamped_values)},
                       {"values above the radiance maximum, clipped", std::to_string(s.clipped_values)},
                       {"depths that are not numbers", std::to_string(r.nan_depths)},
                       {"rows of filter matrices", std::to_string(r.rows)},
                       {"of these, rejected", std::to_string(r.rows_rejected)},
                       {"matrices measured in this run", std::to_string(r.matrices_measured)},
                       {"systems solved in normal form", std::to_string(r.systems_normal)},
                       {"systems solved with the matrix", std::to_string(r.systems_matrix)}});
  }

  std::string foot() const {
    const AnimationInferSettings& s = report_.settings;
    return fmt::format(
        "<p class=\"soft\">multum {}; OpenCL: {}; GL: {}. {} &times; {} sub-pixels; relative gradient {:g}, "
        "at most {} iterations; {}. Every figure: <a href=\"report.json\">report.json</a>.</p>\n",
        MULTUM_VERSION, html_escaped(report_.result.device),
        report_.result.renderer.empty() ? "not used in this run" : html_escaped(report_.result.renderer),
        job_.supersampling, job_.supersampling, s.gradient_tolerance, s.iteration_max,
        s.hold_out >= 2 ? fmt::format("every view number {} held out", s.hold_out) : "no view held out");
  }

  const InferenceReport& report_;
  const AnimationJob& job_;
  const ReportPictures& pictures_;
  std::vector<LayerSummary> layers_;
};

}  // namespace

std::string inference_page(const InferenceReport& report, const ReportPictures& pictures) {
  return InferencePage(report, pictures).html();
}

void write_inference_report(const ParameterizedScene& field, const InferenceReport& report) {
  const std::string& folder = report.settings.output;
  write_text_file(folder + "/report.json", inference_report_json(report));
  const ReportPictures pictures = write_report_pictures(field, report);
  write_text_file(folder + "/report.html", inference_page(report, pictures));
}

}  // namespace multum
