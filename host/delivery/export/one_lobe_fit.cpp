// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/one_lobe_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <utility>
#include <vector>

#include "host/bakes/pyramid/average_pass.h"
#include "host/delivery/export/axis_cut.h"
#include "host/delivery/export/facet_samples.h"
#include "host/formats/asset/baked_file.h"
#include "host/formats/opencl/launch_shape.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/size_of.h"
#include "kernels/shared/one_lobe.h"

namespace multum {
namespace {

// The bytes of sample slopes that are fitted in one launch. They fit into the second-level caches of all processor
// cores together, and they give a GPU enough work.
constexpr std::size_t kSlopeBytes = std::size_t{4} << 20;

// Copies of the averages of some rows of a level. They are needed because a fit cannot be launched while the averages
// are handed over.
struct WaitingRows {
  int level, first_row, width, height;
  std::vector<float> planes;  // [plane][row][column], with features last

  const float* plane(int p) const { return planes.data() + size_of(p) * size_of(height) * size_of(width); }
};

WaitingRows copy_of(const BoxRows& rows, int plane_count) {
  WaitingRows copy{rows.level, rows.first_row, rows.width, rows.height, {}};
  copy.planes.resize(size_of(plane_count) * size_of(rows.height) * size_of(rows.width));
  float* to = copy.planes.data();
  for (int p = 0; p < plane_count; ++p)
    for (int y = 0; y < rows.height; ++y, to += rows.width) std::copy_n(rows.row(p, y), rows.width, to);
  return copy;
}

// A device buffer that grows on demand.
class GrowingBuffer {
 public:
  explicit GrowingBuffer(std::string what) : what_(std::move(what)) {}
  DeviceBuffer& of_size(Device& device, std::size_t byte_count) {
    if (buffer_.byte_count() < byte_count) buffer_ = device.make_buffer(byte_count, what_);
    return buffer_;
  }
  const DeviceBuffer& get() const { return buffer_; }

 private:
  std::string what_;
  DeviceBuffer buffer_;
};

// Runs the kernels on rows of a level.
class LobeFitter {
 public:
  LobeFitter(Device& device, const OneLobeInputs& inputs, const OneLobeSettings& settings)
      : device_(device),
        inputs_(inputs),
        settings_(settings),
        lanes_(device.shape().vector_width),
        samples_(device.kernel("one_lobe", "one_lobe_samples", {1, lanes_, false})),
        fit_(device.kernel("one_lobe", "one_lobe_fit", {1, lanes_, false})) {}

  /// Returns fitted planes, [plane][row][column].
  std::vector<float> fit(const WaitingRows& rows) {
    std::vector<float> fitted(MULTUM_ONE_LOBE_FITTED * size_of(rows.height) * size_of(rows.width));
    FitJournal* const journal = inputs_.journal;
    if (journal != nullptr && journal->find(rows.level, rows.first_row, rows.width, rows.height, fitted)) return fitted;
    const int grid = settings_.is_fast ? 0 : sample_grid(rows.level);
    const std::size_t row_bytes =
        size_of(rows.width) * 2 * sizeof(float) * std::max<std::size_t>(1, size_of(grid * grid));
    const int at_once = static_cast<int>(std::clamp<std::size_t>(kSlopeBytes / row_bytes, 1, size_of(rows.height)));
    for (int row = 0; row < rows.height; row += at_once)
      fit_piece(rows, row, std::min(at_once, rows.height - row), grid, fitted);
    if (journal != nullptr) journal->add(rows.level, rows.first_row, rows.width, rows.height, fitted);
    return fitted;
  }

 private:
  // The tables that the samples of a level need for all rows.
  struct LevelTables {
    DeviceBuffer columns, facets;
  };

  const LevelTables& tables(const WaitingRows& rows, int grid) {
    const auto [place, is_new] = tables_.try_emplace(rows.level);
    if (!is_new) return place->second;
    std::vector<int> columns;
    for (int x = 0; x < rows.width; ++x)
      for (int i = 0; i < grid; ++i) columns.push_back(sample_place(x, i, grid, rows.width, inputs_.normals->width()));
    place->second.columns = device_.make_buffer(columns.size() * sizeof(int), "columns of samples");
    device_.write(place->second.columns, columns.data(), columns.size() * sizeof(int));
    const std::vector<glm::vec2> facets = facet_samples(grid);
    place->second.facets = device_.make_buffer(facets.size() * sizeof(glm::vec2), "facets");
    device_.write(place->second.facets, facets.data(), facets.size() * sizeof(glm::vec2));
    return place->second;
  }

