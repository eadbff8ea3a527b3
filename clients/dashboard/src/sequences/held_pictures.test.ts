import { afterEach, beforeEach, expect, test, vi } from "vitest";

import { HeldPictures, kMostPictures, kMostTries } from "./held_pictures";

const picture = new Blob(["png"]);
const atOnce = () => Promise.resolve();
const nothing = () => undefined;
let live: Set<string>;

beforeEach(() => {
  live = new Set();
  let made = 0;
  vi.spyOn(URL, "createObjectURL").mockImplementation(() => {
    const url = `blob:${made++}`;
    live.add(url);
    return url;
  });
  vi.spyOn(URL, "revokeObjectURL").mockImplementation((url) => void live.delete(url));
});
afterEach(() => vi.restoreAllMocks());

function fetched(held: HeldPictures, fetch = async (_id: string): Promise<Blob | null> => picture, signal = new AbortController().signal) {
  return held.fetchMissing(fetch, atOnce, nothing, signal);
}

test("pictures of frames that are listed no more are let go of, and fetched anew when they come back", async () => {
  const held = new HeldPictures();
  held.list(["J1", "J2", "J3"]);
  await fetched(held);
  expect([...held.urls.keys()]).toEqual(["J1", "J2", "J3"]);
  held.list(["J2"]);
  expect([...held.urls.keys()]).toEqual(["J2"]);
  expect(live.size).toBe(1);
  held.list(["J1", "J2"]);
  expect(held.missing()).toEqual(["J1"]);
  held.list([]);
  expect(live.size).toBe(0);
});

test("a page holds so many, whatever it held before", async () => {
  const held = new HeldPictures();
  const of = (sequence: string) => Array.from({ length: kMostPictures + 1 }, (_, frame) => `${sequence}${frame}`);
  for (const sequence of ["a", "b"]) {
    held.list(of(sequence));
    await fetched(held);
    expect(held.urls.size).toBe(kMostPictures);
    expect(live.size).toBe(kMostPictures);
    expect(held.isLeftOut(`${sequence}${kMostPictures - 1}`)).toBe(false);
    expect(held.isLeftOut(`${sequence}${kMostPictures}`)).toBe(true);
  }
});

test("a picture that fails is asked for again when the others are there, and given up after some tries", async () => {
  const held = new HeldPictures();
  held.list(["gone", "late", "good"]);
  const asked: string[] = [];
  await fetched(held, async (id) => {
    asked.push(id);
    if (id === "gone") throw new Error("404");
    return id === "late" && asked.length < 4 ? null : picture;
  });
  expect(asked).toEqual(["gone", "late", "good", "gone", "late", "gone"]);
  expect([...held.urls.keys()]).toEqual(["good", "late"]);
  expect(held.isGivenUp("gone")).toBe(true);
  expect(kMostTries).toBe(3);
  await fetched(held, async () => expect.fail("it was given up"));
});

test("what is fetched for a list that is past is dropped, and no failure of its", async () => {
  const held = new HeldPictures();
  const stop = new AbortController();
  held.list(["J1", "J2"]);
  await fetched(
    held,
    async () => {
      stop.abort();
      return null;
    },
    stop.signal,
  );
  expect(held.missing()).toEqual(["J1", "J2"]);
  expect(live.size).toBe(0);
});
