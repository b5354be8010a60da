// SPDX-License-Identifier: Apache-2.0
// Defines sources of a packed field's bytes. A source is a URL that is read by ranges, a file that the user chose, or
// bytes in the page. Each source has a `name` for messages, `read(offset, length, signal)`, and `size`, which is known
// after the first read.

import { errorText } from "./error_text.js";

const ATTEMPTS = 4;
const FIRST_PAUSE_MS = 250; // pause before a retry; doubles with each attempt
const SILENCE_MS = 20000; // after this time without a byte, the connection counts as broken
const BODY_BYTES_MAX = 2 ** 31; // limit for a body from a server without ranges

export class FieldError extends Error {}

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

/** Reads at most `limit` bytes of a response. If it ends early, returns fewer and sets `isCut`. */
async function bodyBytes(response, limit, abort) {
  const parts = [];
  let count = 0;
  let timer = 0;
  let isCut = false;
  const reader = response.body.getReader();
  try {
    for (;;) {
      timer = setTimeout(abort, SILENCE_MS);
      const { done, value } = await reader.read();
      clearTimeout(timer);
      if (done) break;
      parts.push(value);
      count += value.length;
      if (count > limit) {
        await reader.cancel();
        break;
      }
    }
  } catch {
    isCut = true;
  } finally {
    clearTimeout(timer);
  }
  const bytes = new Uint8Array(count);
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return { bytes, isCut };
}

/** Sends a GET, and retries while the network or the server fails. Adds to `counts.fetched` and `counts.retries`. */
class PatientRequest {
  constructor(url, name, counts) {
    Object.assign(this, { url, name, counts });
  }

  /** `accept(response)` returns the most bytes to expect, or throws FieldError if the response cannot be used. */
  async run(headers, accept, signal) {
    let reason = "";
    for (let attempt = 0; attempt < ATTEMPTS; ++attempt) {
      if (attempt > 0) {
        ++this.counts.retries;
        await pause(FIRST_PAUSE_MS * 2 ** (attempt - 1));
      }
      signal?.throwIfAborted();
      const own = new AbortController();
      const forward = () => own.abort();
      signal?.addEventListener("abort", forward);
      const timer = setTimeout(forward, SILENCE_MS);
      try {
        const response = await fetch(this.url, { headers, signal: own.signal });
        clearTimeout(timer);
        if (response.status >= 500) {
          reason = `the server answered ${response.status}`;
          continue;
        }
        const expected = accept(response);
        const { bytes, isCut } = await bodyBytes(response, expected.most, forward);
        this.counts.fetched += bytes.length;
        if (!isCut && bytes.length >= expected.least) return { bytes, response };
        reason = `the connection was cut after ${bytes.length} of ${expected.least} bytes`;
      } catch (error) {
        if (error instanceof FieldError) throw error;
        reason = `the server cannot be reached (${errorText(error)})`;
      } finally {
        clearTimeout(timer);
        signal?.removeEventListener("abort", forward);
      }
    }
    signal?.throwIfAborted();
    throw new FieldError(`${this.name}: ${reason}; tried ${ATTEMPTS} times`);
  }
}

export class UrlSource {
  constructor(url, counts) {
    this.url = String(url);
    this.name = decodeURIComponent(new URL(this.url).pathname.split("/").pop()) || this.url;
    this.counts = counts;
    this.size = null;
    this.whole = null; // whole file from a server without ranges
  }

  async read(offset, length, signal) {
    if (this.whole !== null) return this.whole.slice(offset, offset + length);
    if (length === 0) return new Uint8Array(0);
    const request = new PatientRequest(this.url, this.name, this.counts);
    const range = `bytes=${offset}-${offset + length - 1}`;
    const { bytes, response } = await request.run({ Range: range }, (answer) => this.expected(answer, offset, length),
      signal);
    if (response.status === 206) return bytes;
    this.whole = bytes;
    this.size = bytes.length;
    return bytes.slice(offset, offset + length);
  }

  /** Returns the number of bytes that the answer to a range should have. */
  expected(response, offset, length) {
    if (response.status === 206) {
      const [, first, total] = /^bytes (\d+)-\d+\/(\d+)$/.exec(response.headers.get("Content-Range") ?? "") ?? [];
      if (first === undefined || Number(first) !== offset)
        throw new FieldError(`${this.name}: the server sent another range than requested`);
      if (this.size !== null && this.size !== Number(total))
        throw new FieldError(`${this.name}: has ${total} bytes now, had ${this.size} before: the file was replaced; ` +
          "load the page again");
      this.size = Number(total);
      const count = Math.min(length, this.size - offset);
      return { least: count, most: count };
    }
    if (response.status === 416) throw new FieldError(`${this.name}: ends before byte ${offset}`);
    if (response.status !== 200)
      throw new FieldError(`${this.name}: the server answered ${response.status}, expected 200 or 206`);
    // If the transfer is compressed, the transfer's length is not the length of the file.
    const isPlain = !response.headers.get("Content-Encoding");
    return { least: isPlain ? Number(response.headers.get("Content-Length") ?? 0) : 0, most: BODY_BYTES_MAX };
  }
}

/** Reads the whole body at a URL, for geometry and the decoder. */
export async function wholeBody(url, name, counts, most) {
  const request = new PatientRequest(String(url), name, counts);
  const { bytes } = await request.run({}, (response) => {
    if (!response.ok) throw new FieldError(`${name}: the server answered ${response.status}, expected 200`);
    const isPlain = !response.headers.get("Content-Encoding");
    return { least: isPlain ? Number(response.headers.get("Content-Length") ?? 0) : 0, most };
  });
  if (bytes.length > most) throw new FieldError(`${name}: has more than ${most} bytes`);
  return bytes;
}

export class BlobSource {
  constructor(blob, name) {
    Object.assign(this, { blob, name, size: blob.size });
  }

  async read(offset, length) {
    return new Uint8Array(await this.blob.slice(offset, offset + length).arrayBuffer());
  }
}
