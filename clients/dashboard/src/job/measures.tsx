// What a job took: time by stage, memory by structure, counts and rates.

import type { Statistics } from "../api/types";
import { isDark } from "../app/theme";
import { bytesText, countText, percentText, plainName, secondsText } from "../ui/format";
import { seriesLook } from "../ui/palette";

/** Stages too short to be seen are one part of the bar, named in the table all the same. */
const kLeastShare = 0.005;

export function Stages({ statistics }: { statistics: Statistics }) {
  const stages = [...statistics.stages].sort((a, b) => b.wall_seconds - a.wall_seconds);
  const whole = stages.reduce((sum, stage) => sum + stage.wall_seconds, 0);
  if (whole === 0) return <p class="muted">No stage took any time.</p>;
  const hasGpu = stages.some((stage) => stage.gpu_seconds !== null);
  const dark = isDark.value;
  const look = (index: number) => seriesLook(index, dark).colour;
  const seen = stages.filter((stage) => stage.wall_seconds / whole >= kLeastShare);
  return (
    <>
      <svg class="job-stages" viewBox="0 0 1000 28" preserveAspectRatio="none" role="img" aria-label={`Time by stage: ${seen.map((stage) => `${plainName(stage.name)} ${percentText(stage.wall_seconds / whole)}`).join(", ")}`}>
        {seen.map((stage, index) => {
          const x = seen.slice(0, index).reduce((sum, before) => sum + before.wall_seconds, 0) / whole;
          return (
            <rect key={stage.name} x={1000 * x} y={0} width={Math.max(1, (1000 * stage.wall_seconds) / whole - 2)} height={28} fill={look(index)}>
              <title>
                {plainName(stage.name)} {secondsText(stage.wall_seconds)}
              </title>
            </rect>
          );
        })}
      </svg>
      <div class="scroll-x">
        <table class="job-table">
          <thead>
            <tr>
              <th>Stage</th>
              <th class="number">Share</th>
              <th class="number">Time</th>
              <th class="number">CPU time</th>
              {hasGpu && <th class="number">GPU time</th>}
            </tr>
          </thead>
          <tbody>
            {stages.map((stage, index) => (
              <tr key={stage.name}>
                <td>
                  <svg class="job-mark" viewBox="0 0 10 10" aria-hidden="true">
                    {index < seen.length && <rect width="10" height="10" rx="2" fill={look(index)} />}
                  </svg>
                  {plainName(stage.name)}
                </td>
                <td class="number">{percentText(stage.wall_seconds / whole)}</td>
                <td class="number">{secondsText(stage.wall_seconds)}</td>
                <td class="number">{secondsText(stage.cpu_seconds)}</td>
                {hasGpu && <td class="number">{secondsText(stage.gpu_seconds)}</td>}
              </tr>
            ))}
          </tbody>
          <tfoot>
            <tr>
              <th>all</th>
              <td class="number" />
              <td class="number">{secondsText(whole)}</td>
              <td class="number">{secondsText(stages.reduce((sum, stage) => sum + (stage.cpu_seconds ?? 0), 0))}</td>
              {hasGpu && <td class="number">{secondsText(stages.reduce((sum, stage) => sum + (stage.gpu_seconds ?? 0), 0))}</td>}
            </tr>
          </tfoot>
        </table>
      </div>
    </>
  );
}

export function Memory({ statistics }: { statistics: Statistics }) {
  const { memory } = statistics;
  const structures = Object.entries(memory.structures)
    .filter(([, bytes]) => bytes > 0)
    .sort(([, a], [, b]) => b - a);
  const most = structures[0]?.[1] ?? 1;
  return (
    <>
      <dl class="facts job-memory-facts">
        <dt>Accounted for</dt>
        <dd>{bytesText(memory.accounted_bytes)}</dd>
        <dt>Peak of the process</dt>
        <dd>
          {bytesText(memory.peak_resident_bytes)}
          {memory.baseline_resident_bytes !== null && <span class="muted"> ({bytesText(memory.baseline_resident_bytes)} before the job)</span>}
        </dd>
        {memory.peak_device_bytes !== null && (
          <>
            <dt>Peak on the GPU</dt>
            <dd>{bytesText(memory.peak_device_bytes)}</dd>
          </>
        )}
      </dl>
      <table class="job-table job-bars">
        <thead>
          <tr>
            <th>Structure</th>
            <th class="number">Size</th>
            <th aria-hidden="true" />
          </tr>
        </thead>
        <tbody>
          {structures.map(([name, bytes]) => (
            <tr key={name}>
              <td>{plainName(name)}</td>
              <td class="number">{bytesText(bytes)}</td>
              <td aria-hidden="true">
                <svg viewBox="0 0 100 10" preserveAspectRatio="none">
                  <rect class="job-bar" width={Math.max(0.5, (100 * bytes) / most)} height="10" rx="1" />
                </svg>
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </>
  );
}

export function Counts({ statistics }: { statistics: Statistics }) {
  const { rays, ...counts } = statistics.counts;
  const rows: [string, string][] = [
    ...Object.entries(rays).map(([name, count]): [string, string] => [`${plainName(name)} rays`, countText(count)]),
    ...Object.entries(counts)
      .filter((entry): entry is [string, number] => typeof entry[1] === "number" && entry[1] !== 0)
      .map(([name, count]): [string, string] => [plainName(name), countText(count)]),
    ...Object.entries(statistics.rates)
      .filter((entry): entry is [string, number] => entry[1] !== null)
      .map(([name, rate]): [string, string] => [plainName(name.replace("_per_second", "")), `${countText(rate)} a second`]),
  ];
  const broken = statistics.nan_count + statistics.infinity_count;
  return (
    <>
      <dl class="facts job-counts">
        {rows.map(([name, text]) => (
          <>
            <dt>{name}</dt>
            <dd>{text}</dd>
          </>
        ))}
      </dl>
      {broken > 0 && (
        <p class="notice">
          {countText(statistics.nan_count)} samples were no number and {countText(statistics.infinity_count)} infinite; they were left out.
        </p>
      )}
    </>
  );
}
