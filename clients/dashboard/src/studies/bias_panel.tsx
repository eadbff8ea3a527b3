// Bias and variance apart, of rows with two seeds or more; and where a row's mean is not the reference, as a map.

import { useState } from "preact/hooks";

import { withQuery } from "../api/client";
import type { ComparisonReport, WelchMap } from "../api/types";
import { plainName } from "../ui/format";
import { Picture, useSeen } from "../ui/picture";
import { useRemote } from "../ui/remote";
import { biasLines, biasText, layerOf, mapLayers, meanSquare, varianceText, type BiasLine } from "./bias";
import { Swatch } from "./error_figure";
import { rowName } from "./series";

function BiasTable({ lines, metric }: { lines: BiasLine[]; metric: string }) {
  return (
    <div class="scroll-x" tabIndex={0} role="group" aria-label="Bias and variance">
      <table class="study-table">
        <thead>
          <tr>
            <th scope="col">Entry</th>
            <th scope="col" class="number">Seeds</th>
            <th scope="col" class="number">{meanSquare(metric)}: squared bias</th>
            <th scope="col" class="number">variance of one film</th>
            <th scope="col">What that says</th>
          </tr>
        </thead>
        <tbody>
          {lines.map(({ row, name, seeds, bias }) => (
            <tr key={row}>
              <th scope="row">
                <Swatch row={row} /> {name}
              </th>
              <td class="number">{seeds}</td>
              <td class="number">{biasText(bias)}</td>
              <td class="number">{varianceText(bias)}</td>
              <td class="study-said">{bias.text}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

interface MapProps {
  study: string;
  row: number;
  name: string;
  layer: string;
  ratio: number;
}

function BiasMap({ study, row, name, layer, ratio }: MapProps) {
  const [seen, watch] = useSeen<HTMLLIElement>();
  const path = (kind: "png" | "json") => withQuery(`/v1/comparisons/${study}/rows/${row}/bias.${kind}`, { layer });
  const { data, failure } = useRemote<WelchMap>(seen ? path("json") : null, true);
  return (
    <li ref={watch}>
      <Picture path={path("png")} ratio={ratio} alt={`Where ${name} is biased, ${plainName(layer)}`} waiting="…" />
      <p>
        <span class="study-picture-name">
          <Swatch row={row} /> {name}
        </span>
        <small class={failure ? "fault" : "muted"}>{failure?.message ?? data?.text ?? "…"}</small>
      </p>
    </li>
  );
}

/** Nothing where no row has a bias to tell of: of one seed, or while it runs, or where the reference is not two films. */
export function BiasPanel({ report, metric }: { report: ComparisonReport; metric: string }) {
  const layers = mapLayers(report);
  const [chosen, choose] = useState<string | null>(null);
  const lines = biasLines(report.table, metric);
  if (!report.table.some((row) => row.bias)) return null;
  const layer = chosen ?? (layers.includes(layerOf(metric)) ? layerOf(metric) : "beauty");
  const { width, height } = report.request.image;
  return (
    <section class="panel stack study-tight" aria-labelledby="study-bias">
      <h2 id="study-bias">Bias and noise apart</h2>
      {lines.length > 0 ? <BiasTable lines={lines} metric={metric} /> : <p class="muted">{metric} is no mean of squares, so that it has no such parts.</p>}
      <p class="muted small">
        Squared bias: what the films of all seeds have in common, which no number of seeds averages away; variance: what each film has of its own. In brackets
        where they lie at 90 %: squared bias by the seeds and the references' noise, variance by the seeds.
      </p>
      <div class="row study-controls">
        <h3 class="study-fill">Where the mean is not the reference</h3>
        {layers.length > 1 && (
          <label class="study-inline">
            Layer
            <select value={layer} onChange={(event) => choose(event.currentTarget.value)}>
              {layers.map((name) => (
                <option key={name} value={name}>
                  {plainName(name)}
                </option>
              ))}
            </select>
          </label>
        )}
      </div>
      <p class="muted small">
        Blue: the mean of the seeds is darker, red: brighter, full from 10 % on. In a black frame: more than chance explains, the blocks of the image judged
        together; pale: what chance explains.
      </p>
      <ul class="study-strip">
        {report.table.map((row, index) => row.bias && <BiasMap key={index} study={report.id} row={index} name={rowName(row)} layer={layer} ratio={width / height} />)}
      </ul>
    </section>
  );
}
