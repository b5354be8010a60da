// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/on_gpu.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "host/formats/asset/baked_file.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/processes/child_process.h"
#include "tools/lab/bench/documents/on_gpu_page.h"
#include "tools/lab/bench/documents/result_file.h"
#include "tools/lab/bench/measuring/bake_programs.h"
#include "tools/lab/bench/measuring/driver_search.h"
#include "tools/lab/bench/measuring/machine.h"
#include "tools/lab/bench/measuring/measured_program.h"
#include "tools/lab/bench/measuring/scratch_folder.h"

namespace multum::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

// Tests that need no other program. The filters exclude cases that read source files.
constexpr std::pair<const char*, const char*> kTests[] = {{"kernel_test", "*"},
                                                          {"pyramid_test", "*"},
                                                          {"inference_test", "*"},
                                                          {"hard_case_test", "*"},
                                                          {"stability_test", "-SelftestRegistry.*:Of/SelftestCases.*"},
                                                          {"gl_test", "*"},
                                                          {"environment_test", "*"},
                                                          {"probe_test", "*"},
                                                          {"gl_stability_test", "GlslCases.Hold*"}};

// A step is limited to this many times its estimated time, so that time for other steps remains.
constexpr double kPatience = 4.0;

Json read_json(const std::string& path) {
  std::ifstream in(path);
  return in ? Json::parse(in, nullptr, false) : Json();
}

class OnGpuRun {
 public:
  OnGpuRun(const OnGpuOptions& options, const std::string& command, Progress* progress)
      : options_(options),
        progress_(progress),
        folder_(options.folder),
        end_(Clock::now() + std::chrono::milliseconds(static_cast<long>(options.minutes * 60000.0))) {
    const DriverSearch drivers = find_drivers();
    name_drivers(drivers, folder_.path());
    // Starts with empty caches, and does not write to the user's caches. A small run uses existing caches, because
    // nobody uses its times.
    for (const char* variable : {"MULTUM_CACHE_DIR", "POCL_CACHE_DIR", "CUDA_CACHE_PATH"}) {
      if (options_.small && std::getenv(variable) != nullptr) continue;
      const std::string cache = folder_ / variable;
      fs::create_directories(cache);
      setenv(variable, cache.c_str(), 1);
    }
    result_ = make_result("on-gpu", command, Json::object());
    result_["drivers"] = {{"opencl", drivers_json(drivers.opencl)}, {"egl", drivers_json(drivers.egl)}};
    result_["steps"] = Json::array();
  }

  int run() {
    choose_device();
    const std::vector<int> sizes = options_.small ? std::vector<int>{64, 128} : std::vector<int>{1024, 4096};
    const std::vector<int> em_sizes = options_.small ? std::vector<int>{64} : std::vector<int>{512, 2048, 4096};
    step("GL contexts", 5, [&](double left) {
      const std::string file = folder_ / "contexts.json";
      child({neighbouring_program("multum-bench"), "contexts", "--json", file}, left);
      return Json{{"contexts", read_json(file)}};
    });
    step("first bake", 10, [&](double left) { return first_bake(left); });
    step("selftest", 20, [&](double left) { return selftest(left); });
    for (const int size : sizes)
      for (const auto& [name, device] : devices_)
        step(fmt::format("bake {} on {}", size, name), size > 2048 ? 20 : 8,
             [&, size, used = device](double left) { return bake(size, used, left); });
    const auto em_step = [&](int size, double wanted, std::size_t d) {
      step(fmt::format("em {} on {}", size, devices_[d].first), wanted,
           [&, size, d](double left) { return em(size, devices_[d].second, d == 0, left); });
    };
    for (std::size_t d = 0; d < devices_.size(); ++d) em_step(em_sizes[0], 10, d);
    step("frames", 30, [&](double left) { return frames(left); });
    step("texture inference", 30, [&](double left) { return infer(left); });
    for (const auto& [name, filter] : kTests)
      step(fmt::format("tests {}", name), 15,
           [&, program = name, wanted = filter](double left) { return tests(program, wanted, left); });
    for (std::size_t i = 1; i < em_sizes.size(); ++i)
      for (std::size_t d = 0; d < devices_.size(); ++d) em_step(em_sizes[i], em_sizes[i] > 2048 ? 40 : 20, d);
    if (!options_.small) step("bake 16384", 90, [&](double left) { return bake(16384, options_.device, left); });
    write();
    fmt::print("{}.json and {}.md written\n", options_.output, options_.output);
    return has_broken_ ? exit_code(ErrorCode::kVerification) : 0;
  }

 private:
  static Json drivers_json(const std::vector<FoundDriver>& drivers) {
    Json json = Json::array();
    for (const FoundDriver& driver : drivers)
      json.push_back({{"library", driver.library}, {"named_by", driver.named_by}});
    return json;
  }

