// What is in a scene, in plain words, and what that asks of a method.

export interface Need {
  text: string;
  /** What it makes hard, or which methods are for it. */
  means?: string;
}

const kNeeds: Record<string, Need> = {
  diffuse: { text: "Matte surfaces" },
  delta: { text: "Mirrors or clear glass", means: "makes caustics, which photons find sooner than paths from the eye" },
  glossy: { text: "Blurred reflections", means: "needs a method that follows directions, not light on surfaces alone" },
  transmission: { text: "Surfaces that let light through" },
  solid_glass: { text: "Solid glass" },
  alpha: { text: "Cut-outs and see-through surfaces" },
  area_lights: { text: "Glowing surfaces" },
  punctual_lights: { text: "Points, spots or suns", means: "are found by sampling the lights alone" },
  environment: { text: "Light from all around" },
  base_color_textures: { text: "Coloured textures" },
  material_textures: { text: "Textures of roughness, metal or glass" },
  emission_textures: { text: "Glowing textures" },
  normal_maps: { text: "Normal maps" },
  vertex_colors: { text: "Colours at vertices" },
  unlit: { text: "Surfaces that no light changes" },
  instances: { text: "Meshes used more than once", means: "saves memory" },
};

/** What the scene has of them; a need without words here is told by its name. */
export const needsOf = (needs: Record<string, unknown> | null): Need[] => {
  const present = new Set(Object.entries(needs ?? {}).flatMap(([name, is]) => (is === true ? [name] : [])));
  const told = Object.keys(kNeeds).filter((name) => present.has(name));
  const others = [...present].filter((name) => !(name in kNeeds));
  return [...told.map((name) => kNeeds[name]!), ...others.map((name) => ({ text: name.replaceAll("_", " ") }))];
};
