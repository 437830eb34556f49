import { useEffect, useRef, useState } from "preact/hooks";
import { begun, changed, equal, type History, type Json, type Path, redone, undone, valueAt } from "../base/document";

// A document while it is edited. What was typed outlives the loss of the session and of the page,
// in this tab only.
export interface EditedDocument {
  readonly now: Json;
  readonly dirty: boolean; // it is not as it was read
  readonly kept: boolean; // it was found as it was left
  readonly canUndo: boolean;
  readonly canRedo: boolean;
  readonly at: (path: Path) => Json | undefined;
  readonly set: (path: Path, value: Json | undefined) => void;
  readonly undo: () => void;
  readonly redo: () => void;
  readonly discard: () => void; // back to what was read
  readonly forget: () => void; // it is saved: nothing is kept in the tab
}

export function useDocument(name: string, read: Json): EditedDocument {
  const key = `enamel.editing.${name}`;
  const found = useRef<Json | undefined>(undefined);
  const [history, setHistory] = useState<History>(() => {
    found.current = load(key);
    return found.current === undefined || equal(found.current, read)
      ? begun(read)
      : { ...begun(read), past: [read], now: found.current };
  });
  const dirty = !equal(history.now, read);
  const saved = useRef(false);
  useEffect(() => {
    if (!saved.current) keep(key, dirty ? history.now : undefined);
  }, [key, dirty, history.now]);
  return {
    now: history.now,
    dirty,
    kept: found.current !== undefined && !equal(found.current, read) && dirty,
    canUndo: history.past.length > 0,
    canRedo: history.future.length > 0,
    at: (path) => valueAt(history.now, path),
    set: (path, value) => setHistory((before) => changed(before, path, value)),
    undo: () => setHistory(undone),
    redo: () => setHistory(redone),
    discard: () => {
      found.current = undefined;
      setHistory((before) => changed(before, [], read));
    },
    forget: () => {
      saved.current = true;
      keep(key, undefined);
    },
  };
}

function load(key: string): Json | undefined {
  try {
    const text = sessionStorage.getItem(key);
    return text === null ? undefined : (JSON.parse(text) as Json);
  } catch {
    return undefined;
  }
}

function keep(key: string, value: Json | undefined): void {
  try {
    if (value === undefined) sessionStorage.removeItem(key);
    else sessionStorage.setItem(key, JSON.stringify(value));
  } catch {
    // Then it lives as long as the page, which is what a browser that keeps nothing is meant to do.
  }
}
