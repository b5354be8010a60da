// SPDX-License-Identifier: Apache-2.0
// Shows one job with all its fields, its pictures, and its growing log.

import { ask, askTypes, fetchAnswer, hasToken } from "./client.js";
import { errorText } from "./error_text.js";
import { ProgressBar, badge, byId, bytesText, canCancel, canRetry, durationText, isFinal, jobName, node, notify,
  outputName, refreshTimes, setBadge, setText, timeNode, tookText } from "./nodes.js";

const LOG_SHOWN = 200000; // characters from the end of the log
const LOG_LARGE = 1000000; // a log longer than this is read every ten seconds instead of every two

const table = (head, rows) => node("div", { class: "scroll" }, node("table", {},
  node("thead", {}, node("tr", {}, ...head.map((one) => node("th", { scope: "col" }, one)))),
  node("tbody", {}, ...rows.map((row) => node("tr", {}, ...row.map((one) => node("td", {}, one)))))));

const facts = (pairs) => node("dl", { class: "facts" },
  ...pairs.filter(([, value]) => value !== "").flatMap(([name, value]) =>
    [node("dt", {}, name), node("dd", {}, ...[value].flat())]));

// For unfinished parts, shows Slurm's state and the progress.
function partState({ state, slurm_state: slurmState, progress }) {
  if (state !== "sent") return state;
  const share = progress && progress.total ? ` ${Math.floor((100 * progress.done) / progress.total)} %` : "";
  return `${(slurmState || "sent").toLowerCase()}${slurmState === "RUNNING" ? share : ""}`;
}

const jobLink = (id) => node("a", { href: `#job-${id}` }, `job ${id}`);

const SHOWN = { plain: String, time: timeNode, bytes: (value) => (value ? bytesText(value) : ""),
  job: (value) => [value].flat().flatMap((id, i) => (i ? [", ", jobLink(id)] : [jobLink(id)])) };

/** Returns the rows of `facts` for a field; GET /v1/types describes the fields. */
function rowsOf({ name, label, form }, job) {
  const value = job[name];
  if (form === "object") return Object.entries(value).map(([key, one]) => [key, String(one)]);
  return value === null || value.length === 0 ? [] : [[label, SHOWN[form](value)]];
}

export class JobDetail {
  /** `on` has close(), cancel(job), cancelPart(job, part) and retry(job). */
  constructor(on) {
    this.on = on;
    this.root = byId("detail");
    this.job = null;
    setInterval(() => this.tick(), 1000);
  }

  get isOpen() { return !this.root.hidden; }

  async open(id) {
    this.close();
    this.number = id;
    this.wasTold = false; // a change was reported during a request, whose answer may be older
    let job;
    try {
      job = await ask("GET", `/v1/jobs/${id}`);
      this.described = await askTypes();
    } catch (error) {
      notify(errorText(error), true);
      return false;
    }
    if (this.number !== id) return false;
    this.build(job);
    this.root.hidden = false;
    document.body.classList.add("has-detail");
    this.root.scrollTop = 0;
    this.title.focus();
    this.loadLog();
    this.loadPictures();
    if (this.wasTold) this.refresh();
    return true;
  }

  close() {
    this.number = null;
    this.job = null;
    clearTimeout(this.logTimer);
    for (const url of this.urls ?? []) URL.revokeObjectURL(url);
    this.urls = [];
    this.root.hidden = true;
    this.root.replaceChildren();
    document.body.classList.remove("has-detail");
  }

  build(job) {
    this.title = node("h2", { id: "detail-title", tabindex: -1 }, `${job.type} ${job.id}: ${jobName(job)}`);
    this.badge = badge(job.state);
    this.took = node("span", { class: "soft" });
    this.progress = new ProgressBar();
    this.why = node("p", { class: "why", hidden: true });
    this.cancelButton = node("button", { class: "danger", "aria-keyshortcuts": "c",
      onclick: () => this.on.cancel(this.job) }, "Cancel");
    this.retryButton = node("button", { "aria-keyshortcuts": "r", onclick: () => this.on.retry(this.job) }, "Retry");
    this.download = node("a", { href: `/v1/jobs/${job.id}/result`, download: "",
      onclick: (event) => this.fetchResult(event) }, "Download the result");
    const views = (this.described.types.find((one) => one.name === job.type)?.views ?? []).filter((view) =>
      Object.entries(view.only_for).every(([name, value]) => (job.parameters[name] ?? value) === value));
    this.views = views.filter((view) => view.file.endsWith(".png"));
    this.pages = views.filter((view) => view.file.endsWith(".html")).map((view) => this.pageLink(job, view));
    this.pictures = node("div", { class: "pictures" });
    this.picturesPart = node("section", { "aria-label": "Pictures", hidden: true }, node("h3", {}, "Pictures"),
      this.pictures);
    this.facts = node("div");
    this.attempts = node("div");
    this.parts = node("div");
    this.partsPart = node("section", { "aria-label": "Parts", hidden: true }, node("h3", {}, "Parts at Slurm"),
      this.parts);
    this.logNote = node("p", { class: "soft" });
    this.log = node("pre", { class: "log", tabindex: 0, role: "log", "aria-label": "Log", "aria-live": "off" });
    this.root.replaceChildren(
      node("div", { class: "detail-top" }, this.title,
        node("button", { onclick: () => this.on.close(), "aria-keyshortcuts": "Escape" }, "Close")),
      node("p", {}, this.badge, " ", this.took), this.progress.root, this.why,
      node("div", { class: "actions" }, this.cancelButton, this.retryButton, this.download,
        ...this.pages),
      this.picturesPart,
      node("h3", {}, "Job"), this.facts,
      node("h3", {}, "Attempts"), this.attempts, this.partsPart,
      node("h3", {}, "Log"), this.logNote, this.log);
    this.logSize = -1;
    this.ticks = 0;
    this.show(job);
  }

