// The images by their numbers: which is shown, which is the reference, and what each is.

import type { Desk } from "./desk";
import { lightDifferences } from "./light_differences";
import { kMaxImages, withImages, withoutImage } from "./look";
import { unknownSource } from "./sources";

export function ImageList({ desk, onAdd }: { desk: Desk; onAdd: () => void }) {
  const images = desk.part("images").value;
  const two = images.length > 1 && ["wipe", "side"].includes(desk.part("mode").value);
  const shown = desk.part("shown").value;
  const reference = desk.reference.value;
  const differences = lightDifferences(images.map((name) => desk.sources.value.get(name)?.job ?? null));
  return (
    <section class="panel" aria-labelledby="compare-images">
      <h2 id="compare-images">Images</h2>
      <ol class="compare-images">
        {images.map((name, index) => {
          const source = desk.sources.value.get(name);
          const entry = desk.entry(index);
          const statistics = entry?.image?.statistics;
          const title = source?.title ?? name;
          return (
            <li key={name} class={index === shown ? "shown" : undefined}>
              <button class="compare-show" aria-pressed={index === shown} onClick={() => desk.change({ shown: index })} title={`Show it (${index + 1})`}>
                {index + 1}
              </button>
              <div>
                <span class="compare-title">{source?.job ? <a href={`/jobs/${source.job.id}`}>{title}</a> : title}</span>
                <span class="small muted">{source?.failure ? <span class="fault">{source.failure.message}</span> : (source?.detail ?? "…")}</span>
                {statistics && statistics.nans + statistics.infinities > 0 && (
                  <span class="small fault">
                    {`Pixels that are not finite: ${[statistics.nans && `${statistics.nans} NaN`, statistics.infinities && `${statistics.infinities} ∞`].filter(Boolean).join(", ")}`}
                  </span>
                )}
                {entry?.image && entry.image.overflowed > 0 && (
                  <span class="small fault">Values beyond half precision: {entry.image.overflowed}. Choose full precision to see them.</span>
                )}
                <span class="row">
                  {images.length > 1 && (
                    <label class="small">
                      <input type="radio" name="compare-reference" checked={index === reference} onChange={() => desk.change({ reference: name })} /> reference
                    </label>
                  )}
                  {two && (
                    <label class="small">
                      <input type="radio" name="compare-beside" checked={index === desk.beside.value} onChange={() => desk.change({ beside: index })} /> on the right
                    </label>
                  )}
                </span>
              </div>
              <button class="quiet" aria-label={`Take ${title} away`} title="Take it away" onClick={() => (desk.look.value = withoutImage(desk.look.peek(), index))}>
                ✕
              </button>
            </li>
          );
        })}
      </ol>
      {differences.length > 0 && (
        <div class="notice small" role="note">
          The images are not of the same light, so that they differ however long they are rendered:
          <ul>
            {differences.map((difference) => (
              <li key={difference}>{difference}</li>
            ))}
          </ul>
        </div>
      )}
      {desk.sizesDiffer.value && <p class="notice small">The images are of different sizes. They lie with their upper left corners together; there are error maps only of those with the reference's size.</p>}
      <div class="row">
        <button onClick={onAdd}>Add images …</button>
        {desk.referencesElsewhere.value.map((name) => (
          <button
            key={name}
            disabled={images.length >= kMaxImages}
            onClick={() => (desk.look.value = { ...withImages(desk.look.peek(), [name]), reference: name })}
            title="What the images here were measured against while they were rendered"
          >
            Add the reference {unknownSource(name).title}
          </button>
        ))}
        <button class="quiet" onClick={() => desk.refreshAll()} title="Ask the daemon for the newest pixels">
          Refresh
        </button>
        {desk.running.value && (
          <label class="small">
            <input type="checkbox" checked={desk.live.value} onChange={(event) => (desk.live.value = event.currentTarget.checked)} /> follow running jobs
          </label>
        )}
      </div>
    </section>
  );
}
