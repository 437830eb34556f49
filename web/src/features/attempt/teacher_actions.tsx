import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { type ApiError, type ApiResult, seen, type Tagged } from "../../api/http";
import type { AttemptDetail } from "../../api/types";
import { useChange } from "../../api/use_change";
import { keepDraft } from "../../base/drafts";
import { formatScore, kScoreStep, scoreForField } from "../../base/format";
import { say } from "../../base/words";
import { AnywayField, useAnyway } from "../../widgets/anyway";
import { awaitsRelease } from "../../widgets/attempt_state";
import { Badge, ErrorNotice, Loading, Notice } from "../../widgets/basics";
import { Button, needed } from "../../widgets/button";
import { Conflict, type Difference } from "../../widgets/conflict";
import { Confirm } from "../../widgets/dialog";
import { releaseMade } from "../../widgets/release_undo";
import { CheckField, LongTextField, NumberField, TextField } from "../../widgets/form";
import { useDraft } from "../../widgets/use_draft";
import type { Rescore } from "./use_rescore";

interface Props {
  readonly client: Client;
  readonly attempt: AttemptDetail;
  readonly graded: boolean;
  readonly onChanged: () => void;
  readonly rescore: Rescore;
  readonly onNext: (() => void) | undefined; // to the next one of a list that is gone through
  readonly releaseNext: { current: (() => void) | undefined }; // set to what releases and goes on, while that may be done
}

type Open = "excuse" | "reference" | "override" | "withdraw" | "dropOverride" | "rescore";

