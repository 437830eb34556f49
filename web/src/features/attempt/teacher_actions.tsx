import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ApiResult } from "../../api/http";
import type { AttemptDetail } from "../../api/types";
import { useChange } from "../../api/use_change";
import { formatScore, kScoreStep, scoreForField } from "../../base/format";
import { awaitsRelease } from "../../widgets/attempt_state";
import { Badge, ErrorNotice, Notice } from "../../widgets/basics";
import { Confirm } from "../../widgets/dialog";
import { CheckField, LongTextField, NumberField, TextField } from "../../widgets/form";

interface Props {
  readonly client: Client;
  readonly attempt: AttemptDetail;
  readonly graded: boolean;
  readonly onChanged: () => void;
  readonly onNext: (() => void) | undefined;    // to the next one of a list that is gone through
  readonly releaseNext: { current: (() => void) | undefined };  // set to what releases and goes on, while that may be done
}

type Open = "excuse" | "reference" | "override" | "withdraw" | "dropOverride" | "rescore";

// What an instructor can do with an attempt: release its score or take that back, set another score,
// score it again, excuse it, make it the reference.
export function TeacherActions({ client, attempt, graded, onChanged, onNext, releaseNext }: Props) {
  const [open, setOpen] = useState<Open>();
  const [done, setDone] = useState<string>();
  const change = useChange();
  const { teaching } = client;

  const finish = (text: string) => {
    setOpen(undefined);
    setDone(text);
    onChanged();
  };
  const confirm = async (ask: Promise<ApiResult<unknown>>, text: string) => {
    const result = await ask;
    if (!result.ok) return result.error.message;
    finish(text);
    return undefined;
  };
  const act = async (ask: () => Promise<ApiResult<unknown>>, text: string) => {
    const result = await change.run(ask);
    if (result?.ok === true) finish(text);
  };
  const student = attempt.person.display_name;
  const may = (action: AttemptDetail["may"][number]) => attempt.may.includes(action);

  const releasable = may("release") && awaitsRelease(attempt, graded);
  const releaseAndNext = async () => {
    const result = await change.run(() => teaching.release(attempt));
    if (result?.ok === true) onNext?.();
  };
  releaseNext.current = onNext === undefined ? undefined : releasable ? () => void releaseAndNext() : onNext;
  return (
    <div class="actions">
      <div class="button-row">
        {attempt.released && <Badge tone="good">Score released</Badge>}
        {releasable && onNext !== undefined && (
          <button type="button" class="button primary" disabled={change.busy} onClick={() => void releaseAndNext()}>Release and next</button>
        )}
        {releasable && (
          <button type="button" class={onNext === undefined ? "button primary" : "button"} disabled={change.busy}
                  onClick={() => void act(() => teaching.release(attempt), `${student} can see the score now.`)}>
            Release score
          </button>
        )}
        {graded && may("unrelease") && <button type="button" class="button" onClick={() => setOpen("withdraw")}>Take release back…</button>}
        {may("override") && <button type="button" class="button" aria-expanded={open === "override"} onClick={() => setOpen(open === "override" ? undefined : "override")}>
          {attempt.override === null ? "Set another score…" : "Change the set score…"}
        </button>}
        {may("override") && attempt.override !== null && <button type="button" class="button" onClick={() => setOpen("dropOverride")}>Remove the set score…</button>}
        {may("rescore") && <button type="button" class="button" onClick={() => setOpen("rescore")}>Score again…</button>}
        {may("excuse") && <button type="button" class="button" aria-expanded={open === "excuse"} onClick={() => setOpen(open === "excuse" ? undefined : "excuse")}>Excuse…</button>}
        {may("unexcuse") && <button type="button" class="button" disabled={change.busy} onClick={() => void act(() => teaching.takeExcuseBack(attempt), "The attempt counts again.")}>Take excuse back</button>}
        {attempt.is_reference ? <Badge tone="good">Reference of its exercise</Badge> : may("mark_reference") && (
          <button type="button" class="button" aria-expanded={open === "reference"} onClick={() => setOpen(open === "reference" ? undefined : "reference")}>Mark as reference…</button>
        )}
      </div>
      {open === "reference" && (
        <ReferenceForm busy={change.busy} onCancel={() => setOpen(undefined)}
                       onName={(dentist, consent) => void act(() => teaching.makeReference(attempt.id, dentist, consent),
                                                              "The attempt is the reference of its exercise now. Earlier scores keep theirs.")} />
      )}
      {open === "override" && (
        <OverrideForm attempt={attempt} busy={change.busy} onCancel={() => setOpen(undefined)}
                      onScore={(score, reason) => void act(() => teaching.override(attempt, score, reason), `The score counts as ${formatScore(score)} now.`)} />
      )}
      {open === "excuse" && (
        <ExcuseForm busy={change.busy} onCancel={() => setOpen(undefined)}
                    onReason={(reason) => void act(() => teaching.excuse(attempt, reason), "The attempt does not count against the limit any more.")} />
      )}
      {open === "withdraw" && (
        <Confirm title="Take the release back?" action="Take release back" onClose={() => setOpen(undefined)}
                 onConfirm={() => confirm(teaching.withdrawRelease(attempt), `${student} does not see the score any more.`)}>
          <p>{student} will not see score, deviation and remarks any more, and may have seen them already. You can release again at any time.</p>
        </Confirm>
      )}
      {open === "dropOverride" && (
        <Confirm title="Remove the set score?" action="Remove the set score" onClose={() => setOpen(undefined)}
                 onConfirm={() => confirm(teaching.dropOverride(attempt), "The computed score counts again.")}>
          <p>The computed score counts again. The audit keeps what was set and why.</p>
        </Confirm>
      )}
      {open === "rescore" && (
        <Confirm title="Score this attempt again?" action="Score again" tone="neutral" onClose={() => setOpen(undefined)}
                 onConfirm={() => confirm(teaching.rescore(attempt.id), "The attempt waits to be scored again.")}>
          <p>The recording is replayed and compared with the exercise's newest reference. The score it has now stays in its history.</p>
        </Confirm>
      )}
      <div aria-live="polite">
        {change.error !== undefined && <ErrorNotice title="Not done" message={change.error.message} />}
        {done !== undefined && change.error === undefined && <Notice tone="good" title="Done"><p>{done}</p></Notice>}
      </div>
    </div>
  );
}

