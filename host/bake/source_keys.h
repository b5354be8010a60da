// SPDX-License-Identifier: Apache-2.0
// What TOML files say of a map to be baked - how it is read, its borders, the maps that go along - under the names of
// the options of `multum bake`: one reader for manifests and scenes.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <string>
#include <vector>

#include "host/bake/map_options.h"
#include "host/bake/strict_toml.h"
#include "host/base/choices.h"

namespace multum {

/// The keys that read_source_keys() takes.
const std::vector<std::string>& source_keys();
void read_source_keys(const StrictTable& table, MapOptions& map);

template <typename Value>
void read_choice(const StrictTable& table, const std::string& key, const Choices<Value>& choices,
                 std::optional<Value>& value) {
  if (!table.has(key)) return;
  const std::string name = table.text(key, "");
  value = find_choice(choices, name);
  if (!value) table.refuse(key, fmt::format("is \"{}\", expected {}", name, fmt::join(choice_names(choices), ", ")));
}

void read_number(const StrictTable& table, const std::string& key, const NumberRange& range,
                 std::optional<float>& value);

}  // namespace multum
