// The scenes that a form chooses among: those of the daemon's list, and any other that its request has named. Families of
// built-in scenes, such as those that move, are not in the list.

import { useEffect, useState } from "preact/hooks";

import type { Scene } from "../api/types";
import { scenePath } from "../scenes/scene_path";
import { useRemote } from "../ui/remote";

export const sceneNamed = (scenes: Scene[], wanted: string): Scene | undefined => scenes.find(({ id, name }) => id === wanted || name === wanted);

export function useScenes(listed: Scene[], wanted: string): Scene[] {
  const [others, setOthers] = useState<Scene[]>([]);
  const scenes = [...listed, ...others];
  const found = useRemote<Scene>(wanted === "" || sceneNamed(scenes, wanted) ? null : scenePath(wanted)).data;
  useEffect(() => {
    if (found) setOthers((old) => (sceneNamed(old, found.id) ? old : [...old, found]));
  }, [found]);
  return scenes;
}
