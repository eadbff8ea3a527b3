// One sequence's frame at the time that all players share.

import type { Sequence, SequenceFrame } from "../api/types";
import { plainName, sizeText } from "../ui/format";
import { sceneName } from "../ui/scene_names";
import { StateMark } from "../ui/state";
import { frameAt } from "./clock";
import { useFramePictures } from "./frame_pictures";
import { type HeldPictures, kMostPictures } from "./held_pictures";

const secondsOf = (time: number) => `${time.toFixed(3)} s`;

function whyMissing(frame: SequenceFrame, pictures: HeldPictures): string {
  if (frame.state !== "succeeded") return `Frame ${frame.frame} is ${frame.state}`;
  if (pictures.isGivenUp(frame.id)) return "Its picture cannot be fetched: open the frame by its number";
  if (pictures.isLeftOut(frame.id)) return `A page plays ${kMostPictures} frames: open this one by its number`;
  return "Fetching the picture …";
}

export function Player({ sequence, seconds }: { sequence: Sequence; seconds: number }) {
  const pictures = useFramePictures(sequence.frames);
  const frame = sequence.frames[frameAt(sequence.frames, seconds)];
  if (!frame) return <p class="empty">It has no frames any more.</p>;
  const url = pictures.urls.get(frame.id);
  const { image } = sequence.request;
  return (
    <figure class="sequence-player">
      <span class="sequence-frame" style={{ aspectRatio: `${image.width} / ${image.height}` }}>
        {url ? <img src={url} alt={`Frame ${frame.frame} of ${sequence.id}`} /> : <span class="muted">{whyMissing(frame, pictures)}</span>}
      </span>
      <figcaption class="row small">
        <strong>{sequence.id}</strong>
        <span>
          frame <a href={`/jobs/${frame.id}`}>{frame.frame}</a> of {sequence.frames.length}, {secondsOf(frame.time)}
        </span>
        <StateMark state={frame.state} />
        <span class="muted">
          {sceneName(sequence.request.scene)} · {plainName(sequence.request.method.name)} · {sizeText(image)}
        </span>
      </figcaption>
    </figure>
  );
}
