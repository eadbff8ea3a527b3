// What stands between a browser and a daemon, hands everything on, and says what is under way; pictures can be held.

import { createServer, request } from "node:http";

import { after } from "./suite.mjs";

export class CountingProxy {
  /** Requests that are not answered to their end yet, first come first. */
  open = [];
  /** The most pictures that were under way at once. */
  mostPictures = 0;
  /** All that has come, "METHOD path", in order. */
  asked = [];
  #times = [];
  #held = null;

  static async before(daemon) {
    const proxy = new CountingProxy();
    const server = createServer((from, to) => void proxy.#handOn(daemon, from, to));
    await new Promise((done) => server.listen(0, "127.0.0.1", done));
    proxy.url = `http://127.0.0.1:${server.address().port}`;
    after(() => {
      server.closeAllConnections?.();
      server.close();
    });
    return proxy;
  }

  /** From now on a picture is answered once release() is called. */
  hold() {
    const held = {};
    held.over = new Promise((release) => (held.release = release));
    this.#held = held;
  }

  release() {
    this.#held?.release();
    this.#held = null;
  }

  openOf(pattern) {
    return this.open.filter((line) => pattern.test(line));
  }

  /** When the first request that begins so has come, by Date.now(). */
  cameAt(begin) {
    return this.#times[this.asked.findIndex((line) => line.startsWith(begin))];
  }

  async #handOn(daemon, from, to) {
    const line = `${from.method} ${from.url}`;
    this.asked.push(line);
    this.#times.push(Date.now());
    this.open.push(line);
    this.mostPictures = Math.max(this.mostPictures, this.openOf(/\.png/).length);
    to.on("close", () => this.open.splice(this.open.indexOf(line), 1));
    if (this.#held && line.includes(".png")) await this.#held.over;
    const on = request(daemon.url + from.url, { method: from.method, headers: from.headers }, (answer) => {
      to.writeHead(answer.statusCode, answer.headers);
      answer.pipe(to);
    });
    on.on("error", () => to.destroy());
    to.on("close", () => on.destroy());
    from.pipe(on);
  }
}
