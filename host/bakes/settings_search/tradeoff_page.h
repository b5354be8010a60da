// SPDX-License-Identifier: Apache-2.0
// Writes the results of a sweep (host/bakes/settings_search/tradeoff_sweep.h) for people and programs. The page is one
// file of HTML with its pictures and JSON in it, of host/bakes/settings_search/templates: its script draws plots as
// SVG, and tables that can be sorted.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "host/bakes/settings_search/tradeoff_sweep.h"

namespace multum {

/// The page as HTML.
std::string tradeoff_page(const TradeoffJob& job, const TradeoffResult& result);
/// All figures as JSON, without the pictures.
std::string tradeoff_json(const TradeoffJob& job, const TradeoffResult& result);
/// A table of Markdown, a row each, without pictures.
std::string tradeoff_markdown(const TradeoffResult& result);
/// The rows on a front, a line each, and what was chosen: for a terminal.
std::string tradeoff_text(const TradeoffJob& job, const TradeoffResult& result);

/// The files of host/bakes/settings_search/templates, by name. Made by tools/embed_files.py.
const std::map<std::string, std::string_view>& tradeoff_templates();

}  // namespace multum
