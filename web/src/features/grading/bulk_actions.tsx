import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ApiResult } from "../../api/http";
import type { Attempt, AttemptDetail } from "../../api/types";
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
  // Each change counts: an attempt is read again before one is taken back.
  const onNow = async ({ id }: Attempt, change: (now: AttemptDetail) => Promise<ApiResult<unknown>>) => {
    const now = await client.attempt(id);
    return now.ok ? change(now.value) : now;
  };
  const offerUndo = (done: readonly Attempt[], text: (count: number) => string, change: (now: AttemptDetail) => Promise<ApiResult<unknown>>) => {
    if (done.length === 0) return;
    const undo = async () => { await run(done, "Taken back", text, (attempt) => onNow(attempt, change)); };
    setTold((now) => now === undefined ? now : { ...now, undo });
  };
  const releasable = chosen.filter((attempt) => attempt.state === "scored" && !attempt.released);
  const release = async () => {
    const { done } = await run(releasable, "Released", (count) => `${plural(count, "score")} released.`, (attempt) => teaching.release(attempt));
    offerUndo(done, (count) => `${plural(count, "release")} taken back.`, (now) => teaching.withdrawRelease(now));
  };
  const excuse = async () => {
    const { done } = await run(chosen, "Excused", (count) => `${plural(count, "attempt")} excused.`, (attempt) => teaching.excuse(attempt, reason.trim()));
    offerUndo(done, (count) => `${plural(count, "attempt")} ${count === 1 ? "counts" : "count"} again.`, (now) => teaching.takeExcuseBack(now));
  };
  const rescore = async () => {
    // What counted before, so that it can count again.
    const before = new Map<string, number>();
    const { done } = await run(chosen, "Asked for", (count) => `${plural(count, "attempt")} to be scored again.`, async ({ id }) => {
      const runs = await teaching.results(id);
      if (!runs.ok) return runs;
      const newest = runs.value[0];
      if (newest !== undefined) before.set(id, newest.run);
      return teaching.rescore(id);
    });
    offerUndo(done.filter(({ id }) => before.has(id)), (count) => `The earlier score of ${plural(count, "attempt")} counts again.`,
              (now) => teaching.restoreResult(now, before.get(now.id)!));
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
                 onConfirm={async () => { void rescore(); return undefined; }}>
          <p>Each recording is replayed and compared with the exercise's newest reference. The scores there are now stay in the history.</p>
        </Confirm>
      )}
      {asking === "excuse" && (
        <Confirm title={`Excuse ${plural(chosen.length, "attempt")}?`} action="Excuse" onClose={() => setAsking(undefined)}
                 onConfirm={async () => {
                   if (reason.trim() === "") return "Say why: the reason is kept.";
                   void excuse();
                   return undefined;
                 }}>
          <p>They count neither against the attempt limit nor as a running exam.</p>
          <LongTextField label="Why they do not count" value={reason} onValue={setReason} required maxLength={1000} rows={3} />
        </Confirm>
      )}
    </div>
  );
}
