// SPDX-License-Identifier: Apache-2.0
// The subcommands of multum-view that draw inferred textures and packed fields.
#include <filesystem>

#include "host/fields/inferred/inferred_texture.h"
#include "host/formats/image/small_picture.h"
#include "host/foundation/base/error.h"
#include "tools/multum_view/view_commands.h"
#include "tools/multum_view/write_image.h"

namespace multum {

std::vector<ViewCommand> field_commands() {
  return {
      {"sample", "Draw samples of an animation with textures of `multum infer` or `multum pack`",
       "  multum-view sample out/ --at 3,5 -o frame.png\n"
       "  multum-view sample field.mpt --at 3,5 -o frame.png\n"
       "  multum-view sample out/ --at 0,0 -o a.exr --at 0,1 -o b.exr",
       [](CLI::App& app, CommandOptions& o) { add_sample_options(app, o.sample); },
       [](const CommandOptions& o) { return draw_samples(o.sample); }},
      {"play", "Draw frames along a path through the parameters of a packed animation, decoding as it goes",
       "  multum-view play field.mpt --path 'view=0..7,light=3.5+3.5*sin(t)' --frames 90 -o frames/\n\n"
       "A path sets each parameter to a sample's index, 0 for the first sample. Parameters that it leaves out stay at "
       "0;\n"
       "values beyond the samples are clamped. A value may use numbers, + - * / ( ), sin, cos, pi and t, the seconds\n"
       "since the first frame (--rate); a..b runs from a in the first frame to b in the last. Between samples the\n"
       "camera and objects move smoothly; textures come from the nearest sample, or are mixed with --linear.\n"
       "FILE.json, a path saved by a player's page, is replayed as recorded; if --frames asks for more frames, the\n"
       "path starts again.",
       [](CLI::App& app, CommandOptions& o) { add_play_options(app, o.play); },
       [](const CommandOptions& o) { return play_field(o.play); }},
      {"probe", "Measure filter matrices for texture inference: the weight that GL's sampler gives each texel",
       "  multum-view probe request.json          `multum infer` starts this command; "
       "docs/reference/inferred_textures.md describes the request",
       [](CLI::App& app, CommandOptions& o) { add_probe_options(app, o.probe); },
       [](const CommandOptions& o) { return measure_filter_matrices(o.probe); }}};
}

void draw_field_thumbnail(const ThumbnailOptions& options) {
  namespace fs = std::filesystem;
  const InferredManifest manifest = read_inferred_manifest((fs::path(options.result) / kInferredManifestName).string());
  if (manifest.samples.empty()) throw Error(ErrorCode::kInput, options.result + ": has no samples, expected one");
  const std::string frame = (fs::path(options.folder) / "frame.png").string();
  draw_samples({options.result, {manifest.samples.front().name}, {frame}, options.context});
  write_png8((fs::path(options.folder) / "render.png").string(), read_small_picture(frame, kThumbnailSide));
  fs::remove(frame);
}

}  // namespace multum
