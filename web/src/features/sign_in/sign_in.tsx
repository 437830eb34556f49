import { useEffect, useRef, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ApiError } from "../../api/http";
import type { Session } from "../../api/types";
import type { Language } from "../../base/language";
import { say } from "../../base/words";
import { Notice } from "../../widgets/basics";
import { BrandMark } from "../../widgets/brand";
import { Languages } from "../../widgets/languages";

interface Props {
  readonly client: Client;
  readonly notice: string | undefined; // why one has to sign in, when there was a session before
  readonly chosen: Language | undefined; // in this tab, on this screen
  readonly onSignedIn: (session: Session, chosen: Language | undefined) => void;
  readonly onLanguage: (language: Language) => void;
}

export function SignIn({ client, notice, chosen, onSignedIn, onLanguage }: Props) {
  const [error, setError] = useState<ApiError>();
  const [busy, setBusy] = useState(false);
  const login = useRef<HTMLInputElement>(null);
  const password = useRef<HTMLInputElement>(null);
  useEffect(() => {
    document.title = say("page_sign_in.document");
    login.current?.focus();
  }, []);

  const submit = async (event: Event) => {
    event.preventDefault();
    if (busy || login.current === null || password.current === null) return;
    setBusy(true);
    const result = await client.signIn(login.current.value.trim(), password.current.value);
    setBusy(false);
    if (result.ok) return onSignedIn(result.value, chosen);
    setError(result.error);
    password.current.focus();
    password.current.select();
  };

  return (
    <main class="sign-in" id="content">
      <div class="sign-in-brand">
        <BrandMark />
        <span>Enamel</span>
      </div>
      <h1>{say("page_sign_in.title")}</h1>
      {notice !== undefined && error === undefined && (
        <Notice tone="warning" title={say("page_sign_in.signed_out")}>
          <p>{notice}</p>
        </Notice>
      )}
      {error !== undefined && (
        <div id="sign-in-error">
          <Notice tone="bad" title={say("page_sign_in.not_signed_in")}>
            <p>{signInText(error)}</p>
          </Notice>
        </div>
      )}
      <form onSubmit={(event) => void submit(event)}>
        <label for="login">{say("account.login")}</label>
        <input
          id="login"
          name="login"
          ref={login}
          type="text"
          autocomplete="username"
          autocapitalize="none"
          spellcheck={false}
          required
          maxLength={64}
          {...describedBy(error)}
        />
        <label for="password">{say("account.password")}</label>
        <input
          id="password"
          name="password"
          ref={password}
          type="password"
          autocomplete="current-password"
          required
          maxLength={1024}
          {...describedBy(error)}
        />
        <button type="submit" class="button primary" disabled={busy}>
          {busy ? say("page_sign_in.going") : say("page_sign_in.title")}
        </button>
      </form>
      <Languages onLanguage={onLanguage} />
    </main>
  );
}

function describedBy(error: ApiError | undefined) {
  return error?.code === "unauthenticated" ? { "aria-invalid": true, "aria-describedby": "sign-in-error" } : {};
}

function signInText(error: ApiError): string {
  if (error.code !== "unauthenticated") return error.message;
  return say("page_sign_in.wrong");
}
