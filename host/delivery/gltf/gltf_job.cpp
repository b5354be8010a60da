// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/gltf/gltf_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "host/delivery/export/engines/engine_support.h"
#include "host/delivery/gltf/gltf_rewrite.h"
#include "host/delivery/gltf/source_fit.h"
#include "host/delivery/gltf/source_lobes.h"
#include "host/formats/image/normals/reading_parameters.h"
#include "host/formats/mesh/gltf_document.h"
#include "host/formats/opencl/device_counts.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/input_hashes.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/files/work_folder.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/messages/option_words.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/stopwatch.h"
#include "host/foundation/parameters/engine_presets.h"

namespace multum {
namespace {

constexpr int kBasisSideMultiple = 4;  // KHR_texture_basisu requires multiples of this for pixelWidth and pixelHeight

// Returns the files of the model, the named file first.
std::vector<std::string> input_files(const GltfAsset& asset) {
  std::vector<std::string> files = {asset.path};
  for (const char* name : {"buffers", "images"})
    for (const GltfJson& object : asset.array(name)) {
      const std::string uri = object.value("uri", "");
      if (uri.empty() || uri.starts_with("data:")) continue;
      files.push_back(uri_path(asset.path, uri));
    }
  std::sort(files.begin() + 1, files.end());
  files.erase(std::unique(files.begin() + 1, files.end()), files.end());
  return files;
}

void check_gltf_job(const GltfJob& job) {
  if (!job.output.ends_with(".glb")) throw Error(ErrorCode::kUsage, job.output + ": expected a name that ends in .glb");
  if (job.lobe_texels && !job.has_lobes) throw Error(ErrorCode::kUsage, "--lobe-texels needs lobes; add --lobes");
  check_paths_differ({job.input}, {job.output, job.report});
  check_writable(job.output);
  if (!job.report.empty()) check_writable(job.report);
}

nlohmann::ordered_json json_of_textures(const GltfReport::Textures& textures) {
  nlohmann::ordered_json json = {{"width", textures.width},
                                 {"height", textures.height},
                                 {"levels", textures.level_count},
                                 {"bytes", nlohmann::ordered_json::object()},
                                 {"storage", nlohmann::ordered_json::object()}};
  for (const auto& [name, texture] : textures.storage) {
    json["bytes"][name] = texture.byte_count;
    nlohmann::ordered_json& storage = json["storage"][name];
    storage = {{"format", texture.format}, {"points", 100.0 * texture.storage_error}};
    if (texture.refused_error > 0.0) storage[texture.refused_format + "_points"] = 100.0 * texture.refused_error;
    if (texture.fallback) storage["fallback_bytes"] = texture.fallback->byte_count;
  }
  return json;
}

class GltfConversion {
 public:
  GltfConversion(const GltfJob& job, Device& device, Progress* progress)
      : job_(job), device_(device), counts_(device), progress_(progress) {}

  GltfReport run() {
    check_gltf_job(job_);
    progress_stage(progress_, "read");
    InputHashes hashes;
    hashes.note(job_.input);
    const GltfAsset asset = read_gltf_asset(job_.input);
    const std::vector<std::string> inputs = input_files(asset);
    check_paths_differ(inputs, {job_.output, job_.report});
    for (const std::string& file : inputs) {
      std::error_code error;
      report_.bytes_before += std::filesystem::file_size(file, error);
      if (error) asset.refuse(fmt::format("refers to {}, which cannot be read: {}", file, error.message()));
    }
    GltfPlan plan = plan_gltf(asset, job_.is_anisotropic);

    folder_ = WorkFolder::take(partial_folder_of(job_.output));
    if (folder_ == nullptr) throw Error(ErrorCode::kEnvironment, job_.output + ": another process is writing it");
    folder_->clear();
    if (has_uastc() && !plan.sources.empty()) find_encoder();
    std::vector<PreparedSource> prepared;
    for (std::size_t s = 0; s < plan.sources.size(); ++s) {
      prepared.push_back(prepare_source(asset, plan.sources[s], fit_settings()));
      if (job_.has_lobes && job_.form == MaterialForm::kAuto && plan.colour_images[s])
        add_colours(asset, *plan.colour_images[s], fit_settings(), prepared.back());
    }
    lap("read");
    const std::vector<SourceTextures> textures = make_textures(asset, plan, prepared);
    report_materials(prepared, plan);

    progress_stage(progress_, "write");
    RewrittenGltf rewritten = rewrite_gltf(asset, plan, textures);
    for (const std::string& uri : rewritten.left_outside)
      warn(fmt::format("image {} has a type that glTF does not support, so it remains a separate file", uri));
    warn_of_format(plan);
    hashes.check_unchanged(job_.input);
    report_.bytes_after = write_glb(asset, std::move(rewritten.json), rewritten.contents, job_.output, progress_);
    lap("write");
    report_.device = device_.info().name;
    report_.launches = counts_.launches();
    if (!job_.report.empty()) write_text_file(job_.report, report_.to_json(job_));
    progress_finish(progress_);
    return std::move(report_);
  }

