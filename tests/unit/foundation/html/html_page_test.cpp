// SPDX-License-Identifier: Apache-2.0
// Tests pages that are made from templates and data. Text from unknown sources stays data and is shown as text.
#include "host/foundation/html/html_page.h"

#include <gtest/gtest.h>

#include "tests/unit/foundation/base/text_parts.h"
#include "tests/unit/foundation/html/rendered_page.h"

namespace multum {
namespace {

using testing::contains;
using testing::part_count;

const std::string kHostile =
    "</script><script>document.title = 'mine'</script><!--<img src=x onerror=\"document.title = 'mine'\">"
    "{{style}} & ' \xe2\x80\xa8 \xc3\xa9";

constexpr PageTemplate kTemplate = {
    "<p id=\"name\"></p><p data-if=\"nothing\">left out</p><p data-value=\"deep.number\"></p>", "p { color: red; }",
    "fillTemplate(); byId(\"name\").append(data.name, node(\"i\", {}, data.name)); "
    "document.body.append(...[0.1, 1234567, 1e-7, 100, 12.34].map((value) => `${general(value)};`));"};

std::string hostile_page() {
  return html_page(kTemplate, {{"title", kHostile}, {"name", kHostile}, {"nothing", 0}, {"deep", {{"number", 5}}}});
}

TEST(HtmlPage, TextOfStrangersStaysData) {
  const std::string page = hostile_page();
  EXPECT_EQ(part_count(page, "</script"), 2u) << "one in the data and one in the script";
  EXPECT_EQ(part_count(page, "<script"), 2u);
  EXPECT_FALSE(contains(page, "<img"));
  EXPECT_FALSE(contains(page, "\xe2\x80\xa8")) << "U+2028 ends lines of scripts";
  EXPECT_EQ(part_count(page, "{{style}}"), 2u) << "only in the data, twice";
  EXPECT_EQ(testing::page_data(page)["name"], kHostile);
  EXPECT_TRUE(contains(page, std::string(kTemplate.style)));
}

TEST(HtmlPage, BytesThatAreNoTextAreEscaped) {
  EXPECT_EQ(testing::page_data(html_page(kTemplate, {{"title", "a\xff.png"}}))["title"], "a\xee\xbf\xbf.png");
}

TEST(HtmlPage, ABrowserShowsTextOfStrangersAsText) {
  const std::optional<std::string> shown = testing::rendered_page(hostile_page());
  if (!shown) GTEST_SKIP() << "no Chromium";
  EXPECT_EQ(part_count(*shown, "<img"), 0u);
  EXPECT_EQ(part_count(*shown, "<title>&lt;/script&gt;"), 1u) << *shown;
  EXPECT_EQ(part_count(*shown, "&lt;img src=x onerror"), 4u) << "title, heading, and the name twice";
  EXPECT_FALSE(contains(*shown, "left out"));
  EXPECT_TRUE(contains(*shown, "<p data-value=\"deep.number\">5</p>"));
  EXPECT_TRUE(contains(*shown, "0.1;1.23457e+06;1e-07;100;12.34;")) << "as printf's %g";
}

}  // namespace
}  // namespace multum
