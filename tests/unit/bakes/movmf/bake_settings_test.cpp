// SPDX-License-Identifier: Apache-2.0
// Tests that a setting outside its range is refused with a message that gives its name, value and range. Also tests
// that the text of the settings contains every setting that changes pixels.
#include "host/bakes/movmf/bake_settings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using Change = std::function<void(MovmfSettings&)>;

void expect_refused(const std::vector<std::string>& parts, const Change& change) {
  MovmfSettings settings;
  change(settings);
  testing::expect_error(ErrorCode::kUsage, parts, [&] { validate(settings); });
}

TEST(BakeSettingsTest, DefaultsAndLimitsAreLegal) {
  EXPECT_NO_THROW(validate(MovmfSettings()));
  MovmfSettings limits;
  limits.lobe_count = 8;
  limits.iteration_count = limits.iteration_count_top = 1000;
  limits.alignment = 0.0f;
  limits.kappa_cap = 1.0f;
  limits.kappa_cap_slope = 0.0f;
  limits.start_kappa_factor = 1.0f;
  limits.start_amplitude_min = 0.125f;
  EXPECT_NO_THROW(validate(limits));
}

TEST(BakeSettingsTest, RefusalsNameTheSettingItsValueAndItsRange) {
  expect_refused({"--lobes", "9", "1 to 8"}, [](auto& s) { s.lobe_count = 9; });
  expect_refused({"--lobes", "0", "1 to 8"}, [](auto& s) { s.lobe_count = 0; });
  expect_refused({"--iterations", "0", "1 to 1000"}, [](auto& s) { s.iteration_count = 0; });
  expect_refused({"convergence_tolerance", "0.2", "0 to 0.1"}, [](auto& s) { s.convergence_tolerance = 0.2f; });
  expect_refused({"iterations_top", "1001", "1 to 1000"}, [](auto& s) { s.iteration_count_top = 1001; });
  expect_refused({"--align", "-1", "0 to 10"}, [](auto& s) { s.alignment = -1.0f; });
  expect_refused({"--align", "nan"}, [](auto& s) { s.alignment = std::nanf(""); });
  expect_refused({"--kappa-cap", "0.5", "1 to 100000"}, [](auto& s) { s.kappa_cap = 0.5f; });
  expect_refused({"--kappa-cap", "inf"}, [](auto& s) { s.kappa_cap = HUGE_VALF; });
  expect_refused({"slope", "1001"}, [](auto& s) { s.kappa_cap_slope = 1001.0f; });
  expect_refused({"start_kappa_factor", "0.01 to 1"}, [](auto& s) { s.start_kappa_factor = 0.0f; });
  expect_refused({"--first-level", "-1", "0 to 15"}, [](auto& s) { s.first_level = -1; });
  expect_refused({"--first-level", "16"}, [](auto& s) { s.first_level = 16; });
  expect_refused({"start_amplitude_min", "0 to 0.125"}, [](auto& s) { s.start_amplitude_min = 0.2f; });
}

TEST(BakeSettingsTest, TheTextChangesWithEachSettingThatChangesPixels) {
  const std::string usual = settings_json(MovmfSettings());
  EXPECT_EQ(usual, settings_json(MovmfSettings()));
  EXPECT_TRUE(nlohmann::json::accept(usual));
  const std::vector<Change> changes = {[](auto& s) { s.lobe_count = 5; },
                                       [](auto& s) { s.iteration_count = 5; },
                                       [](auto& s) { s.iteration_count_coarse = 5; },
                                       [](auto& s) { s.iteration_count_top = 5; },
                                       [](auto& s) { s.pass_count = 3; },
                                       [](auto& s) { s.refit_iterations = 7; },
                                       [](auto& s) { s.convergence_tolerance = 0.02f; },
                                       [](auto& s) { s.coarse_normals = CoarseNormals::kAll; },
                                       [](auto& s) { s.order = FitOrder::kScanline; },
                                       [](auto& s) { s.alignment = 0.5f; },
                                       [](auto& s) { s.aligned_start = false; },
                                       [](auto& s) { s.search_start = false; },
                                       [](auto& s) { s.farthest_start = true; },
                                       [](auto& s) { s.periodic_x = true; },
                                       [](auto& s) { s.periodic_y = true; },
                                       [](auto& s) { s.first_level = 1; },
                                       [](auto& s) { s.kappa_cap = 501.0f; },
                                       [](auto& s) { s.kappa_cap_slope = 11.0f; },
                                       [](auto& s) { s.start_kappa_factor = 1.0f; },
                                       [](auto& s) { s.start_amplitude_min = 0.1f; }};
  std::set<std::string> texts = {usual};
  for (const Change& change : changes) {
    MovmfSettings settings;
    change(settings);
    EXPECT_TRUE(texts.insert(settings_json(settings)).second);
  }
}

}  // namespace
}  // namespace multum
