// SPDX-License-Identifier: Apache-2.0
// Runs the page with the queues, the list of jobs, the open job, the keys, and the state of the connection to the
// service.

import { EventLine, ask } from "./client.js";
import { errorText, sayUncaughtErrors } from "./error_text.js";
import { JobDetail } from "./job_detail.js";
import { JobList } from "./job_list.js";
import { STATES, byId, bytesText, canCancel, canRetry, confirmed, isFinal, jobName, node, notify, setText }
  from "./nodes.js";
import { SubmitForm } from "./submit_form.js";

const LOOK_MS = 15000; // finds changes that cause no events: pauses by others, workers, a dead connection
const COUNT_MS = 1000; // pause between two requests for the counts while jobs change
const ALWAYS_COUNTED = ["queued", "running", "succeeded", "dead"];
const SAY_MS = 2000; // pause between two announcements to screen readers

let queues = [];

const list = new JobList({ open: (id) => { location.hash = `job-${id}`; } });
const detail = new JobDetail({ close: closeDetail, cancel, cancelPart, retry });
const form = new SubmitForm((job) => {
  list.loadSoon(0);
  location.hash = `job-${job.id}`;
});

// ---- Queues

function queueCard(queue) {
  const counts = STATES.filter((state) => queue.jobs[state] > 0 || ALWAYS_COUNTED.includes(state))
    .map((state) => node("span", { class: queue.jobs[state] ? null : "none" },
      node("b", {}, queue.jobs[state].toLocaleString()), ` ${state}`));
  const limits = [queue.jobs_max === null ? null : `${queue.jobs_max} at once`,
    queue.memory_max === null ? null : `${bytesText(queue.memory_max)} of memory`,
    queue.priority ? `priority ${queue.priority}` : null].filter((one) => one !== null);
  const verb = queue.paused ? "Resume" : "Pause";
  return node("li", {},
    node("div", { class: "queue-top" }, node("h3", {}, queue.name),
      queue.paused ? node("span", { class: "paused" }, "paused") : null,
      limits.length ? node("span", { class: "soft" }, limits.join(", ")) : null,
      node("button", { "data-queue": queue.name, "aria-label": `${verb} queue ${queue.name}`,
        onclick: () => setPaused(queue.name, !queue.paused) }, verb)),
    node("div", { class: "counts" }, ...counts));
}

function showQueues(answer) {
  if (JSON.stringify(answer) === JSON.stringify(showQueues.last)) return;
  showQueues.last = answer;
  queues = answer.queues.sort((a, b) => b.priority - a.priority || a.name.localeCompare(b.name));
  const focused = document.activeElement?.dataset.queue;
  byId("queues").replaceChildren(...queues.map(queueCard));
  if (focused !== undefined)
    [...byId("queues").querySelectorAll("button")].find((one) => one.dataset.queue === focused)?.focus();
  setText(byId("workers"), answer.workers === 1 ? "1 worker" : `${answer.workers} workers`);
  byId("workers").classList.toggle("error", answer.workers === 0);
  const select = byId("filter-queue");
  const names = ["", ...queues.map((queue) => queue.name)];
  if ([...select.options].map((option) => option.value).join("\n") !== names.join("\n")) {
    const chosen = select.value;
    select.replaceChildren(...names.map((name) => node("option", { value: name }, name || "any")));
    select.value = names.includes(chosen) ? chosen : "";
  }
  const sum = (state) => queues.reduce((total, queue) => total + queue.jobs[state], 0);
  byId("retry-dead").hidden = sum("dead") === 0;
  setText(byId("retry-dead"), `Retry all dead (${sum("dead").toLocaleString()})`);
  const total = STATES.reduce((all, state) => all + sum(state), 0);
  if (total < showQueues.total) list.loadSoon(0); // jobs were purged, which causes no event
  showQueues.total = total;
  const going = sum("running") + sum("publishing");
  document.title = going ? `(${going}) multum` : "multum";
}

