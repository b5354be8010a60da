// SPDX-License-Identifier: Apache-2.0
// What is held of a field, textures and compressed chunks, within a budget of bytes that is never exceeded: the least
// recently used go first. What is in use now is not given up for anything else.

export class TextureStore {
  /** `release(entry)`: called for each entry that goes. */
  constructor(budget, release) {
    Object.assign(this, { budget, release, bytes: 0, peak: 0, evictions: 0, entries: new Map() });
  }

  has(key) { return this.entries.has(key); }
  get size() { return this.entries.size; }

  /** The entry, which counts as used now; undefined where it is not here. */
  get(key) {
    const entry = this.entries.get(key);
    if (entry !== undefined) {
      this.entries.delete(key);
      this.entries.set(key, entry);
    }
    return entry;
  }

  /** Makes room for so many bytes, keeping entries whose key `isNeeded`; false where there is none to be had. */
  makeRoom(bytes, isNeeded) {
    if (bytes > this.budget) return false;
    for (const [key, entry] of this.entries) {
      if (this.bytes + bytes <= this.budget) return true;
      if (!isNeeded(key)) this.remove(key, entry);
    }
    return this.bytes + bytes <= this.budget;
  }

  /** After makeRoom(entry.bytes) only. */
  put(key, entry) {
    if (this.bytes + entry.bytes > this.budget) throw new Error("no room was made for what is stored");
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
