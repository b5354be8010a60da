// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/uastc/uastc_encoder.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/delivery/export/texel_format.h"
#include "host/delivery/export/uastc/uastc_scripts.h"
#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/processes/child_process.h"

namespace multum {
namespace {

constexpr int kNoPackage = 3;  // exit code of the script

[[noreturn]] void refuse_encoder(const UastcSettings& settings, const std::string& what) {
  throw Error(ErrorCode::kEnvironment,
              settings.option + " uastc: " + what +
                  "; expected Node.js 18 or later and its package ktx2-encoder. Run 'npm install ktx2-encoder' in this "
                  "folder, or give the package's folder with --encoder FOLDER. " +
                  settings.option + " rgba8 needs neither");
}

bool wants_to_stop(Progress* progress) {
  try {
    progress_advance(progress, 0);
    return false;
  } catch (const Cancelled&) {
    return true;
  }
}

void run_script(const UastcSettings& settings, const nlohmann::json& plan, Progress* progress) {
  const std::string script = settings.folder + "/encode_uastc.mjs", plan_file = settings.folder + "/uastc_plan.json";
  write_text_file(script, uastc_scripts().at("encode_uastc.mjs"));
  write_text_file(plan_file, json_text(plan));
  ChildLimits limits;
  limits.time_max = std::chrono::hours(24);
  bool is_cancelled = false;
  limits.is_cancelled = [&] { return is_cancelled = is_cancelled || wants_to_stop(progress); };
  ChildResult result;
  try {
    result = run_child({"node", script, plan_file}, limits);
  } catch (const Error& error) {
    refuse_encoder(settings, error.what());
  }
  if (is_cancelled) throw Cancelled();
  if (result.exit_code == kNoPackage)
    refuse_encoder(settings,
                   settings.encoder.empty() ? "ktx2-encoder was not found" : settings.encoder + ": no ktx2-encoder");
  if (result.exit_code != 0)
    refuse_encoder(settings,
                   fmt::format("the encoder ended with {}: {}",
                               result.signal != 0 ? fmt::format("signal {}", result.signal)
                                                  : fmt::format("exit code {}", result.exit_code),
                               result.output.substr(result.output.size() > 400 ? result.output.size() - 400 : 0)));
}

nlohmann::json plan_of(const UastcSettings& settings) {
  std::error_code error;
  const std::string encoder =
      settings.encoder.empty() ? "" : std::filesystem::absolute(settings.encoder, error).string();
  return {{"encoder", encoder},
          {"threads", settings.threads},
          {"effort", settings.effort},
          {"normals", settings.has_normals}};
}

}  // namespace

void check_uastc_encoder(const UastcSettings& settings) { run_script(settings, plan_of(settings), nullptr); }

std::vector<std::vector<std::uint8_t>> encode_uastc(const LevelFile& levels, const UastcSettings& settings,
                                                    Progress* progress, const LevelFile* decoded) {
  const std::string blocks_file = settings.folder + "/uastc_blocks";
  nlohmann::json plan = plan_of(settings);
  plan["input"] = std::filesystem::absolute(levels.path()).string();
  plan["output"] = std::filesystem::absolute(blocks_file).string();
  if (decoded != nullptr) plan["decoded"] = std::filesystem::absolute(decoded->path()).string();
  for (int level = 0; level < levels.level_count(); ++level)
    plan["levels"].push_back(
        {{"width", mip_level_size(levels.width(), level)}, {"height", mip_level_size(levels.height(), level)}});
  run_script(settings, plan, progress);
  std::ifstream file(blocks_file, std::ios::binary);
  const LeveledTexture texture{TexelFormat::kUastc, levels.width(), levels.height(), levels.level_count()};
  std::vector<std::vector<std::uint8_t>> made;
  for (int level = 0; level < levels.level_count(); ++level) {
    std::vector<std::uint8_t> blocks(level_bytes(texture, level));
    file.read(reinterpret_cast<char*>(blocks.data()), static_cast<std::streamsize>(blocks.size()));
    if (!file) refuse_encoder(settings, "the block file that the encoder wrote is incomplete");
    made.push_back(std::move(blocks));
  }
  return made;
}

}  // namespace multum
