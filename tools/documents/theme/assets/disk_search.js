// SPDX-License-Identifier: Apache-2.0
// Makes the search work on pages that are opened from a disk. The theme's search reads JSON and starts a worker, which
// browsers do not allow on such pages. Therefore the index is loaded as a script, and the worker's script runs in a
// hidden frame.
if (location.protocol === "file:") {
  const base = new URL("..", document.currentScript.src);

  /** A Worker whose script runs in a frame of this page. */
  class FrameWorker extends EventTarget {
    #frame = document.createElement("iframe");
    #waiting = []; // messages that were sent before the script was loaded

    constructor(url) {
      super();
      this.#frame.hidden = true;
      document.body.append(this.#frame);
      const inside = this.#frame.contentWindow;
      // The script answers with postMessage(), which would send the message to the frame itself.
      inside.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
      const script = inside.document.createElement("script");
      script.src = new URL(url, location.href);
      script.onload = () => {
        const waiting = this.#waiting;
        this.#waiting = undefined;
        waiting.forEach((data) => this.postMessage(data));
      };
      inside.document.body.append(script);
    }

    postMessage(data) {
      if (this.#waiting !== undefined) this.#waiting.push(data);
      else this.#frame.contentWindow.dispatchEvent(new MessageEvent("message", { data }));
    }

    terminate() {
      this.#frame.remove();
    }
  }

  window.Worker = FrameWorker;
  window.__search = {
    index: new Promise((resolve) => {
      window.multumSearchIndex = resolve;
      addEventListener("DOMContentLoaded", () => {
        const script = document.createElement("script");
        script.src = new URL("search/search_index.js", base);
        document.head.append(script);
      });
    }),
  };
}