  // The finest rows that contain the samples of some rows, without repetitions and in order, and the index of the
  // finest row for each row of samples.
  struct SampledRows {
    std::vector<int> finest;
    std::vector<int> slots;
  };
  SampledRows sampled_rows(const WaitingRows& rows, int first, int count, int grid) const {
    // Level heights are computed from the map's height, as in box_pyramid.h.
    const int height = inputs_.normals->height(), level_height = mip_level_size(height, rows.level);
    SampledRows sampled;
    for (int y = rows.first_row + first; y < rows.first_row + first + count; ++y)
      for (int j = 0; j < grid; ++j) {
        const int row = sample_place(y, j, grid, level_height, height);
        if (sampled.finest.empty() || sampled.finest.back() != row) sampled.finest.push_back(row);
        sampled.slots.push_back(static_cast<int>(sampled.finest.size()) - 1);
      }
    return sampled;
  }

  void upload_rows(const SampledRows& sampled) {
    const std::size_t width = size_of(inputs_.normals->width()), count = sampled.finest.size();
    const std::size_t bytes = count * width * sizeof(float);
    std::vector<BufferRange> ranges;
    for (GrowingBuffer* plane : {&x_, &y_, &z_}) ranges.push_back({&plane->of_size(device_, bytes), 0, bytes});
    const DeviceBuffer& base = base_.of_size(device_, inputs_.has_roughness ? bytes : sizeof(float));
    if (inputs_.has_roughness) ranges.push_back({&base, 0, bytes});
    device_.write_ranges(ranges, [&](const Device::Bytes& at) {
      const auto rows_at = [&](std::size_t plane, std::size_t slot) {
        return reinterpret_cast<float*>(at[plane]) + slot * width;
      };
      for (std::size_t slot = 0; slot < count;) {  // consecutive rows are read at once
        std::size_t end = slot + 1;
        while (end < count && sampled.finest[end] == sampled.finest[end - 1] + 1) ++end;
        const int row = sampled.finest[slot], row_count = static_cast<int>(end - slot);
        inputs_.fitted_normals().read_rows(row, row_count, {rows_at(0, slot), rows_at(1, slot), rows_at(2, slot)});
        if (inputs_.has_roughness) inputs_.material->read_rows(0, row, row_count, rows_at(3, slot));
        slot = end;
      }
    });
    const std::size_t slot_bytes = sampled.slots.size() * sizeof(int);
    device_.write(slots_.of_size(device_, slot_bytes), sampled.slots.data(), slot_bytes);
  }

  // Uploads averages in the kernels' layout.
  void upload_averages(const WaitingRows& rows, int first, const MultumOneLobePiece& piece) {
    const std::size_t stride = size_of(piece.stride), texels = size_of(piece.row_count) * size_of(piece.width);
    const std::size_t bytes = MULTUM_ONE_LOBE_AVERAGES * stride * sizeof(float);
    device_.write_ranges({{&averages_.of_size(device_, bytes), 0, bytes}}, [&](const Device::Bytes& at) {
      auto* const planes = reinterpret_cast<float*>(at[0]);
      std::fill_n(planes, MULTUM_ONE_LOBE_AVERAGES * stride, 0.0f);
      const std::size_t begin = size_of(first) * size_of(rows.width);
      for (int p = 0; p < MULTUM_ONE_LOBE_PLANES; ++p)
        std::copy_n(rows.plane(p) + begin, texels, planes + size_of(p) * stride);
      float* const base = planes + MULTUM_ONE_LOBE_BASE * stride;
      if (inputs_.has_roughness) std::copy_n(rows.plane(MULTUM_ONE_LOBE_PLANES) + begin, texels, base);
      else std::fill_n(base, texels, piece.base_squared);
    });
  }

  MultumOneLobePiece piece_of(const WaitingRows& rows, int row_count, int grid) const {
    const double alpha = settings_.base_roughness * settings_.base_roughness;
    MultumOneLobePiece piece{};
    piece.map_width = inputs_.normals->width();
    piece.width = rows.width;
    piece.row_count = row_count;
    piece.grid = grid;
    piece.stride = (row_count * rows.width + MULTUM_ONE_LOBE_BLOCK - 1) / MULTUM_ONE_LOBE_BLOCK * MULTUM_ONE_LOBE_BLOCK;
    piece.iteration_count = settings_.iteration_count;
    piece.is_anisotropic = settings_.is_anisotropic ? 1 : 0;
    piece.has_base_map = inputs_.has_roughness ? 1 : 0;
    piece.base_squared = static_cast<float>(alpha * alpha);
    piece.alpha_min = static_cast<float>(inputs_.has_roughness ? kAlphaMin : std::max(kAlphaMin, alpha));
    return piece;
  }

