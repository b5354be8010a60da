// SPDX-License-Identifier: Apache-2.0
// Draws on time, in pages that nobody looks at too: there are no frames in a background tab.

// How long a frame is waited for. Of a page that is shown it comes, late where the device is slow: what is drawn before
// it would only queue up.
const HIDDEN_MS = 50;
const SHOWN_MS = 1000;

/** Calls `draw(now)` with the browser's next frame, or a while later where there is none. Returns what cancels it. */
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

/** Lets the page answer events before work goes on: timers of background tabs wait for a second, and later a minute. */
export const giveWay = () => new Promise((resolve) => {
  const { port1, port2 } = new MessageChannel();
  port1.onmessage = () => {
    port1.close();
    resolve();
  };
  port2.postMessage(null);
});
