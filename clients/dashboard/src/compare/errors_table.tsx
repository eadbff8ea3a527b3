// Each image's errors against the reference, as the daemon measures them.

import { useEffect, useState } from "preact/hooks";

import { sendJson } from "../api/client";
import type { Json, NoiseInterval } from "../api/types";
import { isMeasured, metricNamed } from "../api/vocabulary";
import { drawnError, errorWithInterval } from "../ui/error_interval";
import { numberText } from "../ui/format";
import { sameSize, type Desk } from "./desk";
import { filmsOf } from "./sources";

const kQuick = ["relative_mse", "rmse", "smape", "relative_bias"];
const kFlip = "flip_hdr";

interface Measured {
  metrics: Record<string, Json>;
  /** Of what two films measured. */
  intervals: Record<string, NoiseInterval | null> | null;
  notes: string[];
}
type Result = Measured | { failure: Error };

/** What has been measured: the same for the same pixels. */
const known = new Map<string, Result>();

interface Order {
  key: string;
  image: string;
  reference: string;
  /** The reference and its other film, whose noise drops out of mean squares. */
  films: [string, string] | null;
  layer: string;
  metrics: string[];
}

async function measure(order: Order): Promise<Result> {
  const { image, reference, films, layer, metrics } = order;
  const prefix = layer === "beauty" ? "" : `${layer}:`;
  const unprefixed = <T,>(values: Record<string, T>) => Object.fromEntries(Object.entries(values).map(([name, value]) => [name.slice(prefix.length), value]));
  try {
    const against = films ? { references: films } : { reference };
    const measured = await sendJson<Measured>("POST", "/v1/metrics", { image, ...against, metrics: metrics.map((name) => prefix + name) });
    return { ...measured, metrics: unprefixed(measured.metrics), intervals: measured.intervals && unprefixed(measured.intervals) };
  } catch (failure) {
    // The other film may be gone.
    return films ? measure({ ...order, films: null }) : { failure: failure as Error };
  }
}

/** The orders' results as they come, one after another: pixels that are looked at must not wait behind them. */
function useMeasured(orders: Order[]): ReadonlyMap<string, Result> {
  const [, setRound] = useState(0);
  const wanted = orders.map((order) => order.key).join(" ");
  useEffect(() => {
    let stopped = false;
    void (async () => {
      for (const order of orders) {
        if (stopped) return;
        if (known.has(order.key)) continue;
        const result = await measure(order);
        if (stopped && "failure" in result) return;
        known.set(order.key, result);
        if (!stopped) setRound((round) => round + 1);
      }
    })();
    return () => {
      stopped = true;
      for (const [key, result] of known) if ("failure" in result) known.delete(key); // asked for again when one looks again
    };
  }, [wanted]);
  return known;
}

function cellText(value: Json | undefined, interval: NoiseInterval | null): string {
  if (interval && (value === null || typeof value === "number")) return errorWithInterval(value, interval);
  if (Array.isArray(value)) return value.map((one) => numberText(one as number | null, 2).replace("-", "−")).join("  ");
  return typeof value === "number" ? numberText(value) : "–";
}

