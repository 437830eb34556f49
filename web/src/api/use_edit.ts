import { useState } from "preact/hooks";
import type { ApiError, ApiResult, Tagged } from "./http";
import { useChange } from "./use_change";

export interface Edit<T> {
  readonly draft: T;
  readonly set: (change: Partial<T>) => void;
  readonly changed: boolean; // against what was read
  readonly busy: boolean;
  readonly saved: boolean; // the last save went through and nothing was changed since
  readonly error: ApiError | undefined; // other than a conflict
  readonly newer: T | undefined; // somebody else saved this meanwhile
  readonly problemOf: (field: string) => string | undefined; // what the server found wrong with a field
  readonly save: () => Promise<void>;
  readonly takeTheirs: () => void;
  readonly keepMine: () => Promise<void>;
}

// What the server answered, with the members that were edited while the answer was on its way.
export function withLaterEdits<T extends object>(answered: T, sent: T, now: T): T {
  const later = Object.entries(now).filter(([name, value]) => value !== sent[name as keyof T]);
  return { ...answered, ...Object.fromEntries(later) };
}

// Editing one thing that others may edit too. Begins with `read`; `write` sends the draft with the
// tag of what was read. When somebody else was faster, nothing is lost: `newer` has theirs, `draft`
// mine. `onRead` hears of every newer state that becomes known: saved, or taken over from somebody
// else.
export function useEdit<T extends object>(
  read: Tagged<T>,
  write: (draft: T, tag: string) => Promise<ApiResult<Tagged<T>>>,
  onRead: (read: Tagged<T>) => void = () => {},
): Edit<T> {
  const [base, setBase] = useState(read);
  const [draft, setDraft] = useState(read.value);
  const [newer, setNewer] = useState<Tagged<T>>();
  const [saved, setSaved] = useState(false);
  const change = useChange();
  const changed = JSON.stringify(draft) !== JSON.stringify(base.value);

  const send = async (tag: string) => {
    const result = await change.run(() => write(draft, tag));
    if (result === undefined) return;
    if (!result.ok) {
      setNewer(result.error.current as Tagged<T> | undefined);
      return;
    }
    adopt(result.value, (now) => withLaterEdits(result.value.value, draft, now));
    setSaved(true);
  };
  const adopt = (tagged: Tagged<T>, next: (now: T) => T = () => tagged.value) => {
    setBase(tagged);
    setDraft(next);
    setNewer(undefined);
    onRead(tagged);
  };

  return {
    draft,
    busy: change.busy,
    newer: newer?.value,
    saved: saved && !changed,
    changed,
    error: newer === undefined ? change.error : undefined,
    set: (part) => {
      setSaved(false);
      setDraft((now) => ({ ...now, ...part }));
    },
    problemOf: (field) => (change.error?.field === field ? change.error.message : undefined),
    save: () => send(base.tag),
    takeTheirs: () => {
      if (newer !== undefined) adopt(newer);
      change.clear();
    },
    keepMine: () => send(newer?.tag ?? base.tag),
  };
}
