import type { ComponentChildren } from "preact";

/** A part of the form under its heading. */
export function Panel({ title, note, children }: { title: string; note?: string; children: ComponentChildren }) {
  const id = `render-${title.toLowerCase().replaceAll(/\W+/g, "-")}`;
  return (
    <section class="panel render-panel" aria-labelledby={id}>
      <h2 id={id}>
        {title} {note && <span class="hint">{note}</span>}
      </h2>
      {children}
    </section>
  );
}
