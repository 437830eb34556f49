import { useState } from "preact/hooks";
import type { ApiError } from "../api/http";
import { say } from "../base/words";
import { LongTextField } from "./form";

// The field of a refusal that whoever asks may overrule with a reason (openapi.yaml, "Anyway").
const kAnyway = "anyway";

// The reason, once `about` was refused without one. It stays asked for whatever the next answer is,
// until it is about something else.
export function useAnyway(error: ApiError | undefined, about: string) {
  const [text, setText] = useState("");
  const [refused, setRefused] = useState<{ readonly error: ApiError; readonly about: string }>();
  if (error?.field === kAnyway && refused?.error !== error) setRefused({ error, about });
  const asked = refused?.about === about;
  const reason = text.trim();
  return { asked, reason: asked ? reason : "", missing: asked && reason === "", text, setText };
}

export function AnywayField({ anyway }: { readonly anyway: ReturnType<typeof useAnyway> }) {
  if (!anyway.asked) return null;
  return (
    <LongTextField
      label={say("anyway.why")}
      hint={say("anyway.hint")}
      value={anyway.text}
      onValue={anyway.setText}
      required
      maxLength={1000}
      rows={2}
    />
  );
}