  // Runs a program for at most this many seconds. The exit code of the program must be one of `expected`.
  ChildResult child(const std::vector<std::string>& command, double seconds, const std::vector<int>& expected = {0}) {
    ChildLimits limits;
    limits.time_max = std::chrono::milliseconds(static_cast<long>(seconds * 1000.0));
    const ChildResult result = run_child(command, limits);
    progress_advance(progress_, 0);
    const auto fail = [&](const std::string& how) { throw Error(ErrorCode::kEnvironment, how); };
    if (result.is_over_time) fail(fmt::format("not done after {:.0f} s", seconds));
    if (result.signal != 0) fail(fmt::format("terminated by signal {}: {}", result.signal, last_words(result.output)));
    if (std::find(expected.begin(), expected.end(), result.exit_code) == expected.end())
      fail(fmt::format("exit code {}: {}", result.exit_code, last_words(result.output)));
    return result;
  }

  void step(const std::string& name, double seconds_wanted, const std::function<Json(double left)>& body) {
    const double left = std::chrono::duration<double>(end_ - Clock::now()).count();
    Json row = {{"name", name}};
    if (left < seconds_wanted) {
      row["status"] = "left out";
      row["reason"] = fmt::format("{:.0f} s were left, it wants {:.0f}", std::max(left, 0.0), seconds_wanted);
    } else {
      fmt::print(stderr, "on_gpu: {} ...\n", name);
      const auto begin = Clock::now();
      try {
        row["result"] = body(std::min(left, kPatience * seconds_wanted));
        const bool is_broken = row["result"].value("broken", 0) > 0;
        row["status"] = is_broken ? "broken" : "done";
        has_broken_ = has_broken_ || is_broken;
      } catch (const Cancelled&) {
        throw;
      } catch (const std::exception& error) {
        row["status"] = "failed";
        row["reason"] = error.what();
      }
      row["seconds"] = std::chrono::duration<double>(Clock::now() - begin).count();
    }
    fmt::print(stderr, "on_gpu: {}: {}\n", name, row["status"].get<std::string>());
    result_["steps"].push_back(row);
    write();
  }

  void write() {
    write_text_file(options_.output + ".json", result_.dump(2) + "\n");
    write_text_file(options_.output + ".md", page_of_run(result_));
  }

  // Chooses a device as Device::open() does, but from the list of a child process, so that a crashing driver ends only
  // the child.
  void choose_device() {
    const std::string listed = folder_ / "devices.json";
    child({neighbouring_program("multum"), "devices", "--report", listed}, 60);
    result_["devices"] = read_json(listed);
    std::vector<DeviceInfo> devices;
    std::string cpu;
    for (const Json& row : result_["devices"]) {
      DeviceInfo info{};
      info.index = row.at("index");
      info.name = row.at("name");
      info.platform = row.at("platform");
      info.is_cpu = row.at("is_cpu");
      devices.push_back(info);
      if (info.is_cpu && cpu.empty()) cpu = std::to_string(info.index);
    }
    auto chosen = multum::choose_device(devices, options_.device);
    if (!chosen && options_.any_device) chosen = multum::choose_device(devices, "");
    const bool is_refused = chosen && devices[*chosen].is_cpu && options_.device.empty() && !options_.any_device;
    if (!chosen || is_refused)
      throw Error(
          ErrorCode::kEnvironment,
          fmt::format("no GPU{} among the OpenCL devices found (devices: {}, driver libraries: {}); expected one, or "
                      "--any-device to measure a processor",
                      options_.device.empty() ? "" : " that matches '" + options_.device + "'", devices.size(),
                      result_["drivers"]["opencl"].size()));
    const DeviceInfo& device = devices[*chosen];
    options_.device = std::to_string(device.index);
    result_["device"] = device.name;
    result_["is_gpu"] = !device.is_cpu;
    devices_.emplace_back(device.is_cpu ? "the processor" : "the GPU", options_.device);
    if (!device.is_cpu && !cpu.empty()) devices_.emplace_back("the processor", cpu);
    write();
  }

  std::string map_of(int size, double left) {
    const std::string prefix = folder_ / std::to_string(size), map = prefix + "_normal.png";
    if (!fs::exists(map))
      child({neighbouring_program("multum"), "testmap", prefix, "--size", std::to_string(size)}, left);
    return map;
  }

  // Returns the report of a bake, together with the costs of the whole process and the checksum of its output.
  Json bake_once(const std::string& map, const std::string& device, const std::vector<std::string>& more, double left) {
    const std::string output = folder_ / "baked.ndf.exr", report = folder_ / "report.json";
    BakeCommandOptions bake;
    bake.lobes = 0;
    bake.report = report;
    bake.appended = {"--device", device};
    bake.appended.insert(bake.appended.end(), more.begin(), more.end());
    const ChildResult result = child(multum_bake_command(map, output, bake), left);
    Json row = read_json(report);
    row["process"] = {{"wall_s", result.usage.wall_seconds},
                      {"cpu_s", result.usage.cpu_seconds()},
                      {"peak_bytes", result.usage.peak_memory_bytes}};
    row["content_hash"] = read_baked_header(output).provenance.content_hash;
    return row;
  }