  void fit_piece(const WaitingRows& rows, int first, int row_count, int grid, std::vector<float>& fitted) {
    const MultumOneLobePiece piece = piece_of(rows, row_count, grid);
    const std::size_t stride = size_of(piece.stride), texels = size_of(row_count) * size_of(rows.width);
    const std::size_t samples = size_of(grid) * size_of(grid);
    upload_averages(rows, first, piece);
    DeviceBuffer& slopes = slopes_.of_size(device_, std::max<std::size_t>(1, samples) * 2 * stride * sizeof(float));
    if (grid > 0) {
      const LevelTables& tables_of_level = tables(rows, grid);
      upload_rows(sampled_rows(rows, first, row_count, grid));
      samples_.launch({stride / size_of(lanes_) * size_of(grid)}, x_.get(), y_.get(), z_.get(), base_.get(),
                      slots_.get(), tables_of_level.columns, tables_of_level.facets, averages_.get(), slopes, piece);
    }
    const std::size_t bytes = MULTUM_ONE_LOBE_FITTED * stride * sizeof(float);
    DeviceBuffer& out = fitted_.of_size(device_, bytes);
    fit_.launch({stride / size_of(lanes_)}, averages_.get(), slopes, out, piece);
    device_.read_ranges({{&out, 0, bytes}}, [&](const Device::Bytes& at) {
      for (std::size_t p = 0; p < MULTUM_ONE_LOBE_FITTED; ++p)
        std::copy_n(reinterpret_cast<const float*>(at[0]) + p * stride, texels,
                    fitted.data() + (p * size_of(rows.height) + size_of(first)) * size_of(rows.width));
    });
  }

  Device& device_;
  const OneLobeInputs& inputs_;
  const OneLobeSettings& settings_;
  const int lanes_;
  Kernel samples_, fit_;
  std::map<int, LevelTables> tables_;
  GrowingBuffer x_{"sampled normals"}, y_{"sampled normals"}, z_{"sampled normals"}, base_{"sampled roughness"};
  GrowingBuffer slots_{"rows of samples"}, averages_{"averages of a fit"}, slopes_{"slopes"}, fitted_{"fitted lobes"};
};

// The planes that are averaged and the fits that start from the averages.
class OneLobePlanes : public AveragedPlanes {
 public:
  OneLobePlanes(Device& device, const OneLobeInputs& inputs, const OneLobeSettings& settings, double axis_cut,
                MaterialSink& sink)
      : inputs_(inputs),
        settings_(settings),
        axis_cut_(axis_cut),
        sink_(sink),
        finest_(device.kernel("one_lobe", "one_lobe_finest", {1, 1, false})),
        fitter_(device, inputs, settings) {}

  std::string name() const override { return "one lobe"; }
  int plane_count() const override { return MULTUM_ONE_LOBE_PLANES; }
  void make_finest(const MapPlanes& normals, const DeviceBuffer& nodes, const MultumBoxBand& band) override {
    finest_.launch({size_of(band.row_count) * size_of(band.map_width), kBoxLocalSize}, normals[0], normals[1],
                   normals[2], nodes, band);
  }
  void add_level(const BoxRows& rows) override {
    waiting_.push_back(copy_of(rows, MULTUM_ONE_LOBE_PLANES + (inputs_.material != nullptr ? 3 : 0)));
  }
  void end_band() override {
    for (const WaitingRows& rows : waiting_)
      sink_.add_level(rows.level, rows.first_row, rows.level == 0 ? finest_rows(rows) : fitted_rows(rows));
    waiting_.clear();
  }

 private:
  MaterialRows empty_rows(const WaitingRows& rows) const {
    const std::size_t texels = size_of(rows.width) * size_of(rows.height);
    MaterialRows made{rows.width, rows.height, {}, {}, {}, {}, {}};
    made.normals.resize(texels);
    made.roughness.resize(texels);
    if (settings_.is_anisotropic) made.anisotropy.resize(texels);
    const auto copied = [&](int plane) { return std::vector<float>(rows.plane(plane), rows.plane(plane) + texels); };
    if (inputs_.has_occlusion) made.occlusion = copied(MULTUM_ONE_LOBE_PLANES + 1);
    if (inputs_.has_metalness) made.metalness = copied(MULTUM_ONE_LOBE_PLANES + 2);
    return made;
  }

