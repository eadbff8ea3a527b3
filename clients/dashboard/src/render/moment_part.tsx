// Which animation of the scene, and when in it.

import type { Fault, JobRequest, Scene } from "../api/types";
import { motionText } from "../scenes/motion_text";
import { numberText } from "../ui/format";
import { Labelled, NumberField } from "./fields";
import { animationOf, atRest, knownAnimation, roundTime, withAnimation, withMoment } from "./moment";
import { Panel } from "./panel";

interface Props {
  request: JobRequest;
  change: (request: JobRequest) => void;
  faults: Fault[];
  scene: Scene | undefined;
}

const kAtRest = "at rest";
const kUnknown = "unknown";

export function MomentPart({ request, change, faults, scene }: Props) {
  const motion = scene?.motion ?? [];
  const chosen = animationOf(request);
  const animation = knownAnimation(request, motion);
  const duration = animation?.duration_seconds ?? 0;
  const { time = 0 } = request;
  const shown = typeof time === "number" ? time : 0; // it may be text that is no number
  const choose = (value: string) => {
    const next = motion[Number(value)];
    change(next ? withAnimation(request, next, motion) : atRest(request));
  };
  return (
    <Panel title="Moment" note="of the scene's animation">
      <div class="fields">
        <Labelled label="Animation" id="render-animation" pointer="/animation" faults={faults} hint={animation ? motionText(animation) : undefined}>
          {(aria) => (
            <select {...aria} value={animation ? String(animation.index) : chosen === null ? kAtRest : kUnknown} onChange={(event) => choose(event.currentTarget.value)}>
              <option value={kAtRest}>none: as the file rests</option>
              {motion.map(({ index, name }) => (
                <option key={index} value={String(index)}>
                  {name || `animation ${index}`}
                </option>
              ))}
              {!animation && chosen !== null && <option value={kUnknown}>{typeof chosen === "number" ? `animation ${chosen}` : chosen}</option>}
            </select>
          )}
        </Labelled>
        {chosen !== null && (
          <NumberField
            label="Time"
            id="render-time"
            pointer="/time"
            faults={faults}
            value={time}
            unit="s"
            placeholder="0"
            hint={animation ? `0 to ${numberText(duration, 6)} s; before and after it nothing moves` : undefined}
            onValue={(value) => change(withMoment(request, "time", value))}
          />
        )}
      </div>
      {duration > 0 && (
        <input
          class="render-time"
          type="range"
          min={0}
          max={duration}
          step="any"
          value={shown}
          aria-label="Time in the animation"
          aria-valuetext={`${numberText(shown, 6)} s`}
          onInput={(event) => change(withMoment(request, "time", roundTime(Number(event.currentTarget.value), duration)))}
        />
      )}
    </Panel>
  );
}
