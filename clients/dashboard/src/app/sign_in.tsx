import { useState } from "preact/hooks";

import { takeToken, token } from "../api/token";
import { authorization } from "../api/token_header";

/** What is wrong with a token; nothing where the daemon takes it. */
async function refusalOf(given: string): Promise<string> {
  try {
    const answer = await fetch("/v1/status", { headers: authorization(given), priority: "high" });
    if (answer.status === 401) return "The daemon does not know this token.";
    if (answer.status === 429) return `Too many wrong tokens: it takes the next one in ${answer.headers.get("Retry-After") ?? "some"} s.`;
    return answer.ok ? "" : `The daemon answers ${answer.status}: ${answer.statusText}.`;
  } catch {
    return "The daemon does not answer.";
  }
}

/** Shown when the daemon has asked for a token. */
export function SignIn() {
  const [refusal, setRefusal] = useState(token() ? "The token that this browser keeps is not known to the daemon any more." : "");
  const [asking, setAsking] = useState(false);
  const signIn = async (form: FormData) => {
    const given = String(form.get("token")).trim();
    setAsking(true);
    const refused = await refusalOf(given);
    setAsking(false);
    setRefusal(refused);
    if (refused) return;
    takeToken(given, form.get("stays") !== null);
    window.location.reload();
  };
  return (
    <form
      class="sign-in panel"
      onSubmit={(event) => {
        event.preventDefault();
        void signIn(new FormData(event.currentTarget));
      }}
    >
      <h1>Sign in</h1>
      <p>This daemon takes requests with a token only. All tabs of this browser use it until the last one is closed.</p>
      <label class="field">
        Token <input name="token" type="password" autocomplete="off" required aria-describedby="sign-in-refusal" />
      </label>
      <label class="choice">
        <input name="stays" type="checkbox" /> Keep me signed in: the token stays on this machine until I sign out
      </label>
      <p id="sign-in-refusal" class={refusal ? "notice failed" : ""} role="alert">
        {refusal}
      </p>
      <button class="primary" disabled={asking}>
        {asking ? "Asking the daemon …" : "Sign in"}
      </button>
    </form>
  );
}
