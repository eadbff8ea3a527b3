// A sequence's errors by frame against two others that are its references.

import { download } from "../api/client";
import type { Page, Sequence, SequenceErrors, SequenceFigure, SequenceSummary } from "../api/types";
import { useQuery } from "../app/url_state";
import { errorWithInterval } from "../ui/error_interval";
import { countText, kNone, numberText } from "../ui/format";
import { LiveChart } from "../ui/live_chart";
import { useRemote } from "../ui/remote";
import { sayFailure } from "../ui/toasts";

const kHeight = 150;

const kCharts = [
  { figure: "relative_mse", text: "Error", about: "relative mean squared error of each frame" },
  { figure: "flicker", text: "Flicker", about: "of the change from the frame before, what the scene itself does not change" },
  { figure: "change", text: "Motion", about: "change of the scene itself from the frame before" },
] as const;

/** Which may be below 0 and mean it. */
const signedText = ({ value, interval: [least, greatest] }: SequenceFigure) => `${numberText(value)} (${numberText(least)} to ${numberText(greatest)})`;
/** To the hundredth of a frame, which nobody sees. */
const lateText = (frames: number) => (Math.round(100 * frames) / 100 || 0).toFixed(2);

const figureText = (figure: SequenceFigure | null) => (figure ? errorWithInterval(figure.value, figure.interval) : kNone);

const sameOfBoth = ["scene", "animation", "from", "fps", "shutter", "camera", "camera_path", "image", "environment", "glass"] as const;

/** Sequences that the daemon takes as references, but for their seeds. */
const comparable = (of: Sequence, others: SequenceSummary[]) =>
  others.filter(({ id, request }) => id !== of.id && sameOfBoth.every((name) => JSON.stringify(request[name]) === JSON.stringify(of.request[name])));

function Reference({ text, among, chosen, choose }: { text: string; among: SequenceSummary[]; chosen: string; choose: (id: string) => void }) {
  return (
    <label class="field">
      {text}{" "}
      <select value={chosen} onChange={(event) => choose(event.currentTarget.value)}>
        <option value="">none</option>
        {among.map(({ id, request }) => (
          <option key={id} value={id}>
            {id}: {request.method.name}, seed {request.seed}
          </option>
        ))}
      </select>
    </label>
  );
}

function Charts({ errors }: { errors: SequenceErrors }) {
  if (errors.frames.length === 0) return <p class="empty">No frame has succeeded in all three yet.</p>;
  const frames = errors.frames.map((frame) => frame.frame);
  return (
    <>
      {kCharts.map(({ figure, text, about }) => (
        <div key={figure}>
          <h3>
            {text} <span class="muted small">{figureText(errors.mean[figure])} in the mean: {about}</span>
          </h3>
          <LiveChart
            label={`${text} by frame; ${figureText(errors.mean[figure])} in the mean`}
            x={frames}
            y={errors.frames.map((frame) => frame[figure]?.value ?? null)}
            height={kHeight}
            axes={{ x: countText, y: (value) => numberText(value) }}
          />
        </div>
      ))}
      <p>
        Lag {errors.mean.lag ? signedText(errors.mean.lag) : kNone}
        {errors.frames_late !== null && `: what moves is shown ${lateText(errors.frames_late)} frames late`}
        <span class="muted small">, over {errors.frames.length} frames</span>
      </p>
    </>
  );
}

export function ErrorsByFrame({ sequence }: { sequence: Sequence }) {
  const [query, change] = useQuery();
  const first = query.first ?? "";
  const second = query.second ?? "";
  const others = useRemote<Page<SequenceSummary>>("/v1/sequences?limit=100").data?.items ?? [];
  const done = sequence.job_states.succeeded;
  const measured = new URLSearchParams({ first, second }).toString();
  const found = useRemote<SequenceErrors>(
    first && second && done > 0 ? `/v1/sequences/${sequence.id}/errors?${measured}` : null,
    true,
  );
  const among = comparable(sequence, others);
  return (
    <section class="panel" aria-labelledby="sequence-errors">
      <h2 id="sequence-errors">Errors by frame</h2>
      <div class="row">
        <Reference text="First reference" among={among} chosen={first} choose={(id) => change({ first: id })} />
        <Reference text="Second reference" among={among} chosen={second} choose={(id) => change({ second: id })} />
        {found.data && <button onClick={found.reload}>Measure again</button>}
        {found.data && <button onClick={() => void download(`/v1/sequences/${sequence.id}/report.html?${measured}`, `${sequence.id}.html`).catch(sayFailure)}>Report</button>}
      </div>
      {!first || !second ? (
        <p class="muted">Two sequences of the same frames that path tracing has rendered with far apart seeds tell how wrong each frame is, how it flickers and how late it comes.</p>
      ) : found.failure ? (
        <p class="notice failed">{found.failure.message}</p>
      ) : found.data ? (
        <Charts errors={found.data} />
      ) : (
        <p class="empty" role="status">
          Measuring the frames …
        </p>
      )}
    </section>
  );
}