  // Returns the map's own normals with the base roughness.
  MaterialRows finest_rows(const WaitingRows& rows) const {
    MaterialRows made = empty_rows(rows);
    // If there is no axis, the direction is the middle of the half plane of directions. Filtering towards level 1 then
    // does not reverse any axis.
    const glm::vec3 no_axis(-std::sin(axis_cut_), std::cos(axis_cut_), 0.0);
    const auto base =
        static_cast<float>(std::sqrt(std::max(kAlphaMin, settings_.base_roughness * settings_.base_roughness)));
    std::array<const float*, 3> normals = {rows.plane(0), rows.plane(1), rows.plane(2)};
    std::array<std::vector<float>, 3> texels;
    if (inputs_.surface != nullptr) {
      for (std::vector<float>& plane : texels) plane.resize(size_of(rows.width) * size_of(rows.height));
      inputs_.normals->read_rows(rows.first_row, rows.height, {texels[0].data(), texels[1].data(), texels[2].data()});
      normals = {texels[0].data(), texels[1].data(), texels[2].data()};
    }
    for_each_row_band(rows.height, kRowsPerBand, inputs_.threads, [&](int, int begin, int end) {
      for (std::size_t i = size_of(begin) * size_of(rows.width); i < size_of(end) * size_of(rows.width); ++i) {
        made.normals[i] = {normals[0][i], normals[1][i], normals[2][i]};
        made.roughness[i] =
            inputs_.has_roughness
                ? std::sqrt(std::max(static_cast<float>(kAlphaMin), std::sqrt(rows.plane(MULTUM_ONE_LOBE_PLANES)[i])))
                : base;
        if (settings_.is_anisotropic) made.anisotropy[i] = no_axis;
      }
    });
    return made;
  }

  MaterialRows fitted_rows(const WaitingRows& rows) {
    MaterialRows made = empty_rows(rows);
    const std::vector<float> fitted = fitter_.fit(rows);
    const std::size_t texels = size_of(rows.width) * size_of(rows.height);
    const auto value = [&](int plane, std::size_t i) { return fitted[size_of(plane) * texels + i]; };
    if (inputs_.wants_means) made.means.resize(texels);
    for_each_row_band(rows.height, kRowsPerBand, inputs_.threads, [&](int, int begin, int end) {
      for (std::size_t i = size_of(begin) * size_of(rows.width); i < size_of(end) * size_of(rows.width); ++i) {
        made.normals[i] = {value(0, i), value(1, i), value(2, i)};
        const float wide = value(MULTUM_ONE_LOBE_ALPHA_WIDE, i), narrow = value(MULTUM_ONE_LOBE_ALPHA_NARROW, i);
        made.roughness[i] = std::sqrt(narrow);
        if (inputs_.wants_means) made.means[i] = {rows.plane(0)[i], rows.plane(1)[i], rows.plane(2)[i]};
        if (!settings_.is_anisotropic) continue;
        // KHR_materials_anisotropy: alpha along the axis is mix(alpha, 1, strength^2).
        const float strength = narrow < 1.0f ? std::sqrt((wide - narrow) / (1.0f - narrow)) : 0.0f;
        const glm::vec2 axis =
            signed_axis({value(MULTUM_ONE_LOBE_AXIS, i), value(MULTUM_ONE_LOBE_AXIS + 1, i)}, axis_cut_);
        made.anisotropy[i] = {axis.x, axis.y, strength};
      }
    });
    return made;
  }

  const OneLobeInputs& inputs_;
  const OneLobeSettings& settings_;
  const double axis_cut_;
  MaterialSink& sink_;
  Kernel finest_;
  LobeFitter fitter_;
  std::vector<WaitingRows> waiting_;
};

}  // namespace

void validate(const OneLobeSettings& settings) {
  if (!(settings.base_roughness >= 0.0 && settings.base_roughness <= 1.0))
    throw Error(ErrorCode::kUsage,
                fmt::format("--base-roughness is {:g}, expected a number from 0 to 1", settings.base_roughness));
  MULTUM_CHECK(settings.iteration_count >= 1 && settings.iteration_count <= 100);
}

OneLobeReport fit_one_lobe(Device& device, const OneLobeInputs& inputs, const OneLobeSettings& settings,
                           MaterialSink& sink, Progress* progress) {
  validate(settings);
  OneLobeReport report;
  if (settings.is_anisotropic) report.axis_cut = find_axis_cut(inputs.fitted_normals());
  AverageInputs averaged;
  averaged.normals = &inputs.fitted_normals();
  averaged.memory_bytes = inputs.memory_bytes;
  averaged.threads = inputs.threads;
  if (inputs.material != nullptr) averaged.features.rgb_planes = {inputs.material};
  OneLobePlanes planes(device, inputs, settings, report.axis_cut, sink);
  AverageReport average;
  average_map(device, averaged, planes, average, progress);
  report.plan = average.plan;
  return report;
}

}  // namespace multum
