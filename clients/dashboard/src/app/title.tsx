import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";

/** A room's heading, which is the document's title too, with the room's actions beside it. */
export function Title({ text, children }: { text: string; children?: ComponentChildren }) {
  const heading = useRef<HTMLHeadingElement>(null);
  useEffect(() => {
    document.title = `${text} · photond`;
  }, [text]);
  return (
    <header class="room-title">
      <h1 ref={heading} tabIndex={-1}>
        {text}
      </h1>
      {children && <div class="room-actions">{children}</div>}
    </header>
  );
}