 private:
  bool has_uastc() const { return format_ == GltfTextureFormat::kUastc || format_ == GltfTextureFormat::kAuto; }
  // Falls back to RGBA8 if the user did not select UASTC or name an encoder, so that the first call on a machine works.
  void find_encoder() {
    try {
      check_uastc_encoder(uastc());
    } catch (const Error& error) {
      if (format_ != GltfTextureFormat::kAuto || !job_.encoder.empty() || error.code() != ErrorCode::kEnvironment)
        throw;
      format_ = GltfTextureFormat::kRgba8;
      warn(std::string("new textures are stored as RGBA8 instead of UASTC, and are larger: ") + error.what());
    }
  }
  void warn(const std::string& what) {
    report_.warnings.push_back(what);
    log_warning(job_.input, what);
  }
  void lap(const char* stage) { report_.seconds.emplace_back(stage, stopwatch_.lap()); }

  UastcSettings uastc() const { return {"--format", folder_->path(), job_.encoder, job_.uastc_effort, job_.threads}; }
  std::optional<LobeTexels> lobe_texels() const {
    if (job_.lobe_texels || job_.format != GltfTextureFormat::kRgba8) return job_.lobe_texels;
    return LobeTexels::kRgba8;
  }
  SourceFitSettings fit_settings() const {
    return {.folder = folder_->path(),
            .is_fast = job_.is_fast,
            .surface = job_.surface,
            .z_range = job_.z_range,
            .two_channel = job_.two_channel,
            .side_multiple = has_uastc() ? kBasisSideMultiple : 1,
            .memory_bytes = job_.memory_bytes,
            .threads = job_.threads};
  }

  void warn_of_format(const GltfPlan& plan) {
    if (std::none_of(plan.materials.begin(), plan.materials.end(), [](const auto& one) { return one.kept.empty(); }))
      return;
    int plain_count = 0, count = 0;
    for (const GltfReport::Textures& one : report_.textures)
      for (const auto& [name, texture] : one.storage)
        if (!name.starts_with("lobe")) ++count, plain_count += texture.format == "rgba8" ? 1 : 0;
    if (plain_count > 0)
      warn(fmt::format("{} of its {} new textures are KTX2 files with 8 bits per channel, a format that the extension "
                       "for such textures, KHR_texture_basisu, does not allow; ",
                       plain_count, count) +
           engine_line(MaterialFormat::kKtx2, MaterialTexels::kRgba8, "--format uastc"));
    if (format_ == GltfTextureFormat::kPng && count > 0)
      warn(
          "PNG has no mips: the new textures have only level 0, and the fitted levels are lost. Use --format uastc to "
          "keep them");
  }

  // If a source cannot be fitted, its materials stay unchanged.
  void report_materials(const std::vector<PreparedSource>& prepared, GltfPlan& plan) {
    std::vector<int> numbers(plan.sources.size(), -1);
    int count = 0;
    for (std::size_t s = 0; s < prepared.size(); ++s)
      if (prepared[s].kept.empty()) numbers[s] = count++;
    for (MaterialPlan& material : plan.materials) {
      if (material.kept.empty()) {
        const PreparedSource& source = prepared[material.source];
        material.kept = source.kept;
        material.is_bad = source.is_bad;
        material.is_plain = source.is_plain;
        material.notes.insert(material.notes.end(), source.notes.begin(), source.notes.end());
      }
      const bool is_kept = !material.kept.empty();
      report_.materials.push_back({material.name, material.kept, is_kept ? std::vector<std::string>{} : material.notes,
                                   is_kept ? -1 : numbers[material.source], form_text(prepared, material)});
    }
    warn_of_bad(plan);
  }