  show(job) {
    this.job = job;
    setBadge(this.badge, job.state);
    this.progress.show(job);
    this.why.hidden = !job.message || job.state === "succeeded";
    setText(this.why, job.message);
    this.cancelButton.hidden = !canCancel(job);
    this.retryButton.hidden = !canRetry(job);
    this.download.hidden = job.state !== "succeeded" || !job.output;
    for (const page of this.pages) page.hidden = this.download.hidden;
    this.showTook();
    this.facts.replaceChildren(facts(this.described.fields.flatMap((field) => rowsOf(field, job))));
    const rows = (job.attempts ?? []).map((one) => [String(one.number), one.outcome, timeNode(one.started),
      one.ended ? durationText(Date.parse(one.ended) - Date.parse(one.started)) : "",
      one.exit_code === null ? "" : String(one.exit_code), one.message]);
    this.attempts.replaceChildren(rows.length
      ? table(["number", "outcome", "started", "took", "exit code", "message"], rows)
      : node("p", { class: "soft" }, `None yet, of ${job.attempt_max} at most.`));
    this.showParts(job.parts ?? []);
  }

  showParts(parts) {
    this.partsPart.hidden = parts.length === 0;
    const stop = (one) => node("button", { class: "danger", "aria-label": `Cancel part ${one.part}`,
      onclick: () => this.on.cancelPart(this.job, one.part) }, "Cancel");
    this.parts.replaceChildren(table(["part", "attempt", "state", "node", "Slurm's job", "message", ""],
      parts.map((one) => [one.part || "all", one.round > 1 ? `${one.attempt}, round ${one.round}` : String(one.attempt),
        partState(one), one.node, one.slurm_job === null ? "" : String(one.slurm_job), one.message,
        one.state === "sent" && one.part ? stop(one) : ""])));
  }

  showTook() {
    const words = this.job.finished ? "took" : "for";
    setText(this.took, this.job.started ? `${words} ${tookText(this.job)}` : "not started yet");
  }

  // ---- Updates

  takeJob(job) {
    if (job.id === this.number) this.wasTold = true;
    if (job.id !== this.job?.id) return;
    const wasFinal = isFinal(this.job.state);
    const progress = job.attempt === this.job.attempt ? this.job.progress : null;
    this.show({ ...job, attempts: this.job.attempts, parts: this.job.parts, progress });
    clearTimeout(this.reload);
    this.reload = setTimeout(() => this.refresh(), 200);
    if (isFinal(job.state) && !wasFinal) this.loadPictures();
  }

  takeProgress({ id, stage, done, total }) {
    if (id !== this.job?.id) return;
    this.job.progress = { stage, done, total };
    this.progress.show(this.job);
  }

  /** Reads the job again, after a lost connection or for changes without events. */
  async refresh() {
    const id = this.number;
    if (id === null || !this.isOpen) return;
    try {
      const job = await ask("GET", `/v1/jobs/${id}`);
      if (this.number !== id) return;
      this.show(job);
      this.loadLog();
    } catch (error) {
      if (error.status === 404) this.on.close();
    }
  }

  tick() {
    if (!this.job) return;
    // Parts cause no events when they are sent or when they end.
    const parts = this.job.parts ?? [];
    const mayChange = parts.length === 0 ? this.job.state === "running" : parts.some((one) => one.state === "sent");
    if (mayChange && ++this.ticks % 3 === 0) this.refresh();
    refreshTimes(this.root);
    this.showTook();
  }

