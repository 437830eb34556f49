import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ApiResult } from "../../api/http";
import type { Attempt } from "../../api/types";
import { plural } from "../../base/format";
import { Notice } from "../../widgets/basics";
import { Confirm } from "../../widgets/dialog";
import { LongTextField } from "../../widgets/form";
import { forEach, type Outcome } from "./bulk";

interface Props {
  readonly client: Client;
  readonly chosen: readonly Attempt[];
  readonly onDone: () => void;
}

interface Told {
  readonly text: string;
  readonly outcome: Outcome<Attempt>;
  readonly undo?: () => Promise<void>;
}

// One thing done to every attempt that is chosen. Each is asked for by itself, so that one that is refused stops no other.
export function BulkActions({ client, chosen, onDone }: Props) {
  const [asking, setAsking] = useState<"excuse" | "rescore">();
  const [reason, setReason] = useState("");
  const [running, setRunning] = useState<string>();
  const [told, setTold] = useState<Told>();
  const { teaching } = client;
  const run = async (items: readonly Attempt[], doing: string, text: (count: number) => string, change: (attempt: Attempt) => Promise<ApiResult<unknown>>) => {
    setTold(undefined);
    const outcome = await forEach(items, change, (count) => setRunning(`${doing} ${count} of ${items.length}`));
    setRunning(undefined);
    onDone();
    setTold({ text: text(outcome.done.length), outcome });
    return outcome;
  };
  const releasable = chosen.filter((attempt) => attempt.state === "scored" && !attempt.released);
  const release = async () => {
    const { done } = await run(releasable, "Released", (count) => `${plural(count, "score")} released.`, (attempt) => teaching.release(attempt));
    if (done.length === 0) return;
    const undo = async () => {
      // Releasing counts as a change: each is read again before its release is taken back.
      await run(done, "Taken back", (count) => `${plural(count, "release")} taken back.`, async ({ id }) => {
        const now = await client.attempt(id);
        return now.ok ? teaching.withdrawRelease(now.value) : now;
      });
    };
    setTold((now) => now === undefined ? now : { ...now, undo });
  };
  return (
    <div class="bulk" aria-live="polite">
      {chosen.length > 0 && (
        <div class="button-row" role="group" aria-label="With the chosen attempts">
          <span>{plural(chosen.length, "attempt")} chosen:</span>
          <button type="button" class="button primary" disabled={running !== undefined || releasable.length === 0} onClick={() => void release()}>Release {releasable.length}</button>
          <button type="button" class="button" disabled={running !== undefined} onClick={() => setAsking("rescore")}>Score again…</button>
          <button type="button" class="button" disabled={running !== undefined} onClick={() => setAsking("excuse")}>Excuse…</button>
        </div>
      )}
      {running !== undefined && <p role="status">{running}</p>}
      {told !== undefined && (
        <Notice tone={told.outcome.failed.length > 0 ? "warning" : "good"} title={told.text}>
          {told.outcome.failed.length > 0 && <ul>{told.outcome.failed.map(({ item, message }) => <li key={item.id}>{item.person.display_name}: {message}</li>)}</ul>}
          {told.undo !== undefined && <button type="button" class="button small" disabled={running !== undefined} onClick={() => void told.undo?.()}>Undo</button>}
        </Notice>
      )}
      {asking === "rescore" && (
        <Confirm title={`Score ${plural(chosen.length, "attempt")} again?`} action="Score again" tone="neutral" onClose={() => setAsking(undefined)}
                 onConfirm={async () => { void run(chosen, "Asked for", (count) => `${plural(count, "attempt")} to be scored again.`, ({ id }) => teaching.rescore(id)); return undefined; }}>
          <p>Each recording is replayed and compared with the exercise's newest reference. The scores there are now stay in the history.</p>
        </Confirm>
      )}
      {asking === "excuse" && (
        <Confirm title={`Excuse ${plural(chosen.length, "attempt")}?`} action="Excuse" onClose={() => setAsking(undefined)}
                 onConfirm={async () => {
                   if (reason.trim() === "") return "Say why: the reason is kept.";
                   void run(chosen, "Excused", (count) => `${plural(count, "attempt")} excused.`, (attempt) => teaching.excuse(attempt, reason.trim()));
                   return undefined;
                 }}>
          <p>They count neither against the attempt limit nor as a running exam. This cannot be taken back.</p>
          <LongTextField label="Why they do not count" value={reason} onValue={setReason} required maxLength={1000} rows={3} />
        </Confirm>
      )}
    </div>
  );
}
