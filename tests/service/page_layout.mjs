// SPDX-License-Identifier: Apache-2.0
// Checks the layout of a page. Finds parts beyond the window, parts that are cut off, and parts that cover others.

/** Window sizes in which every page is checked: the narrowest phones, and 1280 x 800 at 200 %. */
export const NARROW = [{ viewport: { width: 320, height: 640 }, deviceScaleFactor: 1 },
  { viewport: { width: 640, height: 400 }, deviceScaleFactor: 2 }];

/**
 * Returns the layout problems within `root` as texts; [] if there are none. Skips parts of elements that scroll
 * sideways, such as wide tables, and inputs, whose texts browsers lay out.
 */
export const misplaced = (page, root = "body") => page.evaluate((selector) => {
  const top = document.querySelector(selector);
  const width = document.documentElement.clientWidth, found = new Set();
  const isShown = (element) => {
    if (!element.checkVisibility({ visibilityProperty: true })) return false; // includes closed details
    for (let above = element; above !== null; above = above.parentElement) // meant only for screen readers
      if (above.getBoundingClientRect().width <= 1 && getComputedStyle(above).overflow === "hidden") return false;
    return true;
  };
  const nameOf = (element) => `${element.tagName.toLowerCase()}${element.id ? `#${element.id}` : ""} ` +
    `'${element.textContent.trim().slice(0, 30)}'`;
  const scrolls = (element) => {
    for (let above = element.parentElement; above !== null && above !== document.body; above = above.parentElement)
      if (/auto|scroll/.test(getComputedStyle(above).overflowX)) return true;
    return false;
  };
  if (document.documentElement.scrollWidth > width)
    found.add(`the page is ${document.documentElement.scrollWidth} px wide in ${width}`);
  for (const element of top.querySelectorAll("*:not(input)")) {
    if (!isShown(element)) continue;
    const { left, right } = element.getBoundingClientRect();
    if ((left < -0.5 || right > width + 0.5) && !scrolls(element))
      found.add(`${nameOf(element)} is at ${Math.round(left)} to ${Math.round(right)} px of ${width}`);
    if (element.scrollWidth > element.clientWidth + 1 && element.clientWidth > 0 &&
        /hidden|clip/.test(getComputedStyle(element).overflowX))
      found.add(`${nameOf(element)} is cut: ${element.scrollWidth} px in ${element.clientWidth}`);
  }
  const texts = document.createTreeWalker(top, NodeFilter.SHOW_TEXT), boxes = [];
  while (texts.nextNode()) {
    const { currentNode: text } = texts;
    if (!text.textContent.trim() || /^(SCRIPT|STYLE|OPTION|NOSCRIPT)$/.test(text.parentElement.tagName) ||
        !isShown(text.parentElement)) continue;
    const range = document.createRange();
    range.selectNodeContents(text);
    for (const box of range.getClientRects()) if (box.width > 1 && box.height > 1) boxes.push([box, text]);
  }
  boxes.sort((a, b) => a[0].top - b[0].top);
  boxes.forEach(([a, one], i) => {
    for (let j = i + 1; j < boxes.length && boxes[j][0].top < a.bottom - 3; ++j) {
      const [b, other] = boxes[j];
      if (one !== other && Math.min(a.right, b.right) - Math.max(a.left, b.left) > 2 &&
          Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 3)
        found.add(`'${one.textContent.trim().slice(0, 30)}' and '${other.textContent.trim().slice(0, 30)}' overlap`);
    }
  });
  return [...found];
}, root);
