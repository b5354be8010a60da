// SPDX-License-Identifier: Apache-2.0
// Shows the table of jobs. It shows one page of jobs, the newest first, and events update it. However busy the service
// is, the table has at most PAGE rows and is drawn at most ten times per second.

import { ask } from "./client.js";
import { errorText } from "./error_text.js";
import { ProgressBar, STATES, badge, byId, firstLine, jobName, node, notify, outputName, refreshTimes, setBadge,
  setText, timeNode, tookText } from "./nodes.js";

const PAGE = 50;
const DRAW_MS = 100;
const SEARCH_PAGE = 1000;
const SEARCH_PAGES = 5; // how many thousand jobs a text search covers

class Row {
  constructor(job, list) {
    this.link = node("a", { href: `#job-${job.id}`, tabindex: -1 }, String(job.id));
    this.badge = badge(job.state);
    this.progress = new ProgressBar();
    this.note = node("span", { class: "note" });
    this.name = node("span");
    this.where = node("span", { class: "folder" });
    this.attempts = node("td", { role: "cell", class: "number attempts" });
    this.took = node("td", { role: "cell", class: "number took" });
    const cell = (kind, ...children) => node("td", { role: "cell", class: kind }, ...children);
    this.root = node("tr", { role: "row", "data-id": job.id },
      cell("number", this.link), cell("type", job.type), cell("job", this.name, this.where), cell("queue", job.queue),
      cell("state", node("div", {}, this.badge, this.progress.root, this.note)), this.attempts,
      cell("number submitted", timeNode(job.created)), this.took);
    this.root.addEventListener("click", (event) => {
      if (event.target !== this.link) list.open(job.id);
    });
    this.link.addEventListener("focus", () => list.choose(job.id));
    this.show(job);
  }

  show(job) {
    this.job = job;
    setBadge(this.badge, job.state);
    setText(this.name, jobName(job));
    setText(this.where, job.label && job.output ? `  ${outputName(job)}` : "");
    this.name.title = job.output || job.label;
    setText(this.attempts, String(job.attempt));
    setText(this.took, tookText(job));
    this.progress.show(job);
    const note = job.state === "dead" ? job.message ?? "" : "";
    setText(this.note, firstLine(note));
    this.note.title = note;
    this.note.hidden = note === "";
  }
}

export class JobList {
  /** `on` has open(id) and changed(job), which is called for each job that an event names. */
  constructor(on) {
    this.on = on;
    this.rows = new Map();
    this.order = []; // ids, newest first
    this.before = []; // starts of earlier pages
    this.hasOlder = false;
    this.pending = new Map(); // jobs that events have changed since the page was drawn, by id
    this.progress = new Map();
    this.chosen = null;
    this.loads = 0;
    this.sinceLoad = null; // events during a request for a page, whose answer may be older
    this.searched = 0;
    for (const state of STATES) byId("filter-state").append(node("option", { value: state }, state));
    for (const id of ["filter-state", "filter-queue"]) byId(id).addEventListener("change", () => this.restart());
    byId("filter-text").addEventListener("input", () => {
      clearTimeout(this.typing);
      this.typing = setTimeout(() => this.restart(), 250);
    });
    byId("older").addEventListener("click", () => this.turn(() => this.before.push(this.order.at(-1))));
    byId("newer").addEventListener("click", () => this.turn(() => this.before.pop()));
    setInterval(() => this.tick(), 1000);
  }

  open(id) { this.on.open(id); }

  get filter() {
    return { state: byId("filter-state").value, queue: byId("filter-queue").value,
      text: byId("filter-text").value.trim().toLowerCase() };
  }

  matches(job, { state, queue, text }) {
    if ((state && job.state !== state) || (queue && job.queue !== queue)) return false;
    if (!text) return true;
    const words = [job.label, job.output, job.type, job.message, `#${job.id}`, JSON.stringify(job.parameters)];
    return String(job.id) === text || words.some((word) => word.toLowerCase().includes(text));
  }

  turn(how) {
    how();
    this.load().then(() => byId("jobs").scrollIntoView({ block: "start" }));
  }

  restart() {
    this.before = [];
    this.load();
  }

  /** Reads the page again. */
  async load() {
    const number = ++this.loads;
    const news = this.sinceLoad = new Map();
    const filter = this.filter;
    let jobs = [];
    let hasOlder = false;
    let from = this.before.at(-1);
    let searched = 0;
    try {
      for (let page = 0; page < (filter.text ? SEARCH_PAGES : 1); ++page) {
        const limit = filter.text ? SEARCH_PAGE : PAGE + 1;
        const query = new URLSearchParams({ limit });
        if (filter.state) query.set("state", filter.state);
        if (filter.queue) query.set("queue", filter.queue);
        if (from) query.set("before", from);
        const found = (await ask("GET", `/v1/jobs?${query}`)).jobs;
        if (number !== this.loads) return; // another request has replaced this one
        searched += found.length;
        jobs.push(...found.filter((job) => this.matches(job, filter)));
        hasOlder = found.length === limit;
        if (!hasOlder || jobs.length > PAGE) break;
        from = found.at(-1).id;
      }
    } catch (error) {
      if (error.status) notify(errorText(error), true); // the page shows a broken connection already
      if (this.sinceLoad === news) this.sinceLoad = null;
      return;
    }
    this.searched = filter.text ? searched : 0;
    this.hasOlder = jobs.length > PAGE || (hasOlder && jobs.length > 0);
    this.draw(jobs.slice(0, PAGE));
    this.sinceLoad = null;
    for (const job of news.values()) this.takeJob(job);
  }

