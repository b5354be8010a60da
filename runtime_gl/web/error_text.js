// SPDX-License-Identifier: Apache-2.0
// What pages say of whatever was thrown, rejected or reported by an event.

const textOf = (value) => (typeof value === "string" && value.trim() !== "" ? value.trim() : null);

/**
 * Its message. Not all that is thrown is an Error with one: scripts throw texts and numbers, promises are rejected with
 * nothing, workers that cannot be loaded send an event without a message. `otherwise` is said of these, with the kind
 * of error where it has one.
 */
export function errorText(thrown, otherwise = "the browser gives no reason") {
  const inner = thrown?.error ?? thrown?.reason; // of an ErrorEvent, of a rejection
  const found = textOf(thrown) ?? textOf(thrown?.message) ?? textOf(inner) ?? textOf(inner?.message);
  if (found !== null) return found;
  const name = textOf(thrown?.name) ?? textOf(inner?.name);
  return name === null || name === "Error" ? otherwise : `${otherwise} (${name})`;
}

/** Hands `say` the text of every error that nobody else takes. */
export function sayUncaughtErrors(say) {
  for (const kind of ["error", "unhandledrejection"])
    addEventListener(kind, (event) => {
      const text = errorText(event);
      // What a resize observer changed is drawn a frame later, which is no failure.
      if (!text.startsWith("ResizeObserver loop")) say(`Something in this page failed: ${text}. Reload the page.`);
    });
}
