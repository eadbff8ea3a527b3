// The token of who looks. A tab keeps it for itself, and other tabs of the browser get it while one is open (shared.ts);
// on disk it is only where "keep me signed in" was chosen. It is no cookie: a browser sends those along with whatever
// another site has it ask for, and the daemon would do it. Scripts of this page alone can read it, and the page's policy
// lets no others run.

import { signal } from "@preact/signals";

const kKey = "photond.token";

/** True once the daemon has asked for a token that it knows: the shell then shows the sign-in. */
export const needsToken = signal(false);

export const token = (): string | null => sessionStorage.getItem(kKey) ?? localStorage.getItem(kKey);

/** `stays`: when the browser has been closed, too. */
export function takeToken(given: string, stays: boolean): void {
  sessionStorage.setItem(kKey, given);
  if (stays) localStorage.setItem(kKey, given);
  else localStorage.removeItem(kKey);
  needsToken.value = false;
}

export function forgetToken(): void {
  sessionStorage.removeItem(kKey);
  localStorage.removeItem(kKey);
}
