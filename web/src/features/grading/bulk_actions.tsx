import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { type ApiResult, seen } from "../../api/http";
import type { Attempt, AttemptDetail } from "../../api/types";
import { say } from "../../base/words";
import { Notice } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { Confirm } from "../../widgets/dialog";
import { LongTextField } from "../../widgets/form";
import { forEach, type Outcome } from "./bulk";

export type Chosen = Pick<Attempt, "id" | "person" | "state" | "released" | "revision">;

interface Props {
  readonly client: Client;
  readonly chosen: readonly Chosen[];
  readonly onDone: () => void;
}

interface Told {
  readonly text: string;
  readonly outcome: Outcome<Chosen>;
  readonly undo?: () => Promise<void>;
}

// One thing done to every attempt that is chosen. Each is a request of its own, so that one that is
// refused stops no other.
export function BulkActions({ client, chosen, onDone }: Props) {
  const [asking, setAsking] = useState<"excuse" | "rescore">();
  const [reason, setReason] = useState("");
  const [running, setRunning] = useState<string>();
  const [told, setTold] = useState<Told>();
  const run = async (
    items: readonly Chosen[],
    doing: "taking_back" | "releasing" | "excusing" | "rescoring",
    text: (count: number) => string,
    change: (attempt: Chosen) => Promise<ApiResult<unknown>>,
  ) => {
    setTold(undefined);
    const outcome = await forEach(items, change, (count) =>
      setRunning(say(`bulk.${doing}`, { count, of: items.length })),
    );
    setRunning(undefined);
    onDone();
    setTold({ text: text(outcome.done.length), outcome });
    return outcome;
  };
  // Each change counts: an attempt is read again before one is taken back.
  const onNow = async ({ id }: Chosen, change: (now: AttemptDetail) => Promise<ApiResult<unknown>>) => {
    const now = await client.get("/attempts/{id}", { id });
    return now.ok ? change(now.value) : now;
  };
  const offerUndo = (
    done: readonly Chosen[],
    text: (count: number) => string,
    change: (now: AttemptDetail) => Promise<ApiResult<unknown>>,
  ) => {
    if (done.length === 0) return;
    const undo = async () => {
      await run(done, "taking_back", text, (attempt) => onNow(attempt, change));
    };
    setTold((now) => (now === undefined ? now : { ...now, undo }));
  };
  const busy = running !== undefined;
  const releasable = chosen.filter((attempt) => attempt.state === "scored" && !attempt.released);
  const release = async () => {
    const { done } = await run(
      releasable,
      "releasing",
      (count) => say("bulk.released", { count: count }),
      (attempt) => client.post("/attempts/{id}/release", seen(attempt)),
    );
    offerUndo(
      done,
      (count) => say("bulk.release_undone", { count: count }),
      (now) => client.delete("/attempts/{id}/release", seen(now)),
    );
  };
  const excuse = async () => {
    const { done } = await run(
      chosen,
      "excusing",
      (count) => say("bulk.excused", { count: count }),
      (attempt) => client.post("/attempts/{id}/excuse", { ...seen(attempt), body: { reason: reason.trim() } }),
    );
    offerUndo(
      done,
      (count) => say("bulk.count_again", { count }),
      (now) => client.delete("/attempts/{id}/excuse", seen(now)),
    );
  };
  const rescore = async () => {
    // What counted before, so that it can count again.
    const before = new Map<string, number>();
    const { done } = await run(
      chosen,
      "rescoring",
      (count) => say("bulk.rescored", { count: count }),
      async ({ id }) => {
        const runs = await client.all("/attempts/{id}/results", { id });
        if (!runs.ok) return runs;
        const newest = runs.value[0];
        if (newest !== undefined) before.set(id, newest.run);
        return client.post("/attempts/{id}/rescore", { id });
      },
    );
    offerUndo(
      done.filter(({ id }) => before.has(id)),
      (count) => say("bulk.earlier_score", { count: count }),
      (now) => client.post("/attempts/{id}/restore-result", { ...seen(now), body: { run: before.get(now.id)! } }),
    );
  };
  return (
    <div class="bulk" aria-live="polite">
      {chosen.length > 0 && (
        <div class="button-row" role="group" aria-label={say("bulk.with_chosen")}>
          <span>{say("bulk.chosen", { count: chosen.length })}</span>
          <Button
            busy={busy}
            blocked={releasable.length === 0 ? say("bulk.none_waits") : undefined}
            onClick={() => void release()}
          >
            {releasable.length === 0 ? say("judge.release") : say("bulk.release", { count: releasable.length })}
          </Button>
          <button type="button" class="button" disabled={busy} onClick={() => setAsking("rescore")}>
            {say("judge.rescore_ask")}
          </button>
          <button type="button" class="button" disabled={busy} onClick={() => setAsking("excuse")}>
            {say("judge.excuse_ask")}
          </button>
        </div>
      )}
      {running !== undefined && <p role="status">{running}</p>}
      {told !== undefined && (
        <Notice tone={told.outcome.failed.length > 0 ? "warning" : "good"} title={told.text}>
          {told.outcome.failed.length > 0 && (
            <ul>
              {told.outcome.failed.map(({ item, message }) => (
                <li key={item.id}>
                  {item.person.display_name}: {message}
                </li>
              ))}
            </ul>
          )}
          {told.undo !== undefined && (
            <button type="button" class="button small" disabled={busy} onClick={() => void told.undo?.()}>
              {say("edit.undo")}
            </button>
          )}
        </Notice>
      )}
      {asking === "rescore" && (
        <Confirm
          title={say("bulk.rescore_title", { count: chosen.length })}
          action={say("judge.rescore")}
          tone="neutral"
          onClose={() => setAsking(undefined)}
          onConfirm={async () => {
            void rescore();
            return undefined;
          }}
        >
          <p>{say("bulk.rescore_text")}</p>
        </Confirm>
      )}
      {asking === "excuse" && (
        <Confirm
          title={say("bulk.excuse_title", { count: chosen.length })}
          action={say("judge.excuse")}
          onClose={() => setAsking(undefined)}
          onConfirm={async () => {
            if (reason.trim() === "") return say("judge.say_why");
            void excuse();
            return undefined;
          }}
        >
          <p>{say("bulk.excuse_text")}</p>
          <LongTextField
            label={say("bulk.excuse_why")}
            value={reason}
            onValue={setReason}
            required
            maxLength={1000}
            rows={3}
          />
        </Confirm>
      )}
    </div>
  );
}