  // Describes the result of the pictures. The text is empty if no pictures were drawn.
  std::string form_text(const std::vector<PreparedSource>& prepared, const MaterialPlan& material) const {
    if (material.source >= prepared.size() || report_.forms[material.source].views.empty()) return "";
    return report_.forms[material.source].to_text(true);
  }

  // A bad map does not prevent the fits of other maps. If there are no other maps, the job fails.
  void warn_of_bad(const GltfPlan& plan) {
    for (const MaterialPlan& material : plan.materials) {
      if (!material.is_bad) continue;
      if (report_.fitted_count() == 0) refuse_file(job_.input, fmt::format("'{}': {}", material.name, material.kept));
      warn(fmt::format("material '{}' is unchanged: {}", material.name, material.kept));
    }
  }

  // Fits a source. If its image is unusable or not a normal map, the materials that use the image stay unchanged.
  std::optional<FittedSource> fit(const GltfAsset& asset, PreparedSource& source, std::size_t number) {
    try {
      return fit_source(device_, asset, source, number, fit_settings(), progress_);
    } catch (const Error& error) {
      source.kept = why_kept(asset, error);
      source.is_bad = true;
      return std::nullopt;
    }
  }

  std::vector<SourceTextures> make_textures(const GltfAsset& asset, const GltfPlan& plan,
                                            std::vector<PreparedSource>& prepared) {
    std::uint64_t units = 0;
    for (const PreparedSource& source : prepared)
      if (source.kept.empty())
        units += ((source.source.is_anisotropic ? 4u : 3u) + (job_.has_lobes ? 1u : 0u)) * source.texel_count();
    progress_start(progress_, units);
    SourceForms forms(asset, plan, fit_settings(), job_.engine, progress_);
    report_.forms.resize(prepared.size());
    std::vector<SourceTextures> made(prepared.size());
    for (std::size_t s = 0; s < prepared.size(); ++s)
      if (prepared[s].kept.empty()) made[s] = textures_of(asset, forms, s, prepared[s]);
    report_.seconds.emplace_back("fit", seconds_.fit);
    report_.seconds.emplace_back("form", seconds_.form);
    report_.seconds.emplace_back("encode", seconds_.encode);
    if (job_.has_lobes) report_.seconds.emplace_back("lobes", seconds_.lobes);
    return made;
  }

  // Returns the form that is chosen for a source by means of pictures, or the requested form if no pictures are drawn.
  ChosenForm form_of(SourceForms& forms, std::size_t number, const FittedSource& fitted, const std::string& baked) {
    ChosenForm form;
    form.normals = NormalForm::of(fitted.normal->level_count(),
                                  {job_.form == MaterialForm::kOneLobe || fitted.averages == nullptr, 1.0});
    form.has_lobes = job_.has_lobes;
    if (job_.form != MaterialForm::kAuto || fitted.averages == nullptr) return form;
    progress_stage(progress_, "form");
    form = forms.choose(number, fitted, baked);
    report_.forms[number] = form;
    seconds_.form += stopwatch_.lap();
    return form;
  }

