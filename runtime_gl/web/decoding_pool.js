// SPDX-License-Identifier: Apache-2.0
// Decodes textures in workers, starting with the most urgent textures. If a waiting texture becomes unnecessary, it is
// not decoded, and the download of its bytes stops. A worker has one request at a time, so that a new request waits for
// at most one texture. All textures of a chunk go to one worker, which keeps the decoded chunk.

import { errorText } from "./error_text.js";

const PER_WORKER_FETCHES = 2;

export class DecodingPool {
  /**
   * `makeWorker` returns a new Worker. `wasm` has the module's bytes. `fetchSection(wish, signal)` fetches a chunk.
   * Each request ("wish") ends with `deliver(wish, levels, ms)` or `fail(wish, error)`.
   */
  constructor({ count, makeWorker, wasm, fetchSection, deliver, fail }) {
    Object.assign(this, { fetchSection, deliver, fail, wishes: [], fetches: new Map(), sections: new Map() });
    this.owners = new Map(); // workers by chunk
    this.nextWorker = 0;
    this.workers = Array.from({ length: count }, () => {
      const worker = makeWorker();
      const slot = { worker, current: null, memory: 0, has: new Set(), begun: 0, isBroken: false };
      worker.onmessage = ({ data }) => this.answered(slot, data);
      worker.onerror = (event) => this.broken(slot, event);
      worker.postMessage({ wasm });
      return slot;
    });
  }

  get memory() { return this.workers.reduce((sum, slot) => sum + slot.memory, 0); }

  /** Replaces the list of wanted textures that are missing, the most urgent first. */
  want(wishes) {
    this.wishes = wishes;
    const chunks = new Set(wishes.map((wish) => wish.chunk));
    for (const [chunk, abort] of this.fetches) if (!chunks.has(chunk)) abort.abort();
    for (const chunk of this.sections.keys()) if (!chunks.has(chunk)) this.sections.delete(chunk);
    this.work();
  }

  get hasRoomToFetch() { return this.fetches.size + this.sections.size < PER_WORKER_FETCHES * this.workers.length; }

  isRunning(wish) { return this.workers.some((slot) => slot.current?.key === wish.key); }

  work() {
    for (const wish of this.wishes) {
      if (this.isRunning(wish)) continue;
      const slot = this.ownerOf(wish.chunk);
      if (slot === null) {
        this.drop(wish, new Error("all decoding workers have failed: load the page again"));
        return;
      }
      const isHere = slot.has.has(wish.chunk) || this.sections.has(wish.chunk);
      if (isHere && slot.current === null) this.start(slot, wish);
      else if (!isHere && !this.fetches.has(wish.chunk) && this.hasRoomToFetch) this.fetch(wish);
    }
  }

  ownerOf(chunk) {
    if (!this.owners.has(chunk)) {
      const sound = this.workers.filter((slot) => !slot.isBroken);
      if (sound.length === 0) return null;
      this.owners.set(chunk, sound[this.nextWorker++ % sound.length]);
    }
    return this.owners.get(chunk);
  }

  async fetch(wish) {
    const abort = new AbortController();
    this.fetches.set(wish.chunk, abort);
    try {
      const bytes = await this.fetchSection(wish, abort.signal);
      if (this.wishes.some((one) => one.chunk === wish.chunk)) this.sections.set(wish.chunk, bytes);
    } catch (error) {
      if (!abort.signal.aborted) this.drop(wish, error);
    }
    this.fetches.delete(wish.chunk);
    this.work();
  }

  /** Ends all requests for textures of the same chunk as this request. */
  drop(wish, error) {
    this.wishes = this.wishes.filter((one) => one.chunk !== wish.chunk);
    this.fail(wish, error);
  }

  start(slot, wish) {
    slot.current = wish;
    slot.begun = performance.now();
    const bytes = slot.has.has(wish.chunk) ? null : this.sections.get(wish.chunk);
    this.sections.delete(wish.chunk);
    slot.has.add(wish.chunk);
    const { key: id, chunk, texture, textures, width, height } = wish;
    slot.worker.postMessage({ id, chunk, bytes, texture, textures, width, height });
  }

  answered(slot, { levels, isGone, problem, memory }) {
    const wish = slot.current;
    slot.current = null;
    slot.memory = memory;
    if (isGone) {
      slot.has.delete(wish.chunk);
    } else if (problem !== undefined) {
      slot.has.delete(wish.chunk);
      this.drop(wish, new Error(problem));
    } else {
      this.wishes = this.wishes.filter((one) => one.key !== wish.key);
      this.deliver(wish, levels, performance.now() - slot.begun);
    }
    this.work();
  }

  broken(slot, event) {
    const error = new Error(`a decoding worker failed (${errorText(event, "it did not start")})`);
    const isHis = (wish) => this.owners.get(wish.chunk) === slot;
    const wishes = this.wishes.filter(isHis);
    slot.current = null;
    slot.isBroken = true;
    for (const [chunk, owner] of this.owners) if (owner === slot) this.owners.delete(chunk);
    for (const wish of wishes) this.drop(wish, error);
    if (wishes.length === 0) this.fail(null, error);
  }

  close() {
    this.want([]);
    for (const slot of this.workers) slot.worker.terminate();
  }
}
