// SPDX-License-Identifier: Apache-2.0
// Lists the subcommands of multum-view that draw inferred textures and packed fields.
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
       "  multum-view sample out/ --at 0,0 -o a.exr --at 0,1 -o b.exr\n\n"
       "Chunks of a packed field are decoded when a sample needs them. If a chunk is damaged, its name is printed,\n"
       "the rest is drawn, and the exit code is 5.",
       [](CLI::App& app, CommandOptions& o) { add_sample_options(app, o.sample); },
       [](const CommandOptions& o) { return draw_samples(o.sample); }},
      {"play", "Draw frames along a path through the parameters of a packed field, and decode the field while drawing",
       "  multum-view play field.mpt --path 'view=0..7,light=3.5+3.5*sin(t)' --frames 90 -o frames/\n\n"
       "A path sets parameters to sample indices, such as 0 or 2.5. Other parameters stay at 0. An index beyond\n"
       "the last sample counts as the last sample. A value is a formula with numbers, + - * / ( ), sin, cos, pi and\n"
       "t, the seconds since the first frame (--rate). a..b changes from a in the first frame to b in the last frame.\n"
       "Between samples, camera and objects move smoothly. Textures come from the nearest sample. --linear mixes the\n"
       "gamma-coded textures of the samples around a point, but omits samples of another texture size.\n\n"
       "Without --no-wait, a frame waits for all of its images, so threads and memory do not change pictures.\n"
       "A chunk may use a quarter of --memory. Chunks that need more are omitted, and their names are printed.\n"
       "--upload does not count the coarsest image of each layer. For --lifetime-factor, an image of `S` samples has\n"
       "level `log4(S)`.\n\n"
       "The debug picture shows one band per layer, from the top. Green means available images, yellow the share of\n"
       "late images, and red images of an earlier frame. Below are decoded images (blue) and decoded chunks\n"
       "(violet), with one pixel each, and the memory (white at its peak).\n\n"
       "If --frames exceeds the path of FILE.json, the path starts again.",
       [](CLI::App& app, CommandOptions& o) { add_play_options(app, o.play); },
       [](const CommandOptions& o) { return play_field(o.play); }},
      {"probe", "Measure the weights of the GL texture filter for texture inference",
       "  multum-view probe request.json\n\n"
       "`multum infer` runs this command. docs/reference/inferred_textures.md describes the request.",
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
