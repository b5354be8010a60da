// SPDX-License-Identifier: Apache-2.0
// Makes the controls of the position. These are a slider for each parameter, a pad for the first two parameters, and
// the picture itself, which turns when the user drags it.
import { cameraParts, isEqual } from "./matrices.js";

const STEP = 0.05; // step of a slider's arrow keys, as a share of the distance between samples
const TURN_SHARE = 0.75; // share of the parameter's range that a drag across the whole picture covers

const node = (name, attributes = {}, ...children) => {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
};

/** Finds the parameters that move the camera, and the sign by which the scene follows a drag to the right. */
export function viewAxes(description) {
  const { samples, sizes } = description;
  const zero = sizes.map(() => 0);
  const axes = [];
  sizes.forEach((size, d) => {
    const [first, last] = [zero, zero.with(d, size - 1)].map((at) => samples[description.sampleAt(at)].worldToClip);
    if (size < 2 || isEqual(first, last)) return;
    const [from, to] = [first, last].map(cameraParts);
    let sign = 1;
    if (from !== null && to !== null) {
      const moved = to.eye.map((one, i) => one - from.eye[i]);
      sign = moved.reduce((sum, one, i) => sum + one * from.right[i], 0) > 0 ? -1 : 1;
    }
    axes.push({ d, sign });
  });
  return axes;
}

export class ParameterControls {
  /** `move(at)` is called with a new position. */
  constructor({ sliders, pad, stage, description, move }) {
    Object.assign(this, { pad, stage, description, move, position: description.sizes.map(() => 0) });
    this.makeSliders(sliders);
    this.hasPad = description.sizes.filter((size) => size > 1).length >= 2;
    this.padAxes = description.sizes.map((size, d) => d).filter((d) => description.sizes[d] > 1).slice(0, 2);
    pad.hidden = !this.hasPad;
    if (this.hasPad) this.makePad();
    this.makeDrag();
  }

  change(d, value) {
    const most = this.description.sizes[d] - 1;
    this.move(this.position.with(d, Math.min(most, Math.max(0, value))));
  }

  makeSliders(box) {
    this.sliders = this.description.parameters.map((name, d) => {
      const most = this.description.sizes[d] - 1;
      const input = node("input", { type: "range", id: `parameter-${d}`, min: 0, max: most, step: STEP, value: 0 });
      const output = node("output", { for: `parameter-${d}` }, "0");
      input.disabled = most === 0;
      input.addEventListener("input", () => this.change(d, Number(input.value)));
      box.append(node("div", { class: "slider" }, node("label", { for: `parameter-${d}` }, name), input, output));
      return { input, output };
    });
  }

  makePad() {
    const { pad, description } = this;
    const [across, up] = this.padAxes;
    const [acrossName, upName] = this.padAxes.map((d) => description.parameters[d]);
    pad.setAttribute("aria-label", `Pad: left and right ${acrossName}, up and down ${upName}; arrow keys move`);
    this.dot = node("span", { class: "dot" });
    pad.append(this.dot, node("span", { class: "across", "aria-hidden": "true" }, `${acrossName} \u2192`),
      node("span", { class: "up", "aria-hidden": "true" }, `${upName} \u2191`));
    const place = (event) => {
      const box = pad.getBoundingClientRect();
      const x = (event.clientX - box.left) / box.width;
      const y = 1 - (event.clientY - box.top) / box.height;
      const clamp = (value) => Math.min(1, Math.max(0, value));
      this.move(this.position.with(across, clamp(x) * (description.sizes[across] - 1))
        .with(up, clamp(y) * (description.sizes[up] - 1)));
    };
    pad.addEventListener("pointerdown", (event) => {
      pad.setPointerCapture(event.pointerId);
      place(event);
    });
    pad.addEventListener("pointermove", (event) => { if (pad.hasPointerCapture(event.pointerId)) place(event); });
    pad.addEventListener("keydown", (event) => this.arrow(event, across, up, 1));
  }

  makeDrag() {
    const { stage, description } = this;
    const axes = viewAxes(description);
    const others = this.padAxes.filter((d) => !axes.some((axis) => axis.d === d)).map((d) => ({ d, sign: 1 }));
    const [across, down] = [...axes, ...others, null, null];
    Object.assign(this, { across, down });
    let from = null;
    stage.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || event.target.closest("button")) return;
      stage.setPointerCapture(event.pointerId);
      from = { id: event.pointerId, x: event.clientX, y: event.clientY, position: this.position };
    });
    stage.addEventListener("pointermove", (event) => {
      if (from?.id !== event.pointerId) return;
      const box = stage.getBoundingClientRect();
      let { position } = from;
      const turn = (axis, share) => {
        if (axis === null) return;
        const most = description.sizes[axis.d] - 1;
        const value = position[axis.d] + axis.sign * share / TURN_SHARE * most;
        position = position.with(axis.d, Math.min(most, Math.max(0, value)));
      };
      turn(across, (event.clientX - from.x) / box.width);
      turn(down, (from.y - event.clientY) / box.height);
      this.move(position);
    });
    const end = (event) => { if (from?.id === event.pointerId) from = null; };
    stage.addEventListener("pointerup", end);
    stage.addEventListener("pointercancel", end);
    stage.addEventListener("keydown", (event) =>
      this.arrow(event, across?.d ?? 0, down?.d ?? null, across?.sign === -1 ? -1 : 1));
  }

  /** Moves by arrow keys: a quarter of a sample, or with Shift to the next sample. */
  arrow(event, across, up, sign) {
    const steps = { ArrowLeft: [across, -sign], ArrowRight: [across, sign], ArrowUp: [up, 1], ArrowDown: [up, -1] };
    const [d, step] = steps[event.key] ?? [null, 0];
    if (d === null || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    const whole = step > 0 ? Math.floor(this.position[d] + 1) : Math.ceil(this.position[d] - 1);
    this.change(d, event.shiftKey ? whole : this.position[d] + step / 4);
  }

  show(position) {
    this.position = position;
    this.sliders.forEach(({ input, output }, d) => {
      if (Math.abs(Number(input.value) - position[d]) > STEP || position[d] === 0) input.value = position[d];
      output.textContent = position[d].toFixed(2);
      input.setAttribute("aria-valuetext", `${position[d].toFixed(2)} of ${this.description.sizes[d] - 1}`);
    });
    if (!this.hasPad) return;
    const [x, y] = this.padAxes.map((d) => position[d] / (this.description.sizes[d] - 1));
    this.dot.style.left = `${100 * x}%`;
    this.dot.style.top = `${100 * (1 - y)}%`;
  }
}