  async loadLog() {
    clearTimeout(this.logTimer);
    const id = this.number;
    try {
      const text = await (await fetchAnswer("GET", `/v1/jobs/${id}/log`)).text();
      if (this.number !== id) return;
      if (text.length !== this.logSize) this.showLog(text);
    } catch {
      // The page shows that the connection is broken. The next request may succeed.
    }
    if (this.number === id && this.job && !isFinal(this.job.state))
      this.logTimer = setTimeout(() => this.loadLog(), this.logSize > LOG_LARGE ? 10000 : 2000);
  }

  showLog(text) {
    const isAtEnd = this.log.scrollHeight - this.log.scrollTop - this.log.clientHeight < 8;
    this.logSize = text.length;
    const start = text.length > LOG_SHOWN ? text.indexOf("\n", text.length - LOG_SHOWN) + 1 : 0;
    setText(this.logNote, start > 0 ? `its last ${bytesText(text.length - start)} of ${bytesText(text.length)}`
      : text ? "" : isFinal(this.job.state) ? "The log is empty." : "The log is empty so far.");
    this.logNote.hidden = this.logNote.textContent === "";
    setText(this.log, text.slice(start));
    this.log.hidden = text === "";
    if (isAtEnd) this.log.scrollTop = this.log.scrollHeight;
  }

  // ---- Files

  async loadPictures() {
    const job = this.job;
    const wanted = this.views;
    const isShown = job.state === "succeeded" && wanted.length > 0;
    this.picturesPart.hidden = !isShown;
    if (!isShown) return;
    const holes = wanted.map(({ caption }) => node("figure", {}, node("div", { class: "hole" }, "being made ..."),
      node("figcaption", {}, caption)));
    this.pictures.replaceChildren(...holes);
    await Promise.all(wanted.map(async ({ file, caption }, i) => {
      try {
        const blob = await (await fetchAnswer("GET", `/v1/jobs/${job.id}/pictures/${file}`)).blob();
        if (this.number !== job.id) return;
        const url = URL.createObjectURL(blob);
        this.urls.push(url);
        holes[i].firstElementChild.replaceWith(node("button", { onclick: () => this.enlarge(url, caption) },
          node("img", { src: url, alt: `${caption}, of job ${job.id}; click to enlarge` })));
      } catch (error) {
        holes[i].firstElementChild.textContent = errorText(error);
      }
    }));
  }

  enlarge(url, caption) {
    const dialog = byId("picture");
    dialog.replaceChildren(node("img", { src: url, alt: caption }), node("p", {}, caption),
      node("div", { class: "actions" }, node("button", { onclick: () => dialog.close() }, "Close")));
    dialog.showModal();
  }

  /**
   * Downloads with a script, because a link cannot send the token, and the token must not appear in a list of
   * downloads.
   */
  fetchResult(event) { return this.save(event, "result", (blob) => (blob.type === "application/x-tar" ? ".tar" : "")); }

  /** Makes a link to a page that shows the result; the service makes the page at the first request. */
  pageLink(job, view) {
    const link = node("a", { href: `/v1/jobs/${job.id}/pictures/${view.file}`, target: "_blank", rel: "noopener",
      onclick: (event) => this.openPage(event, link, view) });
    this.namePage(link, view);
    return link;
  }

  namePage(link, view) { setText(link, hasToken() ? view.saved_caption : view.caption); }

  /** Waits until the page is made, which may take a while, so that a refusal is shown here. */
  async openPage(event, link, view) {
    if (link.isMade && !hasToken()) return;
    event.preventDefault();
    if (link.hasAttribute("aria-busy")) return;
    link.setAttribute("aria-busy", "true");
    setText(link, "The page is being made ...");
    try {
      if (hasToken()) {
        await this.save(event, `pictures/${view.file}`, () => ".html");
      } else {
        await (await fetchAnswer("GET", link.getAttribute("href"))).body.cancel();
        link.isMade = true;
      }
    } catch (error) {
      notify(errorText(error), true);
    }
    link.removeAttribute("aria-busy");
    if (!link.isConnected) return; // another job was opened meanwhile
    this.namePage(link, view);
    // If the browser blocks a new tab so long after the click, the user can click the link again.
    if (link.isMade) link.click();
  }

  async save(event, part, endingOf) {
    if (!hasToken()) return;
    event.preventDefault();
    try {
      const blob = await (await fetchAnswer("GET", `/v1/jobs/${this.job.id}/${part}`)).blob();
      const url = URL.createObjectURL(blob);
      node("a", { href: url, download: outputName(this.job) + endingOf(blob) }).click();
      setTimeout(() => URL.revokeObjectURL(url), 60000);
    } catch (error) {
      notify(errorText(error), true);
    }
  }
}
