import { describe, expect, it } from "vitest";

import { requestIn, stringAttributes } from "./exr_request";

const text = new TextEncoder();

/** An EXR's header with these attributes: name, type, value. */
function header(attributes: [string, string, Uint8Array][], magic = [0x76, 0x2f, 0x31, 0x01]): Uint8Array {
  const parts: Uint8Array[] = [Uint8Array.from([...magic, 2, 0, 0, 0])];
  for (const [name, type, value] of attributes)
    parts.push(text.encode(`${name}\0${type}\0`), new Uint8Array(Int32Array.of(value.length).buffer), Uint8Array.from(value));
  parts.push(Uint8Array.of(0), Uint8Array.of(9, 9, 9, 9)); // the end, and a table of offsets
  return Uint8Array.from(parts.flatMap((part) => [...part]));
}

const request = { scene: "cornell-box", image: { width: 4, height: 4 }, method: { name: "path_tracing" }, stop: { passes: 1 }, labels: { who: "Zoë" } };
const attribute = (value: string): [string, string, Uint8Array] => ["photond:request", "string", text.encode(value)];
const window: [string, string, Uint8Array] = ["dataWindow", "box2i", new Uint8Array(16)];

describe("the request of an EXR", () => {
  it("is read among other attributes", () => {
    const bytes = header([window, ["comment", "string", text.encode("x")], attribute(JSON.stringify(request)), window]);
    expect(requestIn(bytes)).toEqual(request);
    expect([...stringAttributes(bytes)!.keys()]).toEqual(["comment", "photond:request"]);
  });
  it("is said to be missing, cut off or no JSON", () => {
    expect(() => requestIn(header([window]))).toThrow("carries no photond:request");
    expect(() => requestIn(header([attribute(JSON.stringify(request))]).subarray(0, 60))).toThrow("carries no photond:request");
    expect(() => requestIn(header([attribute("{")]))).toThrow("no JSON");
    expect(() => requestIn(header([attribute('{"scene": "x"}')]))).toThrow("“image” is missing");
  });
  it("is looked for in EXRs only", () => {
    expect(() => requestIn(text.encode("#?RADIANCE\n"))).toThrow("no EXR");
    expect(() => requestIn(header([], [0x89, 0x50, 0x4e, 0x47]))).toThrow("no EXR");
    expect(() => requestIn(new Uint8Array())).toThrow("no EXR");
  });
});
