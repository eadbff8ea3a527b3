import { describe, expect, it } from "vitest";

import { PixelStore, type Wanted } from "./pixel_store";
import { pixelImage, type Fetched } from "./pixels";

const fetched = (value: number): Fetched => ({ image: pixelImage(1, 1, 1, new Float32Array([value])), flipMean: null });
const settled = () => new Promise((done) => setTimeout(done));

/** A daemon that answers when told. */
class Answers {
  asked: string[] = [];
  private open = new Map<string, (result: Fetched | null | Error) => void>();
  wanted(key: string, version = 0): Wanted {
    return {
      key,
      version,
      fetch: (signal) =>
        new Promise((done, fail) => {
          this.asked.push(`${key}@${version}`);
          this.open.set(key, (result) => (result instanceof Error ? fail(result) : done(result)));
          signal.addEventListener("abort", () => fail(new DOMException("", "AbortError")));
        }),
    };
  }
  async give(key: string, result: Fetched | null | Error): Promise<void> {
    this.open.get(key)!(result);
    await settled();
  }
}

describe("pixels that are held", () => {
  it("are fetched three at a time, the first ones first", async () => {
    const answers = new Answers();
    const store = new PixelStore();
    store.want(["a", "b", "c", "d"].map((key) => answers.wanted(key)));
    expect(answers.asked).toEqual(["a@0", "b@0", "c@0"]);
    await answers.give("b", fetched(2));
    expect(answers.asked.at(-1)).toBe("d@0");
    expect(store.entries.value.get("b")).toMatchObject({ loading: false, version: 0, failure: null });
    expect(store.entries.value.get("a")).toMatchObject({ loading: true, image: null });
  });
  it("stay while a newer version comes", async () => {
    const answers = new Answers();
    const store = new PixelStore();
    store.want([answers.wanted("a")]);
    await answers.give("a", fetched(1));
    store.want([answers.wanted("a", 1)]);
    expect(store.entries.value.get("a")).toMatchObject({ loading: true, version: 0 });
    expect(store.entries.value.get("a")!.image!.data[0]).toBe(1);
    await answers.give("a", fetched(5));
    expect(store.entries.value.get("a")!.image!.data[0]).toBe(5);
    store.want([answers.wanted("a", 1)]);
    expect(answers.asked).toEqual(["a@0", "a@1"]);
  });
  it("say why there are none", async () => {
    const answers = new Answers();
    const store = new PixelStore();
    store.want([answers.wanted("a"), answers.wanted("b")]);
    await answers.give("a", new Error("no such layer"));
    await answers.give("b", null);
    expect(store.entries.value.get("a")!.failure!.message).toBe("no such layer");
    expect(store.entries.value.get("b")).toMatchObject({ waiting: true, failure: null });
  });
  it("are not waited for when nobody wants them any more, and asked for again when somebody does", async () => {
    const answers = new Answers();
    const store = new PixelStore();
    store.want([answers.wanted("a")]);
    store.want([answers.wanted("b")]);
    await settled();
    store.want([answers.wanted("a")]);
    await settled();
    expect(answers.asked).toEqual(["a@0", "b@0", "a@0"]);
    await answers.give("a", fetched(3));
    expect(store.entries.value.get("a")!.image!.data[0]).toBe(3);
  });
});
