import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";
import type { ApiResult } from "../api/http";
import type { AttemptDetail } from "../api/types";
import { say } from "../base/words";
import { ErrorNotice, Notice } from "./basics";
import type { Key } from "./keys";

// Undoes a release that one key made: offered on the screen that comes next, and taken back there
// by a key of its own or by a button.

export interface ReleaseUndo {
  readonly keys: readonly Key[]; // none where there is nothing to take back
  readonly notice: ComponentChildren;
}

let last: AttemptDetail | undefined; // for the screen that comes next

export function releaseMade(attempt: AttemptDetail): void {
  last = attempt;
}

type State = "made" | "busy" | "back";

export function useReleaseUndo(takeBack: (id: string) => Promise<ApiResult<unknown>>): ReleaseUndo {
  const [attempt] = useState(() => {
    const was = last;
    last = undefined;
    return was;
  });
  const [state, setState] = useState<State>("made");
  const [error, setError] = useState<string>();
  if (attempt === undefined) return { keys: [], notice: undefined };
  const act = async () => {
    setState("busy");
    const result = await takeBack(attempt.id);
    setState(result.ok ? "back" : "made");
    setError(result.ok ? undefined : result.error.message);
    // The button may have had the focus and has gone.
    if (document.activeElement === document.body) document.querySelector("h1")?.focus();
  };
  return {
    keys: state === "made" ? [{ key: "w", what: say("judge.withdraw"), act: () => void act() }] : [],
    notice: (
      <div role="status" class="no-print">
        <Notice
          tone="good"
          title={say(state === "back" ? "judge.cannot_see" : "judge.can_see", { name: attempt.person.display_name })}
        >
          {state !== "back" && (
            <button
              type="button"
              class="button small"
              aria-keyshortcuts="w"
              disabled={state === "busy"}
              onClick={() => void act()}
            >
              {say("judge.withdraw")} <kbd>w</kbd>
            </button>
          )}
        </Notice>
        {error !== undefined && <ErrorNotice title={say("common.not_done")} message={error} />}
      </div>
    ),
  };
}