  Json first_bake(double left) {
    const int size = options_.small ? 64 : 512;
    const std::string map = map_of(size, left);
    Json result = {{"size", size}};
    for (const char* name : {"first", "second"}) result[name] = bake_once(map, options_.device, {"--no-measure"}, left);
    return result;
  }

  Json selftest(double left) {
    const std::string file = folder_ / "selftest.json";
    std::vector<std::string> command = {
        neighbouring_program("multum"), "selftest", "--quiet", "--device", options_.device, "--report", file};
    if (options_.small) command.insert(command.end(), {"--filter", "moment"});
    child(command, left, {0, exit_code(ErrorCode::kVerification)});
    Json result = read_json(file);
    int broken = 0;
    for (const Json& verdict : result.at("cases")) broken += verdict.at("holds").get<bool>() ? 0 : 1;
    result["broken"] = broken;
    return result;
  }

  // Bakes three times. The first bake compiles kernels, and the second bake is measured as a whole. The third bake uses
  // a timer for every launch, which makes some launches slower.
  Json bake(int size, const std::string& device, double left) {
    const std::string map = map_of(size, left);
    if (size <= 4096) bake_once(map, device, {"--no-measure"}, left);
    Json result = {{"size", size}, {"bake", bake_once(map, device, {"--no-measure"}, left)}};
    if (size <= 4096) {
      result["timed"] = bake_once(map, device, {"--runstats"}, left);
      result["error"] = result["timed"]["error"];
    }
    return result;
  }

  // Measures the times of the EM kernels and, for one device, of the yardstick.
  Json em(int size, const std::string& device, bool with_yardstick, double left) {
    std::vector<std::string> command = {"em", "--size", std::to_string(size), "--device", device, "--threads", "0"};
    command.insert(command.end(), {"--repetitions", options_.small ? "1" : size > 2048 ? "2" : "5"});
    if (!with_yardstick) command.push_back("--no-yardstick");
    return bench(command, left);
  }

  Json frames(double left) {
    std::vector<std::string> command = {"frames", "--device", options_.device, "--context", "auto"};
    if (options_.small) command.insert(command.end(), {"--size", "64", "--picture", "96x54", "--repetitions", "1"});
    return bench(command, left);
  }

  Json infer(double left) {
    std::vector<std::string> command = {
        "infer",         "--device", options_.device, "--threads", std::to_string(std::min(core_count(), 8)),
        "--repetitions", "2"};
    command.insert(command.end(), {"--size", options_.small ? "32" : "512", "--views", options_.small ? "1" : "2"});
    return bench(command, left);
  }

  Json bench(std::vector<std::string> command, double left) {
    const std::string file = folder_ / "bench.json";
    std::error_code ignored;
    fs::remove(file, ignored);
    command.insert(command.begin(), neighbouring_program("multum-bench"));
    command.insert(command.end(), {"--json", file});
    child(command, left);
    return read_json(file);
  }

  // Runs a test program, which reports its own failures.
  Json tests(const std::string& name, const std::string& filter, double left) {
    const std::string file = folder_ / "tests.json";
    std::error_code ignored;
    fs::remove(file, ignored);
    // Machines with a GPU often have no OSMesa.
    setenv("MULTUM_TEST_GL", result_.value("is_gpu", false) ? "egl" : "osmesa", 1);
    child({neighbouring_program(name), "--gtest_brief=1", "--gtest_filter=" + (options_.small ? "Numerics*" : filter),
           "--gtest_output=json:" + file},
          left, {0, 1});
    const Json said = read_json(file);
    Json result = {{"tests", said.at("tests")}, {"broken", said.at("failures")}, {"failures", Json::array()}};
    for (const Json& suite : said.at("testsuites"))
      for (const Json& test : suite.at("testsuite"))
        if (test.contains("failures"))
          result["failures"].push_back(
              {{"name", suite.at("name").get<std::string>() + "." + test.at("name").get<std::string>()},
               {"says", test.at("failures").at(0).at("failure").get<std::string>().substr(0, 400)}});
    return result;
  }

  OnGpuOptions options_;
  Progress* progress_;
  const ScratchFolder folder_;
  const Clock::time_point end_;
  std::vector<std::pair<std::string, std::string>> devices_;  // name of each device in the tables, and the name or
                                                              // number that selects it
  Json result_;
  bool has_broken_ = false;
};

}  // namespace

int run_on_gpu(const OnGpuOptions& options, const std::string& command, Progress* progress) {
  check_writable(options.output + ".json");
  check_writable(options.output + ".md");
  return OnGpuRun(options, command, progress).run();
}

std::string on_gpu_page(const std::string& json_path) {
  const Json result = read_json(json_path);
  if (!result.is_object() || result.value("benchmark", "") != "on-gpu")
    throw Error(ErrorCode::kInput, json_path + ": not a result of multum-bench on-gpu, expected its JSON file");
  return page_of_run(result);
}

}  // namespace multum::bench