// What an instructor can do with an attempt: release its score or take that back, set another
// score, score it again, excuse it, make it the reference.
export function TeacherActions({ client, attempt, graded, onChanged, rescore, onNext, releaseNext }: Props) {
  const [open, setOpen] = useState<Open>();
  const [done, setDone] = useState<string>();
  const change = useChange();

  // Closes a form whose text was sent or given up.
  const close = () => {
    if (open === "excuse" || open === "override") keepDraft(`${open} ${attempt.id}`, { text: "" });
    setOpen(undefined);
  };
  const finish = (text: string | undefined) => {
    close();
    setDone(text);
    onChanged();
  };
  // What somebody else did meanwhile is shown, and the next try is about that.
  const refused = ({ current, message }: ApiError) => {
    if (current !== undefined) onChanged();
    return message;
  };
  const confirm = async (ask: Promise<ApiResult<unknown>>, text: string | undefined) => {
    const result = await ask;
    if (!result.ok) return refused(result.error);
    finish(text);
    return undefined;
  };
  const act = async (ask: () => Promise<ApiResult<unknown>>, text: string) => {
    const result = await change.run(ask);
    if (result?.ok === true) finish(text);
    else if (result !== undefined && open !== "override") refused(result.error);
  };
  const override = (about: Pick<AttemptDetail, "id" | "revision">, score: number, reason: string) =>
    void act(
      () => client.put("/attempts/{id}/override", { ...seen(about), body: { score, reason } }),
      say("judge.score_counts", { score: formatScore(score) }),
    );
  const newer = open === "override" ? (change.error?.current as Tagged<AttemptDetail> | undefined)?.value : undefined;
  const student = attempt.person.display_name;
  const may = (action: AttemptDetail["may"][number]) => attempt.may.includes(action);

  const releasable = may("release") && awaitsRelease(attempt, graded);
  const releaseAndNext = async () => {
    const result = await change.run(() => client.post("/attempts/{id}/release", seen(attempt)));
    if (result?.ok === false) refused(result.error);
    if (result?.ok !== true) return;
    releaseMade(attempt);
    onNext?.();
  };
  releaseNext.current = onNext === undefined ? undefined : releasable ? () => void releaseAndNext() : onNext;
  return (
    <div class="actions">
      <div class="button-row">
        {attempt.released && <Badge tone="good">{say("judge.released")}</Badge>}
        {releasable && onNext !== undefined && (
          <button type="button" class="button primary" disabled={change.busy} onClick={() => void releaseAndNext()}>
            {say("judge.release_next")}
          </button>
        )}
        {releasable && (
          <button
            type="button"
            class={onNext === undefined ? "button primary" : "button"}
            disabled={change.busy}
            onClick={() =>
              void act(
                () => client.post("/attempts/{id}/release", seen(attempt)),
                say("judge.can_see", { name: student }),
              )
            }
          >
            {say("judge.release")}
          </button>
        )}
        {graded && may("unrelease") && (
          <button type="button" class="button" onClick={() => setOpen("withdraw")}>
            {say("judge.withdraw_ask")}
          </button>
        )}
        {may("override") && (
          <span class="opens">
            <button
              type="button"
              class="button"
              aria-expanded={open === "override"}
              onClick={() => setOpen(open === "override" ? undefined : "override")}
            >
              {attempt.override === null ? say("judge.override_ask") : say("judge.override_change")}
            </button>
            {open === "override" && (
              <OverrideForm
                attempt={attempt}
                busy={change.busy}
                newer={newer}
                onCancel={close}
                onScore={override}
                onTakeTheirs={() => {
                  change.clear();
                  close();
                  onChanged();
                }}
              />
            )}
          </span>
        )}
        {may("override") && attempt.override !== null && (
          <button type="button" class="button" onClick={() => setOpen("dropOverride")}>
            {say("judge.drop_ask")}
          </button>
        )}
        {may("rescore") && (
          <button type="button" class="button" onClick={() => setOpen("rescore")}>
            {say("judge.rescore_ask")}
          </button>
        )}
        {may("excuse") && (
          <span class="opens">
            <button
              type="button"
              class="button"
              aria-expanded={open === "excuse"}
              onClick={() => setOpen(open === "excuse" ? undefined : "excuse")}
            >
              {say("judge.excuse_ask")}
            </button>
            {open === "excuse" && (
              <ExcuseForm
                id={attempt.id}
                busy={change.busy}
                onCancel={close}
                onReason={(reason) =>
                  void act(
                    () => client.post("/attempts/{id}/excuse", { ...seen(attempt), body: { reason } }),
                    say("judge.excused"),
                  )
                }
              />
            )}
          </span>
        )}
        {may("unexcuse") && (
          <button
            type="button"
            class="button"
            disabled={change.busy}
            onClick={() =>
              void act(() => client.delete("/attempts/{id}/excuse", seen(attempt)), say("judge.counts_again"))
            }
          >
            {say("judge.unexcuse")}
          </button>
        )}
        {attempt.is_reference ? (
          <Badge tone="good">{say("judge.is_reference")}</Badge>
        ) : (
          may("mark_reference") && (
            <span class="opens">
              <button
                type="button"
                class="button"
                aria-expanded={open === "reference"}
                onClick={() => setOpen(open === "reference" ? undefined : "reference")}
              >
                {say("judge.reference_ask")}
              </button>
              {open === "reference" && (
                <ReferenceForm
                  busy={change.busy}
                  error={change.error}
                  onCancel={() => setOpen(undefined)}
                  onName={(dentist, consent, anyway) =>
                    void act(
                      () =>
                        client.post("/attempts/{id}/reference", {
                          id: attempt.id,
                          body: { dentist: dentist, consent: consent, anyway: anyway || undefined },
                        }),
                      say("judge.reference_done"),
                    )
                  }
                />
              )}
            </span>
          )
        )}
      </div>
      {open === "withdraw" && (
        <Confirm
          title={say("judge.withdraw_title")}
          action={say("judge.withdraw")}
          onClose={() => setOpen(undefined)}
          onConfirm={() =>
            confirm(client.delete("/attempts/{id}/release", seen(attempt)), say("judge.cannot_see", { name: student }))
          }
        >
          <p>{say("judge.withdraw_text", { name: student })}</p>
        </Confirm>
      )}
      {open === "dropOverride" && (
        <Confirm
          title={say("judge.drop_title")}
          action={say("judge.drop")}
          onClose={() => setOpen(undefined)}
          onConfirm={() =>
            confirm(client.delete("/attempts/{id}/override", seen(attempt)), say("judge.computed_counts"))
          }
        >
          <p>{say("judge.drop_text")}</p>
        </Confirm>
      )}
      {open === "rescore" && (
        <Confirm
          title={say("judge.rescore_title")}
          action={say("judge.rescore")}
          tone="neutral"
          onClose={() => setOpen(undefined)}
          onConfirm={() =>
            confirm(
              rescore.ask(() => client.post("/attempts/{id}/rescore", { id: attempt.id })),
              undefined,
            )
          }
        >
          <p>{say("judge.rescore_text")}</p>
        </Confirm>
      )}
      <div aria-live="polite">
        {change.error !== undefined && newer === undefined && (
          <ErrorNotice title={say("common.not_done")} message={change.error.message} />
        )}
        {rescore.state === "waiting" && <Loading what={say("judge.rescore_waits")} />}
        {rescore.state === "done" && done === undefined && (
          <Notice tone="good" title={say("judge.done")}>
            <p>{say("judge.rescored")}</p>
          </Notice>
        )}
        {done !== undefined && change.error === undefined && (
          <Notice tone="good" title={say("judge.done")}>
            <p>{done}</p>
          </Notice>
        )}
      </div>
    </div>
  );
}

