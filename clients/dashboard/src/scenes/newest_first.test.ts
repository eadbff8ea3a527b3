import { expect, it } from "vitest";

import { NewestFirst, type Outcome } from "./newest_first";

function held() {
  const asked: { wish: number; answer: (text: string) => void; fail: (failure: Error) => void }[] = [];
  const told: Outcome<number, string>[] = [];
  const queue = new NewestFirst<number, string>(
    (wish) => new Promise((answer, fail) => asked.push({ wish, answer, fail })),
    (outcome) => told.push(outcome),
  );
  return { asked, told, queue };
}
const settled = () => new Promise((done) => setTimeout(done));

it("asks for one at a time, and then for the newest alone", async () => {
  const { asked, told, queue } = held();
  for (const wish of [1, 2, 3, 4]) queue.want(wish);
  expect(asked.map(({ wish }) => wish)).toEqual([1]);
  asked[0]!.answer("one");
  await settled();
  expect(asked.map(({ wish }) => wish)).toEqual([1, 4]);
  asked[1]!.answer("four");
  await settled();
  expect(told.map(({ answer }) => answer)).toEqual(["one", "four"]);
  expect(queue.waits).toBe(false);
});

it("goes on after a failure", async () => {
  const { asked, told, queue } = held();
  queue.want(1);
  queue.want(2);
  asked[0]!.fail(new Error("no"));
  await settled();
  asked[1]!.answer("two");
  await settled();
  expect(told[0]!.failure!.message).toBe("no");
  expect(told[1]!.answer).toBe("two");
});

it("takes a wish made while it tells of the last, and still asks for one at a time", async () => {
  const wishes: number[] = [];
  let under = 0;
  const queue: NewestFirst<number, number> = new NewestFirst(
    async (wish) => {
      wishes.push(wish);
      expect(++under).toBe(1);
      await settled();
      --under;
      return wish;
    },
    ({ wish }) => {
      if (wish < 4) queue.want(wish + 1);
    },
  );
  queue.want(1);
  await new Promise((done) => setTimeout(done, 50));
  expect(wishes).toEqual([1, 2, 3, 4]);
});

it("tells nothing once stopped", async () => {
  const { asked, told, queue } = held();
  queue.want(1);
  queue.want(2);
  queue.stop();
  asked[0]!.answer("one");
  await settled();
  expect([told.length, asked.length]).toEqual([0, 1]);
});
