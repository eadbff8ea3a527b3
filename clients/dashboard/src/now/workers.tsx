// The processes that render and the devices they have, and those of the machine that none has.

import type { ComponentChild } from "preact";
import { useEffect } from "preact/hooks";

import { daemonStatus } from "../api/events";
import type { DaemonStatus, Device, Page, WorkerStatus } from "../api/types";
import { bytesText, percentText } from "../ui/format";
import { useRemote } from "../ui/remote";

const kHelper = "none";
const kStates: Record<string, string> = { busy: "rendering", ready: "ready", failed: "not answering" };

/** How much of what there may be, as a bar and in numbers. */
function Meter({ name, value, limit }: { name: string; value: number | null; limit: number | null }) {
  if (value === null) return <span class="muted">–</span>;
  if (!limit) return <span>{bytesText(value)}</span>;
  const share = value / limit;
  return (
    <span class="now-meter">
      <meter min={0} max={limit} high={0.85 * limit} value={value} aria-label={`Memory of ${name}: ${percentText(share)} of its limit`} />
      <span class="small">
        {bytesText(value)} <span class="muted">of {bytesText(limit)}</span>
      </span>
    </span>
  );
}

function Worker({ worker, device }: { worker: WorkerStatus; device: Device | undefined }) {
  const helper = worker.device === kHelper;
  const name = helper ? "Helper" : (worker.device_name ?? device?.name ?? worker.device);
  return (
    <li class="now-worker">
      <span class="now-worker-name">
        <strong>{name}</strong>
        <span class="muted small">
          {helper
            ? "reads scenes, makes pictures, measures errors"
            : `${worker.device}${device && device.kind !== "cpu" ? ` · ${device.software ? "software" : "hardware"}` : ""}`}
        </span>
      </span>
      <span class={`now-worker-state ${worker.state}`}>
        {kStates[worker.state] ?? worker.state}
        {worker.job && (
          <>
            {" "}
            <a href={`/jobs/${worker.job}`}>{worker.job}</a>
          </>
        )}
        {worker.restarts > 0 && <span class="small now-restarts">{worker.restarts === 1 ? "restarted once" : `restarted ${worker.restarts} times`}</span>}
      </span>
      <Meter name={name} value={worker.resident_bytes} limit={worker.memory_limit_bytes} />
    </li>
  );
}

/** The command that would serve a device beside those that are. */
function servedWith(status: DaemonStatus, device: Device): string {
  const served = status.workers.map((worker) => worker.device).filter((id) => id !== kHelper);
  return `photond --devices ${[...served, device.id].join(",")}`;
}

/** What the daemon has found and would have looked after. */
function Remarks({ status: { store, workers, helpers, pictures } }: { status: DaemonStatus }) {
  const remarks: ComponentChild[] = [];
  if (["damaged", "failed"].includes(store.check.state))
    remarks.push(<>The store's check: {store.check.state}, {store.check.detail}. <code>photonctl restore</code> puts a backup in its place.</>);
  if (store.quarantine.files > 0)
    remarks.push(<>Files in the data folder's quarantine: {store.quarantine.files}. The log names each.</>);
  if ([...workers, ...helpers, pictures].some(({ file_access }) => file_access?.by === "none"))
    remarks.push(<>The workers' files are not bounded: <code>photonctl doctor</code> says why.</>);
  return remarks.length === 0 ? null : (
    <ul class="notice now-remarks">
      {remarks.map((remark) => (
        <li>{remark}</li>
      ))}
    </ul>
  );
}

export function Workers() {
  const status = daemonStatus.value;
  const { data: devices, failure, reload } = useRemote<Page<Device>>("/v1/devices");
  // A worker that was started anew may have found another device.
  const restarts = status?.workers.map((worker) => `${worker.device} ${worker.restarts} ${worker.state === "failed"}`).join() ?? "";
  useEffect(() => {
    if (restarts) reload();
  }, [restarts]);
  const known = new Map(devices?.items.map((device) => [device.id, device]));
  const unserved = devices?.items.filter((device) => device.served === false) ?? [];
  return (
    <section class="panel" aria-labelledby="now-workers">
      <h2 id="now-workers">Workers and devices</h2>
      {!status ? (
        <p class="muted">Waiting for the daemon's first word …</p>
      ) : (
        <ul class="now-workers">
          {status.workers.map((worker) => (
            <Worker key={worker.device} worker={worker} device={known.get(worker.device)} />
          ))}
        </ul>
      )}
      {status && <Remarks status={status} />}
      {failure && <p class="notice failed">The devices cannot be listed: {failure.message}</p>}
      {status && unserved.length > 0 && (
        <details class="now-unserved">
          <summary>
            {unserved.length === 1 ? "1 device of this machine is" : `${unserved.length} devices of this machine are`} not used
          </summary>
          <ul>
            {unserved.map((device) => (
              <li key={device.id}>
                <strong>{device.name}</strong> <span class="muted">{`${device.id}, ${device.software ? "software" : "hardware"}`}</span>
                {device.memory_bytes !== null && <span class="muted">, {bytesText(device.memory_bytes)}</span>}
                <p class="small">
                  To have it render too: <code>{servedWith(status, device)}</code>
                </p>
              </li>
            ))}
          </ul>
        </details>
      )}
      {status && (
        <p class="small muted now-daemon">
          photond {status.version} · up {upText(status.uptime_seconds)} · {bytesText(status.disk_free_bytes)} of disk free ·{" "}
          {status.event_clients === 1 ? "this page alone listens" : `${status.event_clients} listen`}
          {status.pictures.waiting > 0 && ` · ${status.pictures.waiting === 1 ? "a picture waits" : `${status.pictures.waiting} pictures wait`} to be drawn beside the job`}
        </p>
      )}
    </section>
  );
}

function upText(seconds: number): string {
  if (seconds < 90) return `${Math.floor(seconds)} s`;
  if (seconds < 5400) return `${Math.floor(seconds / 60)} min`;
  return seconds < 48 * 3600 ? `${Math.floor(seconds / 3600)} h` : `${Math.floor(seconds / 86400)} days`;
}
