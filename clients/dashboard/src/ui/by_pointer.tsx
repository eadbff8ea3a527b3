import type { ComponentChildren } from "preact";

interface Props {
  mouse: ComponentChildren;
  finger: ComponentChildren;
}

/** What one does here, in the words of what one points with. */
export const ByPointer = ({ mouse, finger }: Props) => (
  <>
    <span class="by-mouse">{mouse}</span>
    <span class="by-finger">{finger}</span>
  </>
);