  // If the material keeps its own textures, returns no textures, and `source` states the reason.
  SourceTextures textures_of(const GltfAsset& asset, SourceForms& forms, std::size_t number, PreparedSource& source) {
    SourceTextures made;
    std::optional<FittedSource> found = fit(asset, source, number);
    if (!found) return made;
    seconds_.fit += stopwatch_.lap();
    std::string baked;
    if (job_.has_lobes) {
      progress_stage(progress_, "lobes");
      baked = bake_source_lobes(device_, asset, source, number, fit_settings(), progress_);
      progress_advance(progress_, source.texel_count());
      seconds_.lobes += stopwatch_.lap();
    }
    FittedSource fitted = std::move(*found);
    const ChosenForm form = form_of(forms, number, fitted, baked);
    if (form.normals.is_plain() && !form.has_lobes) {
      source.kept = "the mips of its original textures are equally accurate";
      source.is_plain = true;
      remove_levels(fitted);
      remove_file(baked);
      progress_advance(progress_, 2 * source.texel_count());  // counts progress for textures that need no encoding
      return made;
    }
    report_.textures.push_back({source.width, source.height, fitted.normal->level_count(), {}});
    if (fitted.averages != nullptr) apply_normal_form(form.normals, fitted);
    progress_stage(progress_, "encode");
    // Lobes include the normal scale, so the normal map must also include the scale.
    if (form.normals.has_fitted_normals() || source.source.normal_scale != 1.0)
      made.normal = encode(fitted, fitted.normal, source, "normal");
    else progress_advance(progress_, source.texel_count());
    if (!form.normals.is_plain()) made.surface = encode(fitted, fitted.surface, source, "metallic_roughness");
    else progress_advance(progress_, source.texel_count());
    if (source.source.is_anisotropic) made.anisotropy = encode(fitted, fitted.anisotropy, source, "anisotropy");
    const LobeSurface surface =
        form.has_lobes ? mean_surface({fitted.normal.get(), fitted.surface.get()}) : LobeSurface{};
    remove_levels(fitted);
    seconds_.encode += stopwatch_.lap();
    if (!form.has_lobes) {
      remove_file(baked);
      return made;
    }
    progress_stage(progress_, "lobes");
    if (form.has_lobe_colours) made.lobe_colours = encode_source_colours(device_, baked, fit_settings(), progress_);
    if (made.lobe_colours) report_.textures.back().storage["lobe_colours"] = *made.lobe_colours;
    made.lobes = encode_source_lobes(device_, baked, {lobe_texels(), surface}, fit_settings(), progress_);
    report_.textures.back().storage["lobes"] = *made.lobes;
    seconds_.lobes += stopwatch_.lap();
    return made;
  }

  // Removes a source's files from the work folder, because they are as large as its textures in memory.
  static void remove_levels(const FittedSource& fitted) {
    for (const auto* levels : {&fitted.normal, &fitted.surface, &fitted.anisotropy, &fitted.averages})
      if (*levels != nullptr) remove_file((*levels)->path());
  }
  static void remove_file(const std::string& path) {
    std::error_code ignored;  // the work folder is removed at the end; an empty `path` has no file
    if (!path.empty()) std::filesystem::remove(path, ignored);
  }

  // Encodes `levels`, and measures how much their storage raises the error of the light. The source's other texture is
  // exact.
  std::optional<EncodedTexture> encode(const FittedSource& fitted, const std::unique_ptr<LevelFile>& levels,
                                       const PreparedSource& source, const char* name) {
    std::optional<EncodedTexture> made;
    if (levels != nullptr) {
      const MaterialLevels exact{fitted.normal.get(), fitted.surface.get()};
      TextureEncoding how{format_, job_.has_fallback, false, uastc(), [&](const LevelFile& decoded) {
                            MaterialLevels stored = exact;
                            if (&levels == &fitted.normal) stored.normal = &decoded;
                            if (&levels == &fitted.surface) stored.surface = &decoded;
                            return storage_error(exact, stored);
                          }};
      how.uastc.has_normals = &levels == &fitted.normal;
      if (&levels == &fitted.normal) how.is_original = source.normal_is_original;
      if (&levels == &fitted.surface) how.is_original = source.surface_is_original;
      made = encode_texture(*levels, how, progress_);
      report_.textures.back().storage[name] = *made;
    }
    progress_advance(progress_, source.texel_count());
    return made;
  }

