// SPDX-License-Identifier: Apache-2.0
// Chooses the number of sub-pixels while the position moves. The number is lower if frames take too long, and higher
// otherwise. Also measures frames per second.

const SLOW_FRAME_MS = 45;
const FAST_FRAME_MS = 20; // displays of 60 Hz show a frame every 16.7 ms
const PAUSE_MS = 2000; // longer gaps between frames mean that the position was at rest
const FRAMES_LEAST = 3; // number of frames between two changes
const NEWEST_SHARE = 0.35; // weight of the newest frame in the average

export class DrawingQuality {
  /** `finest` is the largest number of sub-pixels along a pixel's side. */
  constructor(finest) {
    Object.assign(this, { finest, side: finest, lastAt: -Infinity, frameMs: 0, frameCount: 0 });
  }

  get framesPerSecond() { return this.frameMs > 0 ? 1000 / this.frameMs : 0; }

  /** Call when a frame begins, at `now` ms, while the position moves. */
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
