// SPDX-License-Identifier: Apache-2.0
// Records a path through the parameters, which the user can play again and save as JSON
// (docs/reference/packed_fields.md, "Recorded paths"):
//   { "multumPath": 1, "parameters": ["view", "light"], "positions": [[0, 0.5, 3], ...] }
// A position contains the seconds since the first position, and then a fractional index along each parameter.

const INTERVAL_S = 0.05; // between recorded positions
const POSITIONS_MAX = 100000;

export class RecordedPath {
  constructor(parameters, positions = []) {
    Object.assign(this, { parameters, positions });
  }

  /** Reads a path from JSON text. Throws Error with the problem. */
  static parse(text, parameters) {
    let json;
    try {
      json = JSON.parse(text);
    } catch {
      throw new Error("the path is not JSON");
    }
    if (json?.multumPath !== 1) throw new Error("the file is not a path: expected \"multumPath\": 1");
    if (JSON.stringify(json.parameters) !== JSON.stringify(parameters))
      throw new Error(`the path is a path through ${json.parameters}, expected the field's parameters ${parameters}`);
    const isSound = Array.isArray(json.positions) && json.positions.length >= 2 &&
      json.positions.length <= POSITIONS_MAX && json.positions.every((one, i) => Array.isArray(one) &&
        one.length === parameters.length + 1 && one.every(Number.isFinite) &&
        (i === 0 || one[0] >= json.positions[i - 1][0]));
    if (!isSound) throw new Error("the path's positions are damaged: expected lists of ascending seconds and indices");
    return new RecordedPath(parameters, json.positions);
  }

  /**
   * Returns a closed curve through all parameters, to play without a recorded path. `sizes` has the number of samples
   * along each parameter.
   */
  static tour(parameters, sizes) {
    const seconds = 24;
    const positions = Array.from({ length: seconds * 20 + 1 }, (_, i) => {
      const turn = 2 * Math.PI * i / (seconds * 20);
      return [i / 20, ...sizes.map((size, d) => 0.5 * (size - 1) * (1 - Math.cos(turn * (d + 1))))];
    });
    return new RecordedPath(parameters, positions);
  }

  get seconds() { return this.positions.length > 0 ? this.positions.at(-1)[0] - this.positions[0][0] : 0; }

  add(seconds, at) {
    const last = this.positions.at(-1);
    if (this.positions.length >= POSITIONS_MAX || (last !== undefined && seconds - last[0] < INTERVAL_S)) return;
    this.positions.push([seconds, ...at].map((one) => Number(one.toFixed(4))));
  }

  /** Returns the interpolated position `seconds` after the first one. The path starts again after its end. */
  at(seconds) {
    const [first] = this.positions;
    const time = first[0] + (this.seconds > 0 ? seconds % this.seconds : 0);
    let next = this.positions.findIndex(([t]) => t > time);
    if (next < 1) next = next === 0 ? 1 : this.positions.length - 1;
    const [from, to] = [this.positions[next - 1], this.positions[next]];
    const share = to[0] > from[0] ? (time - from[0]) / (to[0] - from[0]) : 0;
    return from.slice(1).map((one, d) => one + share * (to[d + 1] - one));
  }

  text() {
    return JSON.stringify({ multumPath: 1, parameters: this.parameters, positions: this.positions });
  }
}
