// SPDX-License-Identifier: Apache-2.0
// Makes nodes and texts. Untrusted text, such as labels, messages and file names, becomes text nodes and attributes
// with known names, but never markup.

export const byId = (id) => document.getElementById(id);

/** Makes a node: node("a", {href, class, onclick}, "text", otherNode, null). Omits children without a value. */
export function node(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else made.setAttribute(key, value === true ? "" : value);
  }
  for (const child of children) if (child !== null && child !== undefined) made.append(child);
  return made;
}

/** Changes the page only if the text is new, because most of a list stays unchanged. */
export function setText(target, value) {
  const text = value ?? "";
  if (target.textContent !== text) target.textContent = text;
}

export const isFinal = (state) => state === "succeeded" || state === "dead" || state === "cancelled";
export const canCancel = (job) => ["waiting", "queued", "running"].includes(job.state);
export const canRetry = (job) => job.state === "dead" || job.state === "cancelled";
export const STATES = ["waiting", "queued", "running", "publishing", "succeeded", "dead", "cancelled"];

const baseName = (path) => path.slice(path.lastIndexOf("/") + 1);

/** Returns the name of a job: its label, the name of its result, or its parameters. */
export function jobName(job) {
  if (job.label) return job.label;
  if (job.output) return baseName(job.output);
  return Object.entries(job.parameters).map(([name, value]) => `${name} ${value}`).join(", ");
}
/** Returns the first line of a message of several lines. */
export function firstLine(text) {
  const end = text.indexOf("\n");
  return end < 0 ? text : `${text.slice(0, end)} ...`;
}
export const outputName = (job) => baseName(job.output);

export function durationText(milliseconds) {
  const seconds = Math.max(0, milliseconds) / 1000;
  if (seconds < 0.9995) return `${Math.round(seconds * 1000)} ms`;
  if (seconds < 9.95) return `${seconds.toFixed(1)} s`;
  if (seconds < 99.5) return `${Math.round(seconds)} s`;
  const minutes = Math.round(seconds / 60);
  if (minutes < 100) return `${minutes} min`;
  if (minutes < 60 * 48) return `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, "0")} min`;
  return `${Math.round(minutes / 1440)} days`;
}

export function relativeText(time, now = Date.now()) {
  const seconds = (now - Date.parse(time)) / 1000;
  const size = Math.abs(seconds);
  if (size < 2) return "now";
  const amount = size < 90 ? `${Math.round(size)} s` : size < 5400 ? `${Math.round(size / 60)} min`
    : size < 172800 ? `${Math.round(size / 3600)} h` : `${Math.round(size / 86400)} days`;
  return seconds > 0 ? `${amount} ago` : `in ${amount}`;
}

const absolute = new Intl.DateTimeFormat(undefined, { dateStyle: "medium", timeStyle: "medium" });

/** Makes a relative time that also shows the absolute time. refreshTimes() updates it. */
export function timeNode(time) {
  return node("time", { datetime: time, title: absolute.format(new Date(time)) }, relativeText(time));
}
/** Returns the time from `started` to `ended`, or until now. */
export function tookText(job) {
  if (!job.started) return "";
  return durationText((job.finished ? Date.parse(job.finished) : Date.now()) - Date.parse(job.started));
}
export function refreshTimes(root) {
  for (const time of root.querySelectorAll("time")) setText(time, relativeText(time.getAttribute("datetime")));
}

export function bytesText(bytes) {
  const units = ["B", "KiB", "MiB", "GiB", "TiB"];
  const power = bytes > 0 ? Math.min(4, Math.floor(Math.log2(bytes) / 10)) : 0;
  const value = bytes / 1024 ** power;
  return `${value >= 100 || power === 0 ? Math.round(value) : value.toFixed(1)} ${units[power]}`;
}

/** Shows the progress of one job, and the remaining time at the speed so far. */
export class ProgressBar {
  constructor() {
    this.bar = node("progress", { max: 1, "aria-label": "progress" });
    this.words = node("span");
    this.root = node("div", { class: "progress", hidden: true }, this.bar, this.words);
    this.first = null; // time and progress when this attempt and stage were first observed
  }

  show(job) {
    const progress = job.state === "running" || job.state === "publishing" ? job.progress : null;
    this.root.hidden = !progress || !progress.total;
    if (this.root.hidden) return;
    const now = Date.now();
    const { stage, done, total } = progress;
    const share = Math.min(1, done / total);
    if (!this.first || this.first.attempt !== job.attempt || done < this.first.done || total !== this.first.total)
      this.first = { attempt: job.attempt, done, total, at: now };
    if (this.bar.value !== share) this.bar.value = share;
    const seen = (now - this.first.at) / 1000;
    const gained = done - this.first.done;
    const left = seen > 1.5 && gained > 0 ? `, ${durationText((seen * 1000 * (total - done)) / gained)} left` : "";
    setText(this.words, `${stage ? stage + " " : ""}${Math.floor(100 * share)} %${left}`);
  }
}

export function badge(state) {
  return node("span", { class: "badge", "data-state": state }, state);
}
export function setBadge(target, state) {
  if (target.dataset.state === state) return;
  target.dataset.state = state;
  target.textContent = state;
}

/** Shows the result of a click in a line at the bottom; errors stay longer. */
export function notify(text, isError = false) {
  const notice = node("p", { class: isError ? "notice error" : "notice" }, text);
  const notices = byId("notices");
  notices.append(notice);
  while (notices.childElementCount > 3) notices.firstElementChild.remove();
  setTimeout(() => notice.remove(), isError ? 12000 : 5000);
}

/** Asks the user; resolves to true if the user confirms. */
export function confirmed(title, text, yes) {
  const dialog = byId("confirm");
  setText(byId("confirm-title"), title);
  setText(byId("confirm-text"), text);
  setText(byId("confirm-yes"), yes);
  dialog.showModal();
  byId("confirm-yes").focus();
  // Does not use the event "close", which comes late and may belong to the previous question.
  return new Promise((resolve) => {
    dialog.querySelector("form").onsubmit = () => resolve(true);
    dialog.oncancel = () => resolve(false);
    byId("confirm-no").onclick = () => {
      dialog.close();
      resolve(false);
    };
  });
}
