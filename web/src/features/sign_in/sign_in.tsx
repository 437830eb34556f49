import { useEffect, useRef, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ApiError } from "../../api/http";
import type { Session } from "../../api/types";
import { Notice } from "../../widgets/basics";
import { BrandMark } from "../../widgets/brand";

interface Props {
  readonly client: Client;
  readonly notice: string | undefined;          // why one has to sign in, when there was a session before
  readonly onSignedIn: (session: Session) => void;
}

export function SignIn({ client, notice, onSignedIn }: Props) {
  const [error, setError] = useState<ApiError>();
  const [busy, setBusy] = useState(false);
  const login = useRef<HTMLInputElement>(null);
  const password = useRef<HTMLInputElement>(null);
  useEffect(() => {
    document.title = "Sign in – Enamel";
    login.current?.focus();
  }, []);

  const submit = async (event: Event) => {
    event.preventDefault();
    if (busy || login.current === null || password.current === null) return;
    setBusy(true);
    const result = await client.signIn(login.current.value.trim(), password.current.value);
    setBusy(false);
    if (result.ok) return onSignedIn(result.value);
    setError(result.error);
    password.current.focus();
    password.current.select();
  };

  return (
    <main class="sign-in" id="content">
      <div class="sign-in-brand"><BrandMark /><span>Enamel</span></div>
      <h1>Sign in</h1>
      {notice !== undefined && error === undefined && <Notice tone="warning" title="Signed out"><p>{notice}</p></Notice>}
      {error !== undefined && (
        <div id="sign-in-error"><Notice tone="bad" title="Not signed in"><p>{signInText(error)}</p></Notice></div>
      )}
      <form onSubmit={(event) => void submit(event)}>
        <label for="login">Login</label>
        <input id="login" name="login" ref={login} type="text" autocomplete="username" autocapitalize="none" spellcheck={false} required
               maxLength={64} {...describedBy(error)} />
        <label for="password">Password</label>
        <input id="password" name="password" ref={password} type="password" autocomplete="current-password" required
               maxLength={1024} {...describedBy(error)} />
        <button type="submit" class="button primary" disabled={busy}>{busy ? "Signing in…" : "Sign in"}</button>
      </form>
    </main>
  );
}

function describedBy(error: ApiError | undefined) {
  return error?.code === "unauthenticated" ? { "aria-invalid": true, "aria-describedby": "sign-in-error" } : {};
}

function signInText(error: ApiError): string {
  if (error.code !== "unauthenticated") return error.message;
  return "Login and password do not belong together. Check both (capital letters count in the password) and try again, or ask your instructor to reset the password.";
}
