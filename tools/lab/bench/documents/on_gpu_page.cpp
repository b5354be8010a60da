// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/documents/on_gpu_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "tools/lab/bench/documents/markdown_table.h"
#include "tools/lab/bench/documents/result_file.h"
#include "tools/lab/bench/measuring/statistics.h"

namespace multum::bench {
namespace {

using Json = nlohmann::ordered_json;

double mib(const Json& bytes) { return bytes.get<double>() / (1 << 20); }

std::vector<const Json*> steps_named(const Json& result, const std::string& beginning, bool done_alone = true) {
  std::vector<const Json*> found;
  for (const Json& step : result.at("steps"))
    if (step.at("name").get<std::string>().starts_with(beginning) && (!done_alone || step.contains("result")))
      found.push_back(&step);
  return found;
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  std::replace(text.begin(), text.end(), '|', '/');
  return text;
}

// Returns the name of a file without its folder, because the folder depends on the machine.
std::string file_name(const Json& path) {
  return path.get<std::string>().substr(path.get<std::string>().rfind('/') + 1);
}

std::string devices_text(const Json& result) {
  std::string text = "## Devices\n\n";
  MarkdownTable devices({"device", "platform, driver", "OpenCL", "compute units", "memory, GiB", "local memory, KiB",
                         "64-bit atomics", "IEEE division on request"});
  for (const Json& d : result.at("devices"))
    devices.add({one_line(d.at("name")),
                 one_line(d.at("platform").get<std::string>() + ", " + d.at("driver").get<std::string>()),
                 one_line(d.at("version")), std::to_string(d.at("compute_units").get<int>()),
                 fmt::format("{:.1f}", mib(d.at("memory_bytes")) / 1024.0),
                 fmt::format("{:.0f}", d.at("local_bytes").get<double>() / 1024.0),
                 d.at("has_atomic_longs").get<bool>() ? "yes" : "no",
                 d.at("is_cpu").get<bool>()              ? "always"
                 : d.at("rounds_when_asked").get<bool>() ? "yes"
                                                         : "no"});
  text += devices.text() + "\n";
  MarkdownTable drivers({"driver library", "for", "named by"});
  for (const char* kind : {"opencl", "egl"})
    for (const Json& driver : result.at("drivers").at(kind)) {
      const std::string named = file_name(driver.at("named_by"));
      drivers.add({file_name(driver.at("library")), kind,
                   named.empty() ? "none; on-gpu tells the loader about this library" : named});
    }
  text += drivers.text() + "\n";
  for (const Json* step : steps_named(result, "GL contexts")) {
    MarkdownTable contexts({"GL display", "software renderer", "result"});
    for (const Json& row : (*step)["result"].at("contexts")) {
      const auto description = row.at("description").get<std::string>();
      contexts.add({row.at("display"), row.at("is_software").get<bool>() ? "yes" : "no",
                    one_line(description.empty() ? "none: " + row.at("reason").get<std::string>() : description)});
    }
    text += contexts.text() + "\n";
  }
  return text;
}

std::string steps_text(const Json& result) {
  MarkdownTable table({"step", "result", "s", "reason, or failed tests"});
  for (const Json& step : result.at("steps")) {
    std::string reason = step.value("reason", "");
    if (step.contains("result") && step["result"].contains("failures"))
      for (const Json& failure : step["result"]["failures"])
        reason += (reason.empty() ? "" : "; ") + failure.at("name").get<std::string>();
    if (step.contains("result") && step["result"].contains("cases"))
      for (const Json& verdict : step["result"]["cases"])
        if (!verdict.at("holds").get<bool>())
          reason += (reason.empty() ? "" : "; ") + verdict.at("name").get<std::string>();
    table.add({step.at("name"), step.at("status"),
               step.contains("seconds") ? fmt::format("{:.1f}", step["seconds"].get<double>()) : "-",
               reason.empty() ? "-" : one_line(reason.substr(0, 300))});
  }
  return "## Steps\n\n" + table.text() + "\n";
}

std::string checks_text(const Json& result) {
  std::string text;
  for (const Json* step : steps_named(result, "selftest"))
    text += fmt::format("- `multum selftest`: {} numerical cases, {} failed.\n", (*step)["result"].at("cases").size(),
                        (*step)["result"].at("broken").get<int>());
  for (const Json* step : steps_named(result, "tests "))
    text += fmt::format("- `{}`: {} tests, {} failed.\n", (*step)["name"].get<std::string>().substr(6),
                        (*step)["result"].at("tests").get<int>(), (*step)["result"].at("broken").get<int>());
  return text.empty() ? "" : "## Checks\n\n" + text + "\n";
}

double stage(const Json& bake, const std::string& name) {
  for (const Json& row : bake.at("stages"))
    if (row.at("name") == name) return row.at("seconds").get<double>();
  return 0.0;
}

std::string first_bake_text(const Json& result) {
  std::string text;
  for (const Json* step : steps_named(result, "first bake")) {
    const int size = (*step)["result"].at("size").get<int>();
    const Json &first = (*step)["result"].at("first"), &second = (*step)["result"].at("second");
    text += fmt::format(
        "The first bake on a machine compiles {} program variants. A whole bake takes {:.2f} s the first time and "
        "{:.2f} s the second time, for the four-quarter map of {} x {} texels. Before the first run, the caches of "
        "multum and of the driver were empty.\n\n",
        first.at("programs").get<int>(), first.at("process").at("wall_s").get<double>(),
        second.at("process").at("wall_s").get<double>(), size, size);
  }
  return text;
}

// Describes the steps of whole bakes for every device that ran them.
std::string bakes_text(const Json& result) {
  MarkdownTable table({"map", "device", "read, s", "search for starting lobes, s", "binning, s", "levels, s",
                       "write, s", "whole process, s", "processor time, s", "device memory, MiB",
                       "copied to and from the device, MiB"});
  for (const Json* step : steps_named(result, "bake ")) {
    const Json& bake = (*step)["result"].at("bake");
    double levels = 0.0;
    for (const Json& level : bake.at("levels")) levels += level.at("seconds").get<double>();
    const Json& copies = bake.at("transfers");
    table.add({std::to_string((*step)["result"].at("size").get<int>()), one_line(bake.at("device")),
               rounded_text(stage(bake, "read")), rounded_text(bake.at("start").at("seconds").get<double>()),
               rounded_text(bake.at("binning").at("seconds").get<double>()), rounded_text(levels),
               rounded_text(stage(bake, "write")), rounded_text(bake.at("process").at("wall_s").get<double>()),
               rounded_text(bake.at("process").at("cpu_s").get<double>()),
               fmt::format("{:.0f}", mib(bake.at("device_bytes_peak"))),
               fmt::format("{:.0f}, {:.0f}", mib(copies.at("upload_bytes")), mib(copies.at("download_bytes")))});
  }
  return "## Whole bakes\n\nEach bake reads the four-quarter map from a 16-bit PNG and writes a file with four lobes, "
         "without measuring errors. One untimed run per size compiled the kernels first. The size 16384 ran only once. "
         "multum fits levels while it rounds and writes other levels, so the steps overlap.\n\n" +
         table.text() + "\n";
}

// States whether all devices write the same bytes.
std::string bytes_text(const Json& result) {
  std::string text;
  const std::vector<const Json*> steps = steps_named(result, "bake ");
  for (std::size_t i = 0; i < steps.size(); ++i)
    for (std::size_t k = i + 1; k < steps.size(); ++k) {
      const Json &a = (*steps[i])["result"], &b = (*steps[k])["result"];
      if (a.at("size") != b.at("size")) continue;
      const bool same = a.at("bake").at("content_hash") == b.at("bake").at("content_hash");
      text += fmt::format("- {0} x {0}: {1} and {2} write {3}.\n", a.at("size").get<int>(),
                          a.at("bake").at("device").get<std::string>(), b.at("bake").at("device").get<std::string>(),
                          same ? "the same bytes" : "different bytes");
    }
  return text.empty() ? "" : "### Equal bytes\n\n" + text + "\n";
}

std::string kernels_text(const Json& result) {
  std::string text;
  for (const Json* step : steps_named(result, "bake ")) {
    if (!(*step)["result"].contains("timed") || !(*step)["result"]["timed"].contains("launch_seconds")) continue;
    const Json& bake = (*step)["result"]["timed"];
    MarkdownTable table({"kernel", "launches", "on the device, s"});
    double sum = 0.0;
    for (const auto& [kernel, seconds] : bake.at("launch_seconds").items()) {
      table.add({"`" + kernel + "`", std::to_string(bake.at("launches").at(kernel).get<int>()),
                 rounded_text(seconds.get<double>())});
      sum += seconds.get<double>();
    }
    table.add({"all", "", rounded_text(sum)});
    text += fmt::format(
        "### Kernels of the bake of {0} x {0}, {1}\n\nThe times were measured with the device's timer. This bake also "
        "measured errors.\n\n{2}\n",
        (*step)["result"].at("size").get<int>(), bake.at("device").get<std::string>(), table.text());
  }
  return text;
}

std::string bench_text(const Json& result, const std::string& beginning) {
  std::string text;
  for (const Json* step : steps_named(result, beginning)) {
    const ResultView view = view_of((*step)["result"]);
    text += fmt::format("### {}, on {}\n\n{}\n\n{}\n", view.title, (*step)["result"].at("device").get<std::string>(),
                        view.method, view.table);
  }
  return text;
}

// Lists the most important results.
std::string summary_text(const Json& result) {
  std::string text;
  const std::vector<const Json*> em = steps_named(result, "em "), bakes = steps_named(result, "bake ");
  for (std::size_t i = 0; i + 1 < em.size(); ++i) {
    const Json &gpu = (*em[i])["result"], &cpu = (*em[i + 1])["result"];
    if (gpu.at("size") != cpu.at("size")) continue;
    const double a = gpu.at("kernels_ms").get<double>(), b = cpu.at("kernels_ms").get<double>();
    text += fmt::format(
        "- EM of {0} x {0} texels takes {1} ms on the GPU. On the processor, the same kernels take {3} ms on {2} "
        "cores, which is {4} times as long.\n",
        gpu.at("size").get<int>(), rounded_text(a), result.at("cores").get<int>(), rounded_text(b),
        rounded_text(b / a));
  }
  for (std::size_t i = 0; i + 1 < bakes.size(); ++i) {
    const Json &gpu = (*bakes[i])["result"], &cpu = (*bakes[i + 1])["result"];
    if (gpu.at("size") != cpu.at("size")) continue;
    const auto seconds = [](const Json& bake) { return bake.at("bake").at("process").at("wall_s").get<double>(); };
    text += fmt::format(
        "- A whole bake of {0} x {0} texels, from file to file, takes {1} s if the kernels run on the GPU, and {2} s "
        "if they run on the processor. "
        "In both cases, reading, rounding, compression and writing run on the processor.\n",
        gpu.at("size").get<int>(), rounded_text(seconds(gpu)), rounded_text(seconds(cpu)));
  }
  for (const Json* step : steps_named(result, "frames"))
    for (const Json& row : (*step)["result"].at("rows"))
      if (row.at("name") == "4 lobes")
        text += fmt::format(
            "- A frame with four lobes at anisotropy {:.0f} takes {} ms, which is {} times as long as a frame with "
            "averaged normals and Toksvig's rule.\n",
            row.at("anisotropy").get<double>(), rounded_text(parse_spread(row.at("draw_ms")).median),
            rounded_text(parse_spread(row.at("ratio")).median));
  return text.empty() ? "" : "## Summary\n\n" + text + "\n";
}

}  // namespace

std::string page_of_run(const Json& result) {
  std::string text = fmt::format(
      "# multum on a GPU\n\n"
      "This page lists multum's times, memory and test results on one GPU.\n\n"
      "Generated by `{}`. Do not edit.\n\n"
      "Device: {}. {}\n\n",
      result.at("command").get<std::string>(),
      result.contains("device") ? result.at("device").get<std::string>() : "no device yet", conditions_text(result));
  if (result.contains("is_gpu") && !result.at("is_gpu").get<bool>())
    text +=
        "**This device is a processor. The page only shows that the command works, and contains no GPU times.**\n\n";
  if (!result.contains("devices")) return text;
  text += summary_text(result) + devices_text(result) + steps_text(result) + checks_text(result);
  if (!steps_named(result, "bake ").empty())
    text += bakes_text(result) + first_bake_text(result) + bytes_text(result) + kernels_text(result);
  if (!steps_named(result, "em ").empty()) text += "## EM\n\n" + bench_text(result, "em ");
  if (!steps_named(result, "frames").empty()) text += "## Drawing\n\n" + bench_text(result, "frames");
  if (!steps_named(result, "texture inference").empty())
    text += "## Texture inference\n\n" + bench_text(result, "texture inference");
  while (text.ends_with("\n\n")) text.pop_back();
  return text;
}

}  // namespace multum::bench
