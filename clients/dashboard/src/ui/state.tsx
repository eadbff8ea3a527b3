import type { JobState } from "../api/types";

/** A job's state, in a word and by a mark. */
export const StateMark = ({ state }: { state: JobState }) => <span class={`state ${state}`}>{state}</span>;
