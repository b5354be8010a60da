// SPDX-License-Identifier: Apache-2.0
// Converts thrown, rejected or reported errors to text for the page.

const textOf = (value) => (typeof value === "string" && value.trim() !== "" ? value.trim() : null);

/**
 * Returns the message. Not everything thrown is an Error with a message: scripts throw texts and numbers, promises
 * reject with nothing, and workers that fail to load send an event without a message. For these, returns `otherwise`,
 * with the kind of error if it has one.
 */
export function errorText(thrown, otherwise = "the browser gives no reason") {
  const inner = thrown?.error ?? thrown?.reason; // error inside an ErrorEvent or a rejection
  const found = textOf(thrown) ?? textOf(thrown?.message) ?? textOf(inner) ?? textOf(inner?.message);
  if (found !== null) return found;
  const name = textOf(thrown?.name) ?? textOf(inner?.name);
  return name === null || name === "Error" ? otherwise : `${otherwise} (${name})`;
}

/** Passes the text of every unhandled error to `say`. */
export function sayUncaughtErrors(say) {
  for (const kind of ["error", "unhandledrejection"])
    addEventListener(kind, (event) => {
      const text = errorText(event);
      // The browser reports an error when changes by a resize observer are drawn one frame later, which is not a
      // failure.
      if (!text.startsWith("ResizeObserver loop")) say(`Something in this page failed: ${text}. Reload the page.`);
    });
}
