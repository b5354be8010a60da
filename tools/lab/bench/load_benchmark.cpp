// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/load_benchmark.h"

#include <ImfThreading.h>
#include <fmt/format.h>

#include <filesystem>
#include <functional>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/stopwatch.h"
#include "runtime_gl/materials/movmf_material.h"
#include "tools/lab/bench/documents/markdown_table.h"
#include "tools/lab/bench/measuring/bake_programs.h"
#include "tools/lab/bench/measuring/machine.h"
#include "tools/lab/bench/measuring/measured_program.h"
#include "tools/lab/bench/measuring/scratch_folder.h"
#include "tools/lab/bench/measuring/statistics.h"

namespace multum::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr StorageEncoding kEncodings[] = {StorageEncoding::kSnorm16, StorageEncoding::kHalf, StorageEncoding::kFloat};
// Every compression of a file. For zip, the list contains the fastest level, the default level of OpenEXR 3.1, and the
// highest level.
constexpr const char* kCompressions[] = {"none", "rle", "zips", "zip:1", "zip:4", "zip:9", "piz"};

double seconds_of(const std::function<void()>& body) {
  const Stopwatch stopwatch;
  body();
  return stopwatch.seconds();
}

struct FileTimes {
  std::vector<double> write, read_alone, read_shared, upload;
  std::uintmax_t bytes = 0;
};

struct Workplace {
  const gl::HeadlessContext& context;
  std::string path;
  int threads;
};

// Reads a file from the page cache. Sets the size of OpenEXR's thread pool, which otherwise only grows. If the number
// of threads is 0, the calling thread does all work.
MovmfMipmap read_timed(const Workplace& at, int threads, std::vector<double>& times) {
  Imf::setGlobalThreadCount(threads > 1 ? threads : 0);
  MovmfMipmap mipmap;
  times.push_back(seconds_of([&] { mipmap = read_movmf_mipmap(at.path, threads); }));
  return mipmap;
}

// Writes and syncs a file, reads it, uploads it, and waits until GL has finished. Returns the checksum of the pixels
// that were read.
std::string measure_once(const Workplace& at, const MovmfMipmap& mipmap, const char* compression, FileTimes& times) {
  const BakedWriteOptions options{compression, BakedWriteOptions().tile_size, at.threads};
  std::filesystem::remove(at.path);
  times.write.push_back(seconds_of([&] { write_movmf_mipmap(at.path, mipmap, options); }));
  times.bytes = std::filesystem::file_size(at.path);
  read_timed(at, at.threads, times.read_shared);
  const MovmfMipmap found = read_timed(at, 1, times.read_alone);
  times.upload.push_back(seconds_of([&] {
    const gl::MovmfMaterial material(at.context.functions(), found, 1.0f);
    at.context.functions().Finish();
  }));
  const std::string hash = movmf_content_hash(found, at.threads);
  if (hash != found.header.provenance.content_hash)
    throw Error(ErrorCode::kVerification, fmt::format("{}: read the checksum {}, expected {} as written", at.path, hash,
                                                      found.header.provenance.content_hash));
  return hash;
}

MovmfMipmap bake_as_floats(const LoadBenchmarkOptions& options, const ScratchFolder& folder, Progress* progress) {
  const std::string map = make_map_file(folder.path(), options.size, progress), baked = folder / "map.ndf.exr";
  const BakeCommandOptions bake{options.lobes, options.threads, "", {"-d", "float", "--no-measure"}};
  run_to_disk(multum_bake_command(map, baked, bake), baked, progress);
  return read_movmf_mipmap(baked);
}

std::uint64_t texture_bytes(const MovmfMipmap& mipmap) {
  std::uint64_t texels = 0;
  for (const MovmfLevel& level : mipmap.levels) texels += level.lobes[0].size();
  return texels * static_cast<std::uint64_t>(mipmap.lobe_count()) *
         (mipmap.header.encoding == StorageEncoding::kFloat ? 16 : 8);
}

}  // namespace

Json run_load_benchmark(const LoadBenchmarkOptions& options, Progress* progress) {
  const int threads = options.threads > 0 ? options.threads : core_count();
  const auto context = gl::make_headless_context(options.context, gl::DebugOutput::kOff);
  const ScratchFolder folder(options.folder);
  const MovmfMipmap baked = bake_as_floats(options, folder, progress);
  const Workplace at{*context, folder / "rounded.ndf.exr", threads};
  FileTimes cold;  // times of the first file, which include the time to start threads and to allocate memory
  measure_once(at, baked, kCompressions[0], cold);
  Json files = Json::array();
  ContentHash all;
  for (const StorageEncoding encoding : kEncodings) {
    MovmfMipmap mipmap = baked;
    mipmap.header.encoding = encoding;
    quantize_movmf(mipmap, threads);
    std::vector<FileTimes> times(std::size(kCompressions));
    for (int i = 0; i < options.repetitions; ++i)  // the compressions are measured alternately
      for (std::size_t c = 0; c < times.size(); ++c) {
        const std::string hash = measure_once(at, mipmap, kCompressions[c], times[c]);
        if (i == 0) all.update(hash);
        progress_advance(progress, 0);
      }
    for (std::size_t c = 0; c < times.size(); ++c)
      files.push_back({{"encoding", storage_encoding_name(encoding)},
                       {"compression", kCompressions[c]},
                       {"file_bytes", times[c].bytes},
                       {"texture_bytes", texture_bytes(mipmap)},
                       {"write_s", spread_json(spread_of(times[c].write))},
                       {"read_s", spread_json(spread_of(times[c].read_alone))},
                       {"read_threaded_s", spread_json(spread_of(times[c].read_shared))},
                       {"upload_s", spread_json(spread_of(times[c].upload))}});
    fmt::print(stderr, "{}: done\n", storage_encoding_name(encoding));
  }
  return {{"device", context->description()},
          {"file_system", file_system_name(folder.path())},
          {"size", options.size},
          {"lobes", options.lobes},
          {"threads", threads},
          {"repetitions", options.repetitions},
          {"result_hash", all.finish()},
          {"files", files}};
}

ResultView view_load(const Json& result) {
  const int threads = result.at("threads").get<int>();
  MarkdownTable table({"encoding", "compression", "on disk, MB", "on the GPU, MB", "write, s", "read, s",
                       fmt::format("read with {} threads, s", threads), "upload, s"});
  for (const Json& file : result.at("files")) {
    std::vector<std::string> row = {file.at("encoding"), file.at("compression"),
                                    rounded_text(file.at("file_bytes").get<double>() / 1e6),
                                    rounded_text(file.at("texture_bytes").get<double>() / 1e6)};
    for (const char* key : {"write_s", "read_s", "read_threaded_s", "upload_s"})
      row.push_back(spread_text(parse_spread(file.at(key))));
    table.add(row);
  }
  return {
      "Files: size, writing, reading, upload",
      fmt::format("The file contains the four-quarter map of {0} x {0} texels with {1} lobes and all levels. *Write* "
                  "includes the checksum, compression and the sync to disk ({2}) with {3} threads. *Read* is the time "
                  "to read the file from the page cache and to decode it to floats, with one thread and with {3} "
                  "threads. multum-view uses all threads. *Upload* is the time to convert the data to GL textures as "
                  "multum-view does, until GL has finished. All encodings ran alternately, {4} times each.",
                  result.at("size").get<int>(), result.at("lobes").get<int>(),
                  result.at("file_system").get<std::string>(), threads, result.at("repetitions").get<int>()),
      table.text()};
}

}  // namespace multum::bench
