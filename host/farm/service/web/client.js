// SPDX-License-Identifier: Apache-2.0
// Handles the daemon's answers, its token, and its events.

import { errorText } from "./error_text.js";
import { byId, setText } from "./nodes.js";

const TOKEN = "multum-token";
const PATIENCE_MS = 70000; // longer than the minute that the service allows for pictures

export class Refused extends Error {
  constructor(status, message) {
    super(message);
    this.status = status;
  }
}

export const hasToken = () => sessionStorage.getItem(TOKEN) !== null;

let asking = null; // the dialog for the token; all refused requests share it

function askForToken(isWrong) {
  asking ??= new Promise((resolve) => {
    const dialog = byId("token");
    const input = byId("token-text");
    setText(byId("token-wrong"), isWrong ? "This token was refused." : "");
    input.value = "";
    dialog.addEventListener("cancel", (event) => event.preventDefault()); // without a token, nothing can be shown
    dialog.addEventListener("close", () => {
      sessionStorage.setItem(TOKEN, input.value);
      asking = null;
      resolve();
    }, { once: true });
    dialog.showModal();
    input.focus();
  });
  return asking;
}

/** Returns the raw answer. Asks the user for a token if needed; throws Refused, with status 0 if no service answers. */
export async function fetchAnswer(method, path, body = undefined, patience = PATIENCE_MS) {
  for (;;) {
    const token = sessionStorage.getItem(TOKEN);
    const response = await fetch(path, {
      method,
      body: body === undefined || body instanceof Blob ? body : JSON.stringify(body),
      headers: token === null ? {} : { Authorization: `Bearer ${token}` },
      signal: AbortSignal.timeout(patience),
    }).catch((error) => { throw new Refused(0, `The service does not answer (${errorText(error)}).`); });
    if (response.ok) return response;
    if (response.status !== 401) {
      const error = (await response.json().catch(() => null))?.error;
      throw new Refused(response.status, errorText(error, `the service answered ${response.status}`));
    }
    // Another request may have got a new token meanwhile.
    if (sessionStorage.getItem(TOKEN) === token) await askForToken(token !== null);
  }
}

export const ask = async (method, path, body) => (await fetchAnswer(method, path, body)).json();

let described = null;
/** Returns the types of jobs, and the fields to show. Requests them only once. */
export function askTypes() {
  described ??= ask("GET", "/v1/types").catch((error) => {
    described = null;
    throw error;
  });
  return described;
}

/**
 * Receives all events while the page is visible. A browser opens only six connections to a service, and background tabs
 * must not use all of them. `on` has job(job), progress(progress), gap() if events may have been missed, and
 * state("live" | "broken").
 */
export class EventLine {
  constructor(on) {
    this.on = on;
    this.last = null;
    this.source = null;
    document.addEventListener("visibilitychange", () => this.look());
    addEventListener("pagehide", () => this.close());
    addEventListener("pageshow", () => this.look());
  }

  look() {
    clearTimeout(this.hiding);
    if (document.visibilityState === "visible") this.open();
    else this.hiding = setTimeout(() => this.close(), 5000);
  }

  close() {
    this.source?.close();
    this.source = null;
  }

  open() {
    if (this.source) return;
    const token = sessionStorage.getItem(TOKEN);
    const query = token === null ? "" : `?access_token=${encodeURIComponent(token)}`;
    const source = new EventSource(`/v1/events${query}`);
    this.source = source;
    source.onopen = () => {
      this.last = null;
      this.on.state("live");
      this.on.gap();
    };
    source.onerror = () => {
      this.on.state("broken");
      if (source.readyState !== EventSource.CLOSED) return; // the browser reconnects by itself
      this.close();
      // The service refused the connection, usually because of the token. The next request then asks for a token.
      setTimeout(() => fetchAnswer("GET", "/v1/queues").then(() => this.look(), () => this.look()), 2000);
    };
    source.addEventListener("job", (event) => this.take(event, this.on.job));
    source.addEventListener("progress", (event) => this.take(event, this.on.progress));
    source.addEventListener("missed", (event) => { // some events are no longer kept, or another daemon counts
      this.last = Number(event.lastEventId);
      this.on.gap();
    });
  }

  take(event, deliver) {
    const number = Number(event.lastEventId);
    if (this.last !== null && number !== this.last + 1) this.on.gap();
    this.last = number;
    deliver(JSON.parse(event.data));
  }
}
