// SPDX-License-Identifier: Apache-2.0
// Draws after a short time even in background tabs, in which browsers draw no frames.

// The time to wait for a frame. A visible page gets its frame, perhaps late on a slow device. Drawing earlier would
// only fill the queue.
const HIDDEN_MS = 50;
const SHOWN_MS = 1000;

/** Calls `draw(now)` at the browser's next frame, or after a while if none comes. Returns a function that cancels. */
export function onNextFrame(draw) {
  let frame = 0;
  let timer = 0;
  const cancel = () => {
    cancelAnimationFrame(frame);
    clearTimeout(timer);
  };
  const once = (now) => {
    cancel();
    draw(now);
  };
  frame = requestAnimationFrame(once);
  timer = setTimeout(() => once(performance.now()), document.hidden ? HIDDEN_MS : SHOWN_MS);
  return cancel;
}

/**
 * Lets the page handle events. Does not use timers, which wait for a second, and later a minute, in background tabs.
 */
export const giveWay = () => new Promise((resolve) => {
  const { port1, port2 } = new MessageChannel();
  port1.onmessage = () => {
    port1.close();
    resolve();
  };
  port2.postMessage(null);
});
