// One sequence's frame at the time that all players share.

import type { Sequence } from "../api/types";
import { sizeText } from "../ui/format";
import { StateMark } from "../ui/state";
import { frameAt } from "./clock";
import { kMostPictures, useFramePictures } from "./frame_pictures";

const secondsOf = (time: number) => `${time.toFixed(3)} s`;

export function Player({ sequence, seconds }: { sequence: Sequence; seconds: number }) {
  const pictures = useFramePictures(sequence.frames);
  const frame = sequence.frames[frameAt(sequence.frames, seconds)];
  if (!frame) return <p class="empty">It has no frames any more.</p>;
  const url = pictures.get(frame.id);
  const missing =
    frame.state !== "succeeded" ? `Frame ${frame.frame} is ${frame.state}` : pictures.size >= kMostPictures ? `A page plays ${kMostPictures} frames: open this one by its number` : "Fetching the picture …";
  const { image } = sequence.request;
  return (
    <figure class="sequence-player">
      <span class="sequence-frame" style={{ aspectRatio: `${image.width} / ${image.height}` }}>
        {url ? <img src={url} alt={`Frame ${frame.frame} of ${sequence.id}`} /> : <span class="muted">{missing}</span>}
      </span>
      <figcaption class="row small">
        <strong>{sequence.id}</strong>
        <span>
          frame <a href={`/jobs/${frame.id}`}>{frame.frame}</a> of {sequence.frames.length}, {secondsOf(frame.time)}
        </span>
        <StateMark state={frame.state} />
        <span class="muted">
          {sequence.request.scene} · {sequence.request.method.name} · {sizeText(image)}
        </span>
      </figcaption>
    </figure>
  );
}
