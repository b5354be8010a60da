// SPDX-License-Identifier: Apache-2.0
// Functions that the scripts of all pages share. Untrusted text becomes text nodes and attributes, never markup.

const byId = (id) => document.getElementById(id);
const data = JSON.parse(byId("data").textContent);
document.title = byId("title").textContent = data.title;

function made(node, attributes, children) {
  for (const [key, value] of Object.entries(attributes))
    if (value !== null && value !== undefined && value !== false)
      node.setAttribute(key, value === true ? "" : value);
  for (const child of children.flat()) if (child !== null && child !== undefined && child !== "") node.append(child);
  return node;
}
/** node("a", {href: "x"}, "text", otherNode, [nodes], null): omits attributes and children without a value. */
const node = (name, attributes = {}, ...children) => made(document.createElement(name), attributes, children);
const svgNode = (name, attributes = {}, ...children) =>
  made(document.createElementNS("http://www.w3.org/2000/svg", name), attributes, children);

/** Returns the value at a path such as "budget.gpu_bytes" in `data`; undefined if it is missing. */
const valueAt = (path) => path.split(".").reduce((value, key) => value?.[key], data);

/**
 * Fills a template: <span data-value="view.width"> gets the value, formatted by the entry of `formats` that its
 * data-format names, or "unknown" if there is no value. Removes elements with a data-if whose value is missing, false,
 * null, 0 or "".
 */
function fillTemplate(formats = {}) {
  for (const element of document.querySelectorAll("[data-if]")) if (!valueAt(element.dataset.if)) element.remove();
  for (const element of document.querySelectorAll("[data-value]")) {
    const value = valueAt(element.dataset.value);
    element.textContent = value === undefined || value === null ? "unknown"
      : element.dataset.format ? formats[element.dataset.format](value) : String(value);
  }
}

/** Puts `separator` between the `values`: [a, ", ", b]. */
const joined = (values, separator) => values.flatMap((value, i) => (i > 0 ? [separator, value] : [value]));

/** Formats like printf's %.4g: 4 significant digits, no zeros at the end, and an exponent if that is shorter. */
function general(value, digits = 6) {
  if (value === 0) return "0";
  const [mantissa, power] = value.toExponential(digits - 1).split("e");
  const exponent = Number(power);
  const trimmed = (text) => (text.includes(".") ? text.replace(/\.?0+$/, "") : text);
  if (exponent >= -4 && exponent < digits) return trimmed(value.toFixed(digits - 1 - exponent));
  return `${trimmed(mantissa)}e${exponent < 0 ? "-" : "+"}${String(Math.abs(exponent)).padStart(2, "0")}`;
}

/**
 * Makes a table. Columns: {head, isText}. Cells: text, a number, a node or a list of these, or {best: cell} (bold).
 */
function table(columns, rows, attributes = {}) {
  const cell = (content, { isText }) => {
    const isBest = content !== null && typeof content === "object" && "best" in content;
    return node("td", { class: isText ? "text" : isBest ? "best" : null }, isBest ? content.best : content);
  };
  const heads = columns.map(({ head, isText }) => node("th", { scope: "col", class: isText ? "text" : null }, head));
  return node("div", { class: "wide" }, node("table", attributes, node("tbody", {}, node("tr", {}, heads),
    rows.map((row) => node("tr", {}, row.map((content, i) => cell(content, columns[i])))))));
}
