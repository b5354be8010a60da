// SPDX-License-Identifier: Apache-2.0
// Keeps textures and compressed chunks of a field within a budget of bytes. The budget is never exceeded. Removes the
// least recently used entries first, but never entries that are in use.

export class TextureStore {
  /** `release(entry)` is called for each removed entry. */
  constructor(budget, release) {
    Object.assign(this, { budget, release, bytes: 0, peak: 0, evictions: 0, entries: new Map() });
  }

  has(key) { return this.entries.has(key); }
  get size() { return this.entries.size; }

  /** Returns the entry and marks it as used, or returns undefined if it is absent. */
  get(key) {
    const entry = this.entries.get(key);
    if (entry !== undefined) {
      this.entries.delete(key);
      this.entries.set(key, entry);
    }
    return entry;
  }

  /**
   * Makes room for this many bytes, but keeps entries if `isNeeded(key)` is true. Returns false if that is not enough.
   */
  makeRoom(bytes, isNeeded) {
    if (bytes > this.budget) return false;
    for (const [key, entry] of this.entries) {
      if (this.bytes + bytes <= this.budget) return true;
      if (!isNeeded(key)) this.remove(key, entry);
    }
    return this.bytes + bytes <= this.budget;
  }

  /** Call only after makeRoom(entry.bytes). */
  put(key, entry) {
    if (this.bytes + entry.bytes > this.budget) throw new Error("no room was made for the new entry");
    this.entries.set(key, entry);
    this.bytes += entry.bytes;
    this.peak = Math.max(this.peak, this.bytes);
  }

  remove(key, entry) {
    this.entries.delete(key);
    this.bytes -= entry.bytes;
    ++this.evictions;
    this.release(entry);
  }

  setBudget(budget) {
    this.budget = budget;
    this.makeRoom(0, () => false);
  }

  clear() {
    for (const [key, entry] of [...this.entries]) this.remove(key, entry);
  }
}
