// The start page: what the daemon does now, and what one may do with it.

import { connection } from "../api/events";
import { Title } from "../app/title";
import { FirstSteps, NextSteps } from "./first_steps";
import { useNowData } from "./now_data";
import { Queue } from "./queue";
import { RecentJobs, RecentStudies } from "./recent";
import { RunningCard } from "./running_card";
import { Throughput } from "./throughput";
import { Workers } from "./workers";
import "./now.css";

export function Now() {
  const { lists, failure, reload } = useNowData();
  const lost = connection.value === "lost";
  const isNew = lists !== null && lists.total === 0;
  return (
    <>
      <Title text="Now">{lists && !isNew && <NextSteps />}</Title>
      <div class="stack">
        {lost && (
          <p class="notice failed" role="alert">
            The daemon does not answer. {lists ? "What is shown is the last it said; this" : "This"} page goes on by itself as soon as it does.
          </p>
        )}
        {!lost && failure && (
          <p class="notice failed" role="alert">
            The jobs cannot be listed: {failure.message}. <button onClick={reload}>Try again</button>
          </p>
        )}
        {isNew && <FirstSteps />}
        {!isNew && (
          <section aria-labelledby="now-running">
            <h2 id="now-running" class="now-heading">
              Running
            </h2>
            {!lists ? (
              <p class="muted">{lost ? "" : "Asking the daemon …"}</p>
            ) : lists.running.length === 0 ? (
              <p class="muted panel">Nothing is rendered at the moment.</p>
            ) : (
              <div class="now-cards">
                {lists.running.map((row) => (
                  <RunningCard key={row.id} row={row} />
                ))}
              </div>
            )}
          </section>
        )}
        <div class="now-columns">
          <div class="stack">
            {lists && !isNew && <Queue queue={lists.queue} queued={lists.queued} />}
            <Workers />
          </div>
          <div class="stack">
            {lists && <RecentStudies jobs={[...lists.running, ...lists.queue, ...lists.recent]} />}
            <Throughput />
          </div>
        </div>
        {lists && <RecentJobs recent={lists.recent} />}
      </div>
    </>
  );
}
