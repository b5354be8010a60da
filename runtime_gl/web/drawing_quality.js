// SPDX-License-Identifier: Apache-2.0
// How many sub-pixels are drawn while the position moves: fewer where frames take too long, more again where they do
// not. Also how many frames a second there are.

const SLOW_FRAME_MS = 45;
const FAST_FRAME_MS = 20; // displays of 60 Hz show one every 16.7 ms
const PAUSE_MS = 2000; // between two frames: nothing has moved meanwhile
const FRAMES_LEAST = 3; // between two changes
const NEWEST_SHARE = 0.35; // of the newest frame in the average

export class DrawingQuality {
  /** `finest`: sub-pixels along a pixel's side, at most. */
  constructor(finest) {
    Object.assign(this, { finest, side: finest, lastAt: -Infinity, frameMs: 0, frameCount: 0 });
  }

  get framesPerSecond() { return this.frameMs > 0 ? 1000 / this.frameMs : 0; }

  /** A frame while the position moves begins, at `now` ms. */
  frame(now) {
    const ms = now - this.lastAt;
    this.lastAt = now;
    if (ms > PAUSE_MS) {
      this.frameCount = 0;
      return;
    }
    ++this.frameCount;
    this.frameMs = this.frameCount === 1 ? ms : this.frameMs + NEWEST_SHARE * (ms - this.frameMs);
    if (this.frameCount < FRAMES_LEAST) return;
    if (this.frameMs > SLOW_FRAME_MS && this.side > 1) this.change(Math.max(1, Math.floor(this.side / 2)));
    else if (this.frameMs < FAST_FRAME_MS && this.side < this.finest) this.change(this.side + 1);
  }

  change(side) {
    this.side = side;
    this.frameCount = 0;
  }
}
