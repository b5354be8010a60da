// SPDX-License-Identifier: Apache-2.0
// Writes the results of a sweep (host/target/tradeoff_sweep.h) for people and programs. The page is one file of HTML
// with its pictures in it; its plots are SVG, and read in light, in dark and on paper; its one script sorts tables.
#pragma once

#include <string>

#include "host/target/tradeoff_sweep.h"

namespace multum {

/// The page as HTML.
std::string tradeoff_page(const TradeoffJob& job, const TradeoffResult& result);
/// All figures as JSON, without the pictures.
std::string tradeoff_json(const TradeoffJob& job, const TradeoffResult& result);
/// A table of Markdown, a row each, without pictures.
std::string tradeoff_markdown(const TradeoffResult& result);
/// The rows on a front, a line each, and what was chosen: for a terminal.
std::string tradeoff_text(const TradeoffJob& job, const TradeoffResult& result);

}  // namespace multum