let looking = null;
async function lookAtQueues() {
  looking ??= ask("GET", "/v1/queues").then((answer) => {
    showQueues(answer);
    setLine("live");
  }, (error) => {
    if (!error.status) setLine("broken");
  }).finally(() => { looking = null; });
  return looking;
}
let counting = null;
function lookSoon() {
  counting ??= setTimeout(() => {
    counting = null;
    lookAtQueues();
  }, COUNT_MS);
}

async function act(question, said) {
  try {
    const answer = await question;
    notify(said(answer));
  } catch (error) {
    notify(errorText(error), true);
  }
  lookAtQueues();
}

const setPaused = (name, isPaused) => act(
  ask("POST", `/v1/queues/${encodeURIComponent(name)}/${isPaused ? "pause" : "resume"}`),
  () => `Queue ${name} ${isPaused ? "is paused: running jobs continue, and none is started" : "is resumed"}.`);

// ---- Jobs

async function cancel(job) {
  if (!canCancel(job)) return notify(`Job ${job.id} is ${job.state}: it cannot be cancelled.`);
  const back = document.activeElement;
  const isSure = await confirmed(`Cancel job ${job.id}?`,
    job.state === "running" ? `${jobName(job)} is running; its work is lost.` : jobName(job), "Yes, cancel it");
  back?.focus();
  if (isSure) await act(ask("POST", `/v1/jobs/${job.id}/cancel`), (now) =>
    now.state === "cancelled" ? `Job ${job.id} is cancelled.` : `Job ${job.id} is asked to stop.`);
}

/** Cancels the share of a map; the merge requests it again. */
async function cancelPart(job, part) {
  await act(ask("POST", `/v1/jobs/${job.id}/cancel`, { part }),
    () => `Part ${part} of job ${job.id} is cancelled on Slurm, and requested again.`);
}

async function retry(job) {
  if (!canRetry(job)) return notify(`Job ${job.id} is ${job.state}: only dead and cancelled jobs can be retried.`);
  await act(ask("POST", `/v1/jobs/${job.id}/retry`), (now) => `Job ${job.id} is ${now.state} again.`);
}

async function retryDead() {
  const queue = byId("filter-queue").value;
  const dead = queues.filter((one) => !queue || one.name === queue).reduce((sum, one) => sum + one.jobs.dead, 0);
  const isSure = await confirmed("Retry all dead jobs?", `${dead.toLocaleString()} of ${queue ? `queue ${queue}` :
    "all queues"}: each is queued again, with all of its attempts.`, "Yes, retry them");
  if (isSure) await act(ask("POST", "/v1/retry", queue ? { queue } : {}),
    (answer) => `${answer.retried.length.toLocaleString()} jobs are queued again.`);
}