export function ErrorsTable({ desk }: { desk: Desk }) {
  const [withFlip, setWithFlip] = useState(false);
  const images = desk.part("images").value;
  const layer = desk.part("layer").value;
  const reference = images[desk.reference.value];
  const sources = desk.sources.value;
  const against = reference === undefined ? undefined : sources.get(reference);
  const films = reference === undefined ? null : filmsOf(reference, sources);
  const measured = isMeasured(layer);
  const rows = images.flatMap((name, index) => {
    const source = sources.get(name);
    return source?.size && index !== desk.reference.value ? [{ name, index, source }] : [];
  });
  const orderOf = (name: string, version: number, metrics: string[]): Order => ({
    key: [name, version, films?.join() ?? reference, against?.version ?? 0, layer, metrics.join()].join("|"),
    image: name,
    reference: reference ?? "",
    films: films?.includes(name) ? null : films,
    layer,
    metrics,
  });
  const measurable = (source: (typeof rows)[number]["source"]) =>
    measured && against?.size && sameSize(source.size, against.size) && source.layers.includes(layer) && against.layers.includes(layer);
  const orders = rows.flatMap(({ name, source }) => (measurable(source) ? [orderOf(name, source.version, kQuick)] : []));
  if (withFlip) orders.push(...rows.flatMap(({ name, source }) => (measurable(source) ? [orderOf(name, source.version, [kFlip])] : [])));
  const results = useMeasured(orders);
  if (images.length < 2) return null;

  const columns = [...kQuick, kFlip];
  const table = rows.map(({ name, index, source }) => {
    const quick = results.get(orderOf(name, source.version, kQuick).key);
    const flip = results.get(orderOf(name, source.version, [kFlip]).key);
    const shownFlip = desk.part("error").value === kFlip ? desk.flipEntry(index)?.flipMean : null;
    const values: Record<string, Json | undefined> = {
      ...(quick && "metrics" in quick ? quick.metrics : {}),
      ...(flip && "metrics" in flip ? flip.metrics : {}),
    };
    const intervals = (quick && "metrics" in quick && quick.intervals) || {};
    if (values[kFlip] === undefined && typeof shownFlip === "number") values[kFlip] = shownFlip;
    const failure = quick && "failure" in quick ? quick.failure : flip && "failure" in flip ? flip.failure : null;
    const notes = quick && "metrics" in quick ? quick.notes.map((note) => `Image ${index + 1}: ${note}`) : [];
    return { name, index, source, values, intervals, failure, notes, busy: measurable(source) && !quick };
  });
  const least = (metric: string): number => {
    // Where one is not told apart from 0, nobody is known to have the least.
    if (table.some(({ values, intervals }) => drawnError(values[metric] as number | null, intervals[metric])?.isBound)) return NaN;
    const numbers = table.map((row) => row.values[metric]).filter((value): value is number => typeof value === "number");
    return numbers.length > 1 ? Math.min(...numbers) : NaN;
  };
  const notes = table.flatMap((row) => row.notes);
  const isCrossed = table.some(({ intervals }) => Object.values(intervals).some(Boolean));
  return (
    <section class="panel" aria-labelledby="compare-errors">
      <h2 id="compare-errors">Errors against image {desk.reference.value + 1}</h2>
      {!measured ? (
        <p class="muted">Layers of light are measured; {layer} is none.</p>
      ) : (
        <>
          <div class="scroll-x" tabIndex={0} role="region" aria-label="Errors of the images">
            <table>
              <thead>
                <tr>
                  <th scope="col">Image</th>
                  {columns.map((metric) => (
                    <th key={metric} scope="col" class="number">
                      {metricNamed(metric)?.title ?? metric}
                    </th>
                  ))}
                </tr>
              </thead>
              <tbody>
                {table.map(({ name, index, source, values, intervals, failure, busy }) => (
                  <tr key={name}>
                    <th scope="row">
                      {index + 1} {source.title}
                    </th>
                    {failure || !measurable(source) ? (
                      <td colSpan={columns.length} class={failure ? "fault" : "muted"}>
                        {failure?.message ?? (sameSize(source.size, against?.size ?? null) ? `one of the two has no layer ${layer}` : "of another size than the reference")}
                      </td>
                    ) : (
                      columns.map((metric) => (
                        <td key={metric} class="number mono">
                          {busy && metric !== kFlip ? "…" : cellText(values[metric], intervals[metric] ?? null)}
                          {values[metric] === least(metric) && <b title="the least"> ★</b>}
                        </td>
                      ))
                    )}
                  </tr>
                ))}
              </tbody>
            </table>
          </div>
          <div class="row compare-below">
            <button disabled={withFlip} onClick={() => setWithFlip(true)}>
              Measure FLIP too
            </button>
            <span class="hint">★ the least of its column. Of whole images, in full precision.
              {isCrossed && " In brackets: against both films of the reference, whose noise drops out; what it leaves open at 90 %."}
            </span>
          </div>
          {notes.length > 0 && (
            <ul class="hint">
              {notes.map((note) => (
                <li key={note}>{note}</li>
              ))}
            </ul>
          )}
        </>
      )}
    </section>
  );
}