interface ReferenceFormProps {
  readonly busy: boolean;
  readonly error: ApiError | undefined;
  readonly onName: (dentist: string, consent: boolean, anyway: string) => void;
  readonly onCancel: () => void;
}

function ReferenceForm({ busy, error, onName, onCancel }: ReferenceFormProps) {
  const [dentist, setDentist] = useState("");
  const [consent, setConsent] = useState(false);
  const anyway = useAnyway(error, "");
  const submit = (event: Event) => {
    event.preventDefault();
    if (dentist.trim() !== "" && consent) onName(dentist.trim(), consent, anyway.reason);
  };
  return (
    <form class="inline-form" onSubmit={submit}>
      <TextField label={say("judge.dentist")} required maxLength={200} value={dentist} onValue={setDentist} />
      <CheckField label={say("judge.consent")} value={consent} onValue={setConsent} />
      <AnywayField anyway={anyway} />
      <div class="button-row">
        <Button
          busy={busy}
          blocked={needed({
            [say("judge.dentist")]: dentist.trim(),
            [say("judge.consent")]: consent,
            [say("anyway.why")]: !anyway.missing,
          })}
        >
          {say(anyway.asked ? "judge.reference_anyway" : "judge.reference")}
        </Button>
        <button type="button" class="button" onClick={onCancel}>
          {say("common.cancel")}
        </button>
      </div>
    </form>
  );
}

function ExcuseForm({
  id,
  busy,
  onReason,
  onCancel,
}: {
  readonly id: string; // of the attempt
  readonly busy: boolean;
  readonly onReason: (reason: string) => void;
  readonly onCancel: () => void;
}) {
  const [reason, setReason] = useDraft(`excuse ${id}`);
  const submit = (event: Event) => {
    event.preventDefault();
    if (reason.trim() !== "") onReason(reason.trim());
  };
  return (
    <form class="inline-form" onSubmit={submit}>
      <LongTextField
        label={say("judge.excuse_why")}
        hint={say("judge.excuse_hint")}
        value={reason}
        onValue={setReason}
        required
        maxLength={1000}
        rows={3}
      />
      <div class="button-row">
        <button type="submit" class="button primary" disabled={busy}>
          {say("judge.excuse_attempt")}
        </button>
        <button type="button" class="button" onClick={onCancel}>
          {say("common.cancel")}
        </button>
      </div>
    </form>
  );
}

function OverrideForm({
  attempt,
  newer,
  busy,
  onScore,
  onCancel,
  onTakeTheirs,
}: {
  readonly attempt: AttemptDetail;
  readonly newer: AttemptDetail | undefined; // somebody else changed the attempt to this meanwhile
  readonly busy: boolean;
  readonly onScore: (about: AttemptDetail, score: number, reason: string) => void;
  readonly onCancel: () => void;
  readonly onTakeTheirs: () => void;
}) {
  const [score, setScore] = useState(scoreForField(attempt.override?.score ?? attempt.score ?? Number.NaN));
  const [reason, setReason] = useDraft(`override ${attempt.id}`, attempt.override?.reason ?? "");
  const submit = (event: Event) => {
    event.preventDefault();
    if (Number.isFinite(score) && reason.trim() !== "") onScore(attempt, score, reason.trim());
  };
  if (newer !== undefined)
    return (
      <div class="inline-form">
        <Conflict
          differences={overrideDifferences(newer, score, reason.trim())}
          busy={busy}
          onTakeTheirs={onTakeTheirs}
          onKeepMine={() => onScore(newer, score, reason.trim())}
        />
      </div>
    );
  return (
    <form class="inline-form" onSubmit={submit}>
      <NumberField
        label={say("judge.score_field")}
        value={score}
        onValue={setScore}
        min={0}
        max={100}
        step={kScoreStep}
        {...(attempt.computed_score === null
          ? {}
          : { hint: say("judge.computed", { score: formatScore(attempt.computed_score) }) })}
      />
      <LongTextField
        label={say("common.reason")}
        hint={say("appeal.student_reads")}
        value={reason}
        onValue={setReason}
        required
        maxLength={1000}
        rows={3}
      />
      <div class="button-row">
        <button type="submit" class="button primary" disabled={busy}>
          {say("judge.set")}
        </button>
        <button type="button" class="button" onClick={onCancel}>
          {say("common.cancel")}
        </button>
      </div>
    </form>
  );
}

function overrideDifferences({ override, score }: AttemptDetail, mine: number, reason: string): readonly Difference[] {
  return [
    {
      title: say("common.score"),
      theirs: score === null ? "" : formatScore(override?.score ?? score),
      mine: formatScore(mine),
    },
    { title: say("common.reason"), theirs: override?.reason ?? "", mine: reason },
  ].filter(({ theirs, mine: own }) => theirs !== own);
}
