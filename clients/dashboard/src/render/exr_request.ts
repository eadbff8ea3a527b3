// The request that an image of photond carries in its header (docs: the EXR's attribute photond:request), so that the file
// alone repeats its job. An EXR's header is not compressed, and comes first.

import type { JobRequest } from "../api/types";
import { parseRequest } from "./draft";

/** Of a file's first bytes, so many hold any header that photond writes. */
export const kHeaderBytes = 64 * 1024;

const kMagic = 0x01312f76;
const kRequest = "photond:request";

/** The string attributes of an EXR's header, by name; null where the bytes are no EXR's. */
export function stringAttributes(bytes: Uint8Array): Map<string, string> | null {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (bytes.length < 8 || view.getUint32(0, true) !== kMagic) return null;
  const text = new TextDecoder();
  const found = new Map<string, string>();
  let at = 8;
  const name = () => {
    const end = bytes.indexOf(0, at);
    const read = end < 0 ? "" : text.decode(bytes.subarray(at, end));
    at = end < 0 ? bytes.length : end + 1;
    return read;
  };
  for (;;) {
    const attribute = name();
    const type = name();
    if (!attribute || at + 4 > bytes.length) return found; // the header's end, or that of what was read of it
    const size = view.getInt32(at, true);
    at += 4;
    if (size < 0 || at + size > bytes.length) return found;
    if (type === "string") found.set(attribute, text.decode(bytes.subarray(at, at + size)));
    at += size;
  }
}

/** The request in an EXR's first bytes. Throws where there is none, with the reason. */
export function requestIn(bytes: Uint8Array): JobRequest {
  const attributes = stringAttributes(bytes);
  if (!attributes) throw new Error("it is no EXR");
  const text = attributes.get(kRequest);
  if (text === undefined) throw new Error(`it carries no ${kRequest}: another program wrote it, or an older photond`);
  const { request, fault } = parseRequest(text);
  if (!request) throw new Error(`its ${kRequest} cannot be read. ${fault}`);
  return request;
}
