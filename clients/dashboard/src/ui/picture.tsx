// A picture of the daemon in a frame that keeps its place: asked for when it comes into view, and never a blank.

import { useEffect, useRef, useState } from "preact/hooks";

import { type BlobImage, useImage } from "./remote";
import "./picture.css";

/** Whether the element has come near the view; once it has, that stays. */
export function useSeen<T extends Element>(): [boolean, (element: T | null) => void] {
  const [seen, setSeen] = useState(false);
  const watcher = useRef<IntersectionObserver | null>(null);
  const watch = useRef((element: T | null) => {
    watcher.current?.disconnect();
    if (!element) return;
    watcher.current = new IntersectionObserver(
      (entries) => {
        if (!entries.some((entry) => entry.isIntersecting)) return;
        watcher.current?.disconnect();
        setSeen(true);
      },
      { rootMargin: "200px" },
    );
    watcher.current.observe(element);
  });
  useEffect(() => () => watcher.current?.disconnect(), []);
  return [seen, watch.current];
}

interface FrameProps {
  image: BlobImage;
  alt: string;
  /** Width over height of the frame; the picture is fitted into it. */
  ratio?: number;
  /** Said while there is no picture. */
  waiting?: string;
}

/** The frame with the picture, or why there is none. */
export function PictureFrame({ image, alt, ratio = 1, waiting = "" }: FrameProps) {
  return (
    <span class={`picture-frame${image.url || image.failure ? "" : " waits"}`} style={{ aspectRatio: String(ratio) }}>
      {image.url ? (
        <img src={image.url} alt={alt} />
      ) : image.failure ? (
        <span class="picture-none">No picture: {image.failure.message}</span>
      ) : (
        <span class="picture-none">{waiting}</span>
      )}
    </span>
  );
}

interface PictureProps extends Omit<FrameProps, "image"> {
  path: string | null;
  version?: string | number;
}

/** The picture at a path, asked for when the frame comes into view. */
export function Picture({ path, version, ...frame }: PictureProps) {
  const [seen, watch] = useSeen<HTMLSpanElement>();
  const image = useImage(seen ? path : null, version);
  return (
    <span ref={watch} class="picture-holder">
      <PictureFrame image={image} {...frame} />
    </span>
  );
}
