// Image files by hand: given to the daemon, which then has them as image:ID.

import { upload } from "../api/client";
import type { ImageInfo } from "../api/types";
import { rememberName } from "./sources";

const kTypes: Record<string, string> = { exr: "image/x-exr", hdr: "image/vnd.radiance", pic: "image/vnd.radiance", rgbe: "image/vnd.radiance" };
export const kAccepted = ".exr,.hdr,.pic,.rgbe";

/** The image's source. */
export async function uploadImage(file: File): Promise<string> {
  const type = kTypes[file.name.slice(file.name.lastIndexOf(".") + 1).toLowerCase()];
  if (!type) throw new Error(`${file.name}: images are compared in linear light; give an OpenEXR (.exr) or Radiance (.hdr) file`);
  try {
    const image = await upload<ImageInfo>("/v1/images", file, type);
    rememberName(image.id, file.name);
    return `image:${image.id}`;
  } catch (failure) {
    if (failure instanceof Error) failure.message = `${file.name}: ${failure.message}`;
    throw failure;
  }
}