  takeJob(job) {
    this.sinceLoad?.set(job.id, job);
    const known = this.pending.get(job.id) ?? this.rows.get(job.id)?.job;
    this.pending.set(job.id, { ...job, progress: job.state === "running" && known?.attempt === job.attempt
      ? known.progress : null });
    this.drawSoon();
  }

  takeProgress(progress) {
    this.progress.set(progress.id, progress);
    this.drawSoon();
  }

  drawSoon() {
    this.drawing ??= setTimeout(() => {
      this.drawing = null;
      this.flush();
    }, DRAW_MS);
  }

  flush() {
    const filter = this.filter;
    const jobs = new Map(this.order.map((id) => [id, this.rows.get(id).job]));
    const oldest = this.order.at(-1) ?? 0;
    for (const job of this.pending.values()) {
      const isShown = jobs.has(job.id);
      const isNew = this.before.length === 0 && (job.id > oldest || !this.hasOlder);
      if (this.matches(job, filter) ? isShown || isNew : false) jobs.set(job.id, job);
      else if (isShown) jobs.delete(job.id);
    }
    this.pending.clear();
    for (const [id, { stage, done, total }] of this.progress) {
      const job = jobs.get(id);
      if (job?.state === "running") jobs.set(id, { ...job, progress: { stage, done, total } });
    }
    this.progress.clear();
    const sorted = [...jobs.values()].sort((a, b) => b.id - a.id);
    if (sorted.length > PAGE) this.hasOlder = true;
    this.draw(sorted.slice(0, PAGE));
    if (sorted.length < PAGE && this.hasOlder) this.loadSoon(1500);
  }

  loadSoon(pause = 300) {
    this.loading ??= setTimeout(() => {
      this.loading = null;
      this.load();
    }, pause);
  }

  draw(jobs) {
    const focused = document.activeElement?.closest("#rows tr")?.dataset.id;
    const at = this.order.indexOf(Number(focused));
    const ids = new Set(jobs.map((job) => job.id));
    for (const [id, row] of this.rows) {
      if (ids.has(id)) continue;
      row.root.remove();
      this.rows.delete(id);
    }
    this.order = jobs.map((job) => job.id);
    let place = byId("rows").firstElementChild;
    for (const job of jobs) {
      let row = this.rows.get(job.id);
      if (row) {
        if (row.job !== job) row.show(job);
      } else {
        row = new Row(job, this);
        this.rows.set(job.id, row);
      }
      if (row.root === place) place = place.nextElementSibling;
      else byId("rows").insertBefore(row.root, place);
    }
    if (!ids.has(this.chosen)) this.choose(this.order[Math.min(Math.max(at, 0), this.order.length - 1)] ?? null);
    // When the focused row disappears, its neighbour gets the focus.
    if (focused && !ids.has(Number(focused))) this.focus();
    this.mark();
    this.showEmpty();
    byId("older").hidden = !this.hasOlder;
    byId("newer").hidden = this.before.length === 0;
    const span = this.order.length > 1 ? `jobs ${this.order[0]} to ${this.order.at(-1)}` : "";
    setText(byId("range"), this.searched ? `${jobs.length} found among ${this.searched} jobs` : span);
  }

  showEmpty() {
    const { state, queue, text } = this.filter;
    const kind = this.order.length > 0 ? "" : state || queue || text ? "filtered" : "none";
    byId("table").hidden = kind !== "";
    byId("empty").hidden = kind === "";
    if (byId("empty").dataset.kind === kind && !this.searched) return;
    byId("empty").dataset.kind = kind;
    if (kind === "filtered")
      byId("empty").replaceChildren(
        node("p", {}, this.searched ? `None of the newest ${this.searched} jobs matches.`
          : "No job matches."),
        node("button", { onclick: () => this.clear() }, "Show all jobs"));
    if (kind === "none")
      byId("empty").replaceChildren(node("p", {}, "No jobs yet. Submit one, here or from a shell:"),
        node("pre", {}, "multum jobs submit bake rock_normal.png -o rock.ndf.exr --lobes 4"));
  }

  clear() {
    for (const id of ["filter-state", "filter-queue", "filter-text"]) byId(id).value = "";
    this.restart();
    byId("filter-text").focus();
  }

  // ---- The chosen row. The Tab key reaches this row, and other keys lead from it to the other rows.

  choose(id) {
    const old = this.rows.get(this.chosen);
    if (old) old.link.tabIndex = -1;
    this.chosen = id;
    const row = this.rows.get(id);
    if (row) row.link.tabIndex = 0;
  }

  get chosenJob() { return this.rows.get(this.chosen)?.job ?? null; }

  focus() {
    const row = this.rows.get(this.chosen);
    if (!row) return byId("jobs").focus();
    row.link.focus({ preventScroll: true });
    row.root.scrollIntoView({ block: "nearest" });
  }

  move(step) {
    const isInside = document.activeElement?.closest("#rows") !== null;
    const at = this.order.indexOf(this.chosen);
    const next = isInside ? Math.min(Math.max(at + step, 0), this.order.length - 1) : Math.max(at, 0);
    if (this.order.length === 0) return;
    this.choose(this.order[next]);
    this.focus();
  }

  moveTo(place) {
    this.choose(this.order.at(place) ?? null);
    this.focus();
  }

  /** Marks the job that is open next to the list. */
  setOpen(id) {
    this.opened = id;
    if (this.rows.has(id)) this.choose(id);
    this.mark();
  }

  mark() {
    for (const [id, row] of this.rows) row.root.toggleAttribute("data-open", id === this.opened);
  }

  tick() {
    refreshTimes(byId("rows"));
    for (const row of this.rows.values()) if (!row.job.finished) setText(row.took, tookText(row.job));
  }
}
