// What the daemon gets done, second by second, over the last minutes.

import { useEffect, useMemo } from "preact/hooks";

import { bytesText, countText, numberText, secondsText } from "../ui/format";
import { LiveChart } from "../ui/live_chart";
import { lookBack, samples } from "./history";
import { type Quantity, rates, type Sample } from "./rates";

const kShownSeconds = 300;
const kLeastSeconds = 60;

interface Shown {
  quantity: Quantity;
  name: string;
  unit: string;
  /** A rate needs a window in which enough happens to count. */
  windowSeconds: number;
  perSeconds: number;
}

const kShown: Shown[] = [
  { quantity: "passes", name: "Passes", unit: "a second", windowSeconds: 5, perSeconds: 1 },
  // These are known when a job ends, so a minute is looked back on.
  { quantity: "rays", name: "Rays", unit: "a second, as jobs end", windowSeconds: 60, perSeconds: 1 },
  { quantity: "photons", name: "Photons", unit: "a second, as jobs end", windowSeconds: 60, perSeconds: 1 },
  { quantity: "jobs", name: "Jobs", unit: "a minute", windowSeconds: 60, perSeconds: 60 },
];

const agoText = (seconds: number) => (seconds === 0 ? "now" : `−${secondsText(-seconds)}`);

function Chart({ name, unit, x, y, write, look }: { name: string; unit: string; x: number[]; y: (number | null)[]; write: (value: number | null) => string; look: number }) {
  const now = y.at(-1) ?? null;
  const text = `${write(now)} ${unit}`.trim();
  return (
    <figure class="now-chart">
      <figcaption>
        <span class="muted">{name}</span> <strong>{text}</strong>
      </figcaption>
      <LiveChart
        label={`${name} over the last minutes; now ${text}`}
        x={x}
        y={y}
        height={92}
        range={[Math.max(-kShownSeconds, Math.min(-kLeastSeconds, x[0] ?? 0)), 0]}
        look={look}
        axes={{ x: agoText, y: (value) => (value === 0 ? "0" : write(value)) }}
      />
    </figure>
  );
}

function RateChart({ shown, x, all, look }: { shown: Shown; x: number[]; all: Sample[]; look: number }) {
  const y = useMemo(
    () => rates(all, shown.quantity, shown.windowSeconds).map((rate) => (rate === null ? null : rate * shown.perSeconds)),
    [all, shown],
  );
  const write = (value: number | null) => (value !== null && value < 1000 ? numberText(value) : countText(value));
  return <Chart name={shown.name} unit={shown.unit} x={x} y={y} write={write} look={look} />;
}

export function Throughput() {
  const all = samples.value;
  const end = all.at(-1)?.at ?? 0;
  const hasBegun = all.length > 0;
  useEffect(() => {
    if (hasBegun) lookBack(samples.peek()[0]!).catch(() => undefined); // without it the charts begin now
  }, [hasBegun]);
  const x = useMemo(() => all.map((sample) => sample.at - end), [all]);
  const memory = useMemo(() => all.map(({ memory }) => (Number.isNaN(memory) ? null : memory)), [all]);
  return (
    <section class="panel" aria-labelledby="now-throughput">
      <h2 id="now-throughput">Throughput</h2>
      {all.length < 2 ? (
        <p class="muted">The first seconds are to come.</p>
      ) : (
        <div class="now-charts">
          {kShown.map((shown, index) => (
            <RateChart key={shown.quantity} shown={shown} x={x} all={all} look={index} />
          ))}
          <Chart name="Memory" unit="held by all processes" x={x} y={memory} write={bytesText} look={4} />
        </div>
      )}
    </section>
  );
}
