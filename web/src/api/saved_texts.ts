import { useState } from "preact/hooks";
import { ok } from "../base/result";
import type { Client } from "./client";
import { type ApiError, type ApiResult, seen } from "./http";
import type { SavedText } from "./types";
import { useChange } from "./use_change";
import { useRequest } from "./use_request";

// Texts for remarks, which the server keeps for those who teach.
export interface SavedTexts {
  readonly texts: readonly SavedText[]; // one's own first
  readonly busy: boolean;
  readonly error: ApiError | undefined; // why the last change was refused
  readonly made: Made | undefined;
  // Each says whether it was done.
  readonly save: (text: string, shared?: boolean) => Promise<boolean>;
  readonly replace: (row: SavedText, to: Pick<SavedText, "text" | "shared">) => Promise<boolean>;
  readonly remove: (row: SavedText) => Promise<boolean>;
}

// The last change that can be undone.
interface Made {
  readonly what: "removed" | "unshared";
  readonly text: string;
  readonly undo: () => Promise<boolean>;
}

export function useSavedTexts(client: Client): SavedTexts {
  const { loaded, reload } = useRequest("saved texts", async (signal) => {
    const all = await client.all("/saved-texts", { signal });
    return all.ok ? ok(ownFirst(all.value)) : all;
  });
  const change = useChange();
  const [made, setMade] = useState<Made>();
  const run = async <T>(ask: () => Promise<ApiResult<T>>, then: (value: T) => Made | undefined) => {
    const result = await change.run(ask);
    // Somebody else changed it, or it is gone: what there is now is shown, with the reason.
    if (result !== undefined) reload();
    if (result?.ok !== true) return false;
    setMade(then(result.value));
    return true;
  };
  const save = (text: string, shared = false) =>
    run(
      () => client.post("/saved-texts", { body: { text: text.trim(), shared } }),
      () => undefined,
    );
  const replace = (row: SavedText, to: Pick<SavedText, "text" | "shared">): Promise<boolean> =>
    run(
      () => client.put("/saved-texts/{id}", { ...seen(row), body: { text: to.text.trim(), shared: to.shared } }),
      (now) =>
        row.shared && !now.shared
          ? { what: "unshared", text: now.text, undo: () => replace(now, { text: now.text, shared: true }) }
          : undefined,
    );
  const remove = (row: SavedText) =>
    run(
      () => client.delete("/saved-texts/{id}", seen(row)),
      () => ({ what: "removed", text: row.text, undo: () => save(row.text, row.shared) }),
    );
  const { busy, error } = change;
  return { texts: loaded.state === "ready" ? loaded.value : [], busy, error, made, save, replace, remove };
}

// Each part stays newest first, as the server lists them.
export function ownFirst(texts: readonly SavedText[]): SavedText[] {
  return [...texts.filter(({ mine }) => mine), ...texts.filter(({ mine }) => !mine)];
}

// What is being written, with a saved text after it.
export function withText(written: string, text: string): string {
  return written.trim() === "" ? text : `${written.trimEnd()} ${text}`;
}

// Those that have every word of `sought`, wherever it stands.
export function foundIn(texts: readonly SavedText[], sought: string): readonly SavedText[] {
  const words = sought.toLocaleLowerCase().split(/\s+/).filter(Boolean);
  return texts.filter(({ text, owner }) => {
    const all = `${text} ${owner.display_name}`.toLocaleLowerCase();
    return words.every((word) => all.includes(word));
  });
}
