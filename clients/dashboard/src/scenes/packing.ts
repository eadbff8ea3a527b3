// What dropped files are to the daemon: each .glb and each .zip a scene, and a .gltf one with all the files beside it.

export interface DroppedFile {
  /** Where it lies in what was dropped: "lamp/textures/wood.png". */
  path: string;
  file: File;
}

export interface Package {
  /** What the scene is called. */
  name: string;
  bytes: number;
  mediaType: "model/gltf-binary" | "application/zip" | "multipart/form-data";
  files: DroppedFile[];
}

export interface Packing {
  packages: Package[];
  /** Why some of the files are none. */
  faults: string[];
}

const endsWith = (path: string, ending: string) => path.toLowerCase().endsWith(ending);
const lastPart = (path: string) => path.slice(path.lastIndexOf("/") + 1);
const folderOf = (path: string) => path.slice(0, Math.max(0, path.lastIndexOf("/")));
const bytesOf = (files: DroppedFile[]) => files.reduce((sum, { file }) => sum + file.size, 0);

/** The file's name without its ending; of one that is called as any other, the folder's. */
function nameOf(path: string): string {
  const own = lastPart(path).replace(/\.[^.]*$/, "");
  const folder = lastPart(folderOf(path));
  return /^(scene|model|index|untitled)$/i.test(own) && folder ? folder : own;
}

/** Of system files that nobody means to send. */
const isClutter = (path: string) => /(^|\/)(\.[^/]*|__MACOSX\/.*|Thumbs\.db|desktop\.ini)$/.test(path);

export function packed(dropped: DroppedFile[]): Packing {
  const files = dropped.filter(({ path }) => !isClutter(path));
  const packages: Package[] = [];
  const faults: string[] = [];
  for (const [ending, mediaType] of [[".glb", "model/gltf-binary"], [".zip", "application/zip"]] as const)
    for (const one of files.filter(({ path }) => endsWith(path, ending)))
      packages.push({ name: nameOf(one.path), bytes: one.file.size, mediaType, files: [one] });

  const loose = files.filter(({ path }) => !endsWith(path, ".glb") && !endsWith(path, ".zip"));
  const mains = loose.filter(({ path }) => endsWith(path, ".gltf"));
  if (mains.length === 1) packages.push({ name: nameOf(mains[0]!.path), bytes: bytesOf(loose), mediaType: "multipart/form-data", files: loose });
  else if (mains.length > 1)
    faults.push(`${mains.length} .gltf files, ${mains.map(({ path }) => lastPart(path)).join(", ")}: drop one with its own files at a time`);
  // Pictures and the like beside a .glb come with its folder and are in it; alone they are a mistake to be told of.
  else if (packages.length === 0)
    faults.push(
      loose.length === 0
        ? "There is no file in what was dropped."
        : `${loose.length === 1 ? lastPart(loose[0]!.path) : `None of ${loose.length} files`} is ${loose.length === 1 ? "not " : ""}a scene: those are .glb, .zip, or .gltf with the files it names`,
    );
  return { packages, faults };
}

/** The body that carries it: the file itself, or a form with each file under its path. */
export function bodyOf({ mediaType, files }: Package): { body: Blob | FormData; mediaType: string | null } {
  if (mediaType !== "multipart/form-data") return { body: files[0]!.file, mediaType };
  const form = new FormData();
  for (const { path, file } of files) form.append("file", file, path);
  return { body: form, mediaType: null }; // the browser adds the boundary
}