async function showHash() {
  const id = Number(/^#job-(\d+)$/.exec(location.hash)?.[1]);
  if (!id) return hideDetail();
  list.setOpen(id);
  if (!(await detail.open(id)) && !detail.isOpen) list.setOpen(null);
  shield();
}

function closeDetail() {
  if (location.hash) history.pushState(null, "", location.pathname);
  hideDetail();
}
function hideDetail() {
  if (!detail.isOpen) return;
  detail.close();
  shield();
  list.focus();
  list.setOpen(null);
}

// When the open job covers the list, keys and screen readers must not reach the hidden list.
const narrow = matchMedia("(max-width: 75rem)");
function shield() {
  const isCovered = detail.isOpen && narrow.matches;
  byId("main").inert = isCovered;
  document.querySelector(".top").inert = isCovered;
}
narrow.addEventListener("change", shield);

// ---- Connection

let brokenSince = null;
function setLine(state) {
  if (byId("line").dataset.state === state) return;
  byId("line").dataset.state = state;
  document.body.classList.toggle("is-broken", state === "broken");
  if (state === "broken") brokenSince = Date.now();
  const pause = brokenSince ? Math.round((Date.now() - brokenSince) / 1000) : 0;
  setText(byId("line-text"), state === "broken" ? "not connected: this page may be out of date; trying again" : "live");
  if (state === "live" && brokenSince !== null) {
    notify(`Connected again after ${Math.max(1, pause)} s.`);
    brokenSince = null;
    detail.refresh();
    list.loadSoon(0);
  }
}

const line = new EventLine({
  job: (job) => {
    list.takeJob(job);
    detail.takeJob(job);
    lookSoon();
    if (isFinal(job.state)) say(job);
  },
  progress: (progress) => {
    list.takeProgress(progress);
    detail.takeProgress(progress);
  },
  gap: () => {
    list.loadSoon();
    lookSoon();
    detail.refresh();
  },
  state: setLine,
});

// Collects the ends of jobs for one announcement, because a thousand separate announcements would not help.
const ended = [];
function say(job) {
  if (ended.push(job) > 1) return;
  setTimeout(() => {
    const all = ended.splice(0);
    const count = (state) => all.filter((one) => one.state === state).length;
    const parts = ["succeeded", "dead", "cancelled"].filter(count).map((state) => `${count(state)} ${state}`);
    setText(byId("announce"), all.length === 1 ? `Job ${all[0].id}, ${jobName(all[0])}: ${all[0].state}.`
      : `Jobs that ended: ${parts.join(", ")}.`);
  }, SAY_MS);
}

// ---- Keys

async function openForm() {
  if (queues.length === 0) await lookAtQueues(); // the page has just been opened
  form.open(queues.map((queue) => queue.name));
}
const lettersAreOn = () => localStorage.getItem("multum-letters") !== "off";
const inRows = () => document.activeElement?.closest("#rows") !== null && document.activeElement !== document.body;
/** Returns the job for the keys c and r: the open job, or the job in the focused row. */
const keyJob = () => (detail.job && !inRows() ? detail.job : list.chosenJob);

const LETTERS = {
  j: () => list.move(1),
  k: () => list.move(-1),
  c: () => keyJob() && cancel(keyJob()),
  r: () => keyJob() && retry(keyJob()),
  n: openForm,
  "/": () => byId("filter-text").focus(),
  "?": () => byId("keys").showModal(),
};
const ROW_KEYS = {
  ArrowDown: LETTERS.j,
  ArrowUp: LETTERS.k,
  Home: () => list.moveTo(0),
  End: () => list.moveTo(-1),
};

addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
  const isTyping = event.target.matches?.("input, select, textarea");
  if (event.key === "Escape") {
    if (detail.isOpen) closeDetail();
    else if (isTyping) list.focus();
    else return;
    event.preventDefault();
  } else if (!isTyping) {
    const isFree = inRows() || document.activeElement === document.body;
    const action = (lettersAreOn() && LETTERS[event.key]) || (isFree && ROW_KEYS[event.key]);
    if (!action) return;
    event.preventDefault();
    action();
  }
});

// ---- Light and dark

const THEMES = ["system", "light", "dark"];
function setTheme(theme) {
  if (theme === "system") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
  localStorage.setItem("multum-theme", theme);
  setText(byId("theme"), `Theme: ${theme}`);
}
const themeNow = () => document.documentElement.dataset.theme ?? "system";
byId("theme").addEventListener("click", () => setTheme(THEMES[(THEMES.indexOf(themeNow()) + 1) % THEMES.length]));
setTheme(THEMES.includes(localStorage.getItem("multum-theme")) ? localStorage.getItem("multum-theme") : "system");

byId("letters").checked = lettersAreOn();
byId("letters").addEventListener("change", (event) =>
  localStorage.setItem("multum-letters", event.target.checked ? "on" : "off"));
byId("help").addEventListener("click", () => byId("keys").showModal());
byId("new-job").addEventListener("click", openForm);
byId("retry-dead").addEventListener("click", retryDead);
addEventListener("hashchange", showHash);
addEventListener("popstate", () => { if (!location.hash) hideDetail(); });

sayUncaughtErrors((text) => notify(text, true));
await list.load();
await lookAtQueues();
line.look();
showHash();
setInterval(() => { if (document.visibilityState === "visible") lookAtQueues(); }, LOOK_MS);
