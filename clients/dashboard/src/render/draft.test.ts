import { describe, expect, it } from "vitest";

import type { JobRequest, Scene } from "../api/types";
import { aspectOfCamera, cameraChoice, faultsWithin, inShapeOfCamera, kFirstRequest, labelsOf, labelsText, newKey, parseRequest, requestOfQuery, shownBy, withInner, withMember } from "./draft";

describe("a request being written", () => {
  it("starts with what the address asks for", () => {
    expect(requestOfQuery({}, null)).toEqual(kFirstRequest);
    expect(requestOfQuery({ scene: "keyhole", method: "photon_mapping", width: "64", height: "x" }, { name: "side" })).toEqual({
      scene: "keyhole", camera: { name: "side" }, image: { width: 64, height: 512 }, method: { name: "photon_mapping" }, stop: { passes: 64 },
    });
  });
  it("has the shape that its camera asks for, and keeps it with another camera", () => {
    const camera = (name: string, aspect: number | null) => ({ name, aspect, yfov: 1, look_at: null });
    const scenes = [{ id: "room", name: "room", cameras: [camera("wide", 2.35), camera("any", null)] } as unknown as Scene];
    expect(requestOfQuery({ scene: "room" }, null, scenes).image).toEqual({ width: 784, height: 334 });
    expect(requestOfQuery({ scene: "room" }, { name: "any" }, scenes).image).toEqual({ width: 512, height: 512 });
    expect(requestOfQuery({ scene: "room", width: "64", height: "48" }, null, scenes).image).toEqual({ width: 64, height: 48 });
    const own = { ...kFirstRequest, scene: "room", camera: { look_at: { eye: [0, 0, 1], target: [0, 0, 0] } } } as JobRequest;
    expect(aspectOfCamera(own, scenes)).toBeNull();
    expect(inShapeOfCamera(own, scenes)).toBe(own);
    const shaped = inShapeOfCamera({ ...kFirstRequest, scene: "room" }, scenes);
    expect(inShapeOfCamera(shaped, scenes)).toBe(shaped);
  });
  it("says how its picture is to be shown, where it comes from a view", () => {
    expect(shownBy({ exposure: "-1.5", curve: "filmic" })).toEqual({ exposure: "-1.5", curve: "filmic" });
    expect(shownBy({ exposure: "0", curve: "odd" })).toEqual({ exposure: "0", curve: null });
    expect([shownBy({}), shownBy({ exposure: "much" })]).toEqual([null, null]);
  });
  it("starts at the moment the address asks for", () => {
    expect(requestOfQuery({ animation: "walk", time: "1.5", shutter: "0.02" }, null)).toEqual({ ...kFirstRequest, animation: "walk", time: 1.5, shutter: 0.02 });
    expect(requestOfQuery({ animation: "0", time: "0", shutter: "x" }, null)).toEqual({ ...kFirstRequest, animation: 0 });
  });
  it("leaves out what says nothing", () => {
    const named = withMember(kFirstRequest, "labels", { a: "b" });
    expect(named.labels).toEqual({ a: "b" });
    expect(withMember(named, "labels", {})).toEqual(kFirstRequest);
    const lens = withInner(kFirstRequest, "camera", { name: "side", aperture: 0.1 });
    expect(lens.camera).toEqual({ name: "side", aperture: 0.1 });
    expect(withInner(lens, "camera", { aperture: null, name: null })).toEqual(kFirstRequest);
  });
  it("places faults at the part they belong to", () => {
    const faults = [
      { pointer: "/method/parameters/photons", detail: "a" },
      { pointer: "/methods", detail: "b" },
      { pointer: "/method", detail: "c" },
    ];
    expect(faultsWithin(faults, "/method")).toEqual([{ pointer: "/parameters/photons", detail: "a" }, { pointer: "", detail: "c" }]);
  });
  it("is read from text, and says what it lacks", () => {
    expect(parseRequest(JSON.stringify(kFirstRequest)).request).toEqual(kFirstRequest);
    expect(parseRequest("{").fault).toContain("no JSON");
    expect(parseRequest("[]").fault).toContain("object");
    expect(parseRequest('{"scene":"x","image":{},"method":[],"stop":{}}').fault).toContain("method");
    expect(parseRequest('{"image":{},"method":{},"stop":{}}').fault).toContain("scene");
  });
  it("has labels a line each", () => {
    expect(labelsOf(" study = x=1 \n\nalone")).toEqual({ study: "x=1", alone: "" });
    expect(labelsText({ study: "x", b: "" })).toBe("study=x\nb=");
  });
  it("knows its camera", () => {
    const cameras = [{ name: "front", yfov: 1, aspect: null, look_at: null }];
    expect(cameraChoice(kFirstRequest, cameras)).toBe("front");
    expect(cameraChoice({ ...kFirstRequest, camera: { look_at: { eye: [0, 0, 1], target: [0, 0, 0] } } }, cameras)).toBe("own");
    expect(cameraChoice({ ...kFirstRequest, camera: { name: "side" } }, cameras)).toBe("side");
  });
  it("is submitted under a key of its own", () => {
    expect(newKey()).toMatch(/^dashboard-[0-9a-f]{32}$/);
    expect(newKey()).not.toBe(newKey());
  });
});