  const GltfJob& job_;
  GltfTextureFormat format_ = job_.format;  // the written format; without an encoder, kAuto becomes kRgba8
  Device& device_;
  const DeviceCounts counts_;
  Progress* const progress_;
  Stopwatch stopwatch_;
  struct {
    double fit = 0.0, form = 0.0, encode = 0.0, lobes = 0.0;
  } seconds_;  // seconds by stage, for all sources
  std::unique_ptr<WorkFolder> folder_;
  GltfReport report_;
};

}  // namespace

std::string GltfReport::Textures::storage_text() const {
  static const std::map<std::string, const char*> names = {{"normal", "normals"},
                                                           {"metallic_roughness", "roughness"},
                                                           {"anisotropy", "anisotropy"},
                                                           {"lobes", "lobes"},
                                                           {"lobe_colours", "colours of lobes"}};
  std::string text;
  for (const char* name : {"normal", "metallic_roughness", "anisotropy", "lobes", "lobe_colours"}) {
    const auto found = storage.find(name);
    if (found == storage.end()) continue;
    const EncodedTexture& one = found->second;
    const auto in_capitals = [](std::string format) {
      std::transform(format.begin(), format.end(), format.begin(),
                     [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
      return format;
    };
    text += fmt::format("{}{}: {} {:.2f} MB, +{:.1f} points", text.empty() ? "" : "; ", names.at(name),
                        in_capitals(one.format), 1e-6 * static_cast<double>(one.byte_count), 100.0 * one.storage_error);
    if (one.refused_error > 0.0)
      text += fmt::format(" ({} +{:.1f})", in_capitals(one.refused_format), 100.0 * one.refused_error);
  }
  return text;
}

int GltfReport::fitted_count() const {
  return static_cast<int>(
      std::count_if(materials.begin(), materials.end(), [](const Material& one) { return one.kept.empty(); }));
}

std::string GltfReport::to_json(const GltfJob& job) const {
  nlohmann::ordered_json json = {{"input", text_of_path(job.input)},
                                 {"output", text_of_path(job.output)},
                                 {"format", choice_name(kGltfTextureFormats, job.format)},
                                 {"anisotropy", job.is_anisotropic},
                                 {"form", choice_name(kMaterialForms, job.form)},
                                 {"for", choice_name(kEngines, job.engine)},
                                 {"lobes", job.has_lobes},
                                 {"fast", job.is_fast},
                                 {"surface", map_surface_name(job.surface)},
                                 {"bytes_before", bytes_before},
                                 {"bytes_after", bytes_after},
                                 {"materials", nlohmann::ordered_json::array()},
                                 {"textures", nlohmann::ordered_json::array()},
                                 {"warnings", with_advice(warnings)},
                                 {"device", device},
                                 {"launches", launches}};
  for (const Material& material : materials) {
    nlohmann::ordered_json one = {{"name", material.name}, {"fitted", material.kept.empty()}};
    if (!material.kept.empty()) one["kept"] = material.kept;
    if (!material.notes.empty()) one["notes"] = material.notes;
    if (material.textures >= 0) one["textures"] = material.textures;
    if (!material.form.empty()) one["form"] = material.form;
    json["materials"].push_back(std::move(one));
  }
  for (const ChosenForm& form : forms)
    if (!form.views.empty()) json["forms"].push_back(form.to_json());
  for (const Textures& one : textures) json["textures"].push_back(json_of_textures(one));
  for (const auto& [stage, time] : seconds) json["seconds"][stage] = time;
  return json_text(json, 2) + "\n";
}

void apply(const ParameterValues& values, GltfJob& job) {
  if (const auto engine = values.choice("for", kEngines)) {
    job.engine = *engine;
    job.format = preset_of(*engine).gltf_format;
  }
  job.format = values.choice("format", kGltfTextureFormats).value_or(job.format);
  job.form = values.choice("form", kMaterialForms).value_or(job.form);
  job.has_fallback = values.flag("png_fallback");
  job.uastc_effort = values.integer("uastc_effort").value_or(job.uastc_effort);
  job.encoder = values.text("encoder").value_or("");
  job.is_anisotropic = values.flag("anisotropy");
  job.has_lobes = values.flag("lobes");
  job.lobe_texels = values.choice("lobe_texels", kLobeTexels);
  job.is_fast = values.flag("fast");
  job.two_channel = values.flag("two_channel");
  job.z_range = z_range(values);
  job.surface = map_surface(values).value_or(job.surface);
  if (const auto bytes = values.bytes("memory")) job.memory_bytes = static_cast<std::uint64_t>(*bytes);
  job.report = values.text("report").value_or("");
}

GltfReport convert_gltf(const GltfJob& job, Device& device, Progress* progress) {
  try {
    return GltfConversion(job, device, progress).run();
  } catch (const nlohmann::json::exception& error) {
    refuse_file(job.input, std::string("is damaged: its JSON violates glTF: ") + error.what());
  }
}

}  // namespace multum
