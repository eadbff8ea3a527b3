// A scene in addresses: by its id, in which those of families have a slash.

export const scenePath = (scene: { id: string } | string): string =>
  `/v1/scenes/${encodeURIComponent(typeof scene === "string" ? scene : scene.id)}`;
export const scenePage = (scene: { id: string } | string): string =>
  `/scenes/${encodeURIComponent(typeof scene === "string" ? scene : scene.id)}`;