function ReferenceForm({ busy, onName, onCancel }:
                       { readonly busy: boolean; readonly onName: (dentist: string, consent: boolean) => void; readonly onCancel: () => void }) {
  const [dentist, setDentist] = useState("");
  const [consent, setConsent] = useState(false);
  const submit = (event: Event) => {
    event.preventDefault();
    if (dentist.trim() !== "" && consent) onName(dentist.trim(), consent);
  };
  return (
    <form class="inline-form" onSubmit={submit}>
      <TextField label="Dentist who made this cut" required maxLength={200} value={dentist} onValue={setDentist} />
      <CheckField label="The dentist agrees to being named and to the cut being used" value={consent} onValue={setConsent} />
      <div class="button-row">
        <button type="submit" class="button primary" disabled={busy || !consent}>Mark as reference</button>
        <button type="button" class="button" onClick={onCancel}>Cancel</button>
      </div>
    </form>
  );
}

function ExcuseForm({ busy, onReason, onCancel }: { readonly busy: boolean; readonly onReason: (reason: string) => void; readonly onCancel: () => void }) {
  const [reason, setReason] = useState("");
  const submit = (event: Event) => {
    event.preventDefault();
    if (reason.trim() !== "") onReason(reason.trim());
  };
  return (
    <form class="inline-form" onSubmit={submit}>
      <LongTextField label="Why this attempt does not count" hint="It then counts neither against the attempt limit nor as a running exam. This cannot be taken back."
                     value={reason} onValue={setReason} required maxLength={1000} rows={3} />
      <div class="button-row">
        <button type="submit" class="button primary" disabled={busy}>Excuse the attempt</button>
        <button type="button" class="button" onClick={onCancel}>Cancel</button>
      </div>
    </form>
  );
}

function OverrideForm({ attempt, busy, onScore, onCancel }:
    { readonly attempt: AttemptDetail; readonly busy: boolean; readonly onScore: (score: number, reason: string) => void; readonly onCancel: () => void }) {
  const [score, setScore] = useState(scoreForField(attempt.override?.score ?? attempt.score ?? Number.NaN));
  const [reason, setReason] = useState(attempt.override?.reason ?? "");
  const submit = (event: Event) => {
    event.preventDefault();
    if (Number.isFinite(score) && reason.trim() !== "") onScore(score, reason.trim());
  };
  return (
    <form class="inline-form" onSubmit={submit}>
      <NumberField label="Score that counts, 0 to 100" value={score} onValue={setScore} min={0} max={100} step={kScoreStep}
                   {...(attempt.computed_score === null ? {} : { hint: `Computed: ${formatScore(attempt.computed_score)}. It stays visible beside yours.` })} />
      <LongTextField label="Reason" hint="The student reads it." value={reason} onValue={setReason} required maxLength={1000} rows={3} />
      <div class="button-row">
        <button type="submit" class="button primary" disabled={busy}>Set this score</button>
        <button type="button" class="button" onClick={onCancel}>Cancel</button>
      </div>
    </form>
  );
}
