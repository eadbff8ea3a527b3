import { signIn } from "../api/client";

/** Shown when the daemon has asked for a token. */
export function SignIn() {
  return (
    <form
      class="sign-in panel"
      onSubmit={(event) => {
        event.preventDefault();
        const token = new FormData(event.currentTarget).get("token");
        signIn(String(token));
        window.location.reload();
      }}
    >
      <h1>Sign in</h1>
      <p>This daemon takes requests with a token only. It is kept until this tab is closed.</p>
      <label class="field">
        Token <input name="token" type="password" autocomplete="off" required />
      </label>
      <button class="primary">Sign in</button>
    </form>
  );
}
