// SPDX-License-Identifier: Apache-2.0
// A static server on loopback for tests. It serves a folder, answers range requests, and serves copies of the folder in
// which single files are replaced or truncated.
import { readFile } from "node:fs/promises";
import http from "node:http";
import path from "node:path";

const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm",
  ".png": "image/png" };

export class RangeServer {
  /** `folder` is served at /. */
  static async start(folder) {
    const server = new RangeServer();
    Object.assign(server, { folder, copies: new Map(), requests: [] });
    server.http = http.createServer((request, response) => server.answer(request, response));
    await new Promise((resolve) => server.http.listen(0, "127.0.0.1", resolve));
    server.url = `http://127.0.0.1:${server.http.address().port}`;
    return server;
  }

  /**
   * Serves the folder `of` as /NAME/, with `files` instead of its own. `behave(file, count)` gets the number of earlier
   * requests of that file. It returns { cut: bytes after which the connection ends, noRanges, status }.
   */
  copy(name, of, files = {}, behave = () => ({})) {
    this.copies.set(name, { of, files, behave, counts: new Map() });
    return `${this.url}/${name}/`;
  }

  async content(name) {
    const [, first, rest] = /^\/([^/]+)\/(.*)$/.exec(name) ?? [null, null, name.slice(1)];
    const copy = this.copies.get(first);
    if (copy === undefined) return { bytes: await readFile(path.join(this.folder, name)), behaviour: {} };
    const file = rest === "" ? "index.html" : rest;
    const count = copy.counts.get(file) ?? 0;
    copy.counts.set(file, count + 1);
    return { bytes: copy.files[file] ?? await readFile(path.join(this.folder, copy.of, file)),
      behaviour: copy.behave(file, count) ?? {}, file };
  }

  async answer(request, response) {
    const name = decodeURIComponent(new URL(request.url, this.url).pathname);
    this.requests.push({ name, range: request.headers.range });
    try {
      const { bytes, behaviour, file } = await this.content(name);
      if (behaviour.status) {
        response.writeHead(behaviour.status);
        response.end();
        return;
      }
      const type = TYPES[path.extname(file ?? name)] ?? "application/octet-stream";
      const range = behaviour.noRanges ? null : /^bytes=(\d+)-(\d+)$/.exec(request.headers.range ?? "");
      const first = range ? Number(range[1]) : 0;
      const end = range ? Math.min(bytes.length, Number(range[2]) + 1) : bytes.length;
      if (first >= end && bytes.length > 0) {
        response.writeHead(416, { "Content-Range": `bytes */${bytes.length}` });
        response.end();
        return;
      }
      response.writeHead(range ? 206 : 200, { "Content-Type": type, "Content-Length": end - first,
        "Cache-Control": "no-store", ...(range && { "Content-Range": `bytes ${first}-${end - 1}/${bytes.length}` }) });
      const body = bytes.subarray(first, end);
      if (behaviour.cut === undefined) response.end(body);
      else response.write(body.subarray(0, behaviour.cut), () => setTimeout(() => response.destroy(), 50));
    } catch {
      response.writeHead(404);
      response.end();
    }
  }

  stop() {
    this.http.closeAllConnections();
    this.http.close();
  }
}
