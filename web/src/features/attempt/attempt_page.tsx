import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { exerciseTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import { type ApiError, seen } from "../../api/http";
import { anatomyOf } from "../../api/tooth_number";
import type { AttemptDetail, Person } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { useRefresh } from "../../api/use_refresh";
import { placeInQueue } from "../../base/queue";
import { formatDateTime, formatMoment, formatQuantity } from "../../base/format";
import { say, sayWith } from "../../base/words";
import { Flags, isUnderWay, StateBadge } from "../../widgets/attempt_state";
import { Card, ErrorNotice, Loading, Notice, PageTitle } from "../../widgets/basics";
import { KeysHelp, useKeys } from "../../widgets/keys";
import { useReleaseUndo } from "../../widgets/release_undo";
import { prepareTooth } from "../../widgets/tooth/tooth_view";
import { AnnotationsPanel } from "./annotations_panel";
import { AppealPanel } from "./appeal_panel";
import { MetricsPanel, RecordingPanel, RunsPanel } from "./detail_panels";
import { ForcePanel } from "./force_panel";
import { EnvelopePanel } from "./envelope_panel";
import { PrintButton } from "./print_report";
import { ScorePanel } from "./score_panel";
import { QueueBar } from "./queue_bar";
import { isWithheld, withheldText } from "./summary";
import { TeacherActions } from "./teacher_actions";
import { ToothPanel } from "./tooth_panel";
import { Closer } from "./tooth_tools";
import { playbackKeys } from "./use_playback";
import { type Rescore, useRescore } from "./use_rescore";
import { type Review, type Reviewed, useReview } from "./use_review";

export { beginPlayback } from "./playback";

const kPollMs = 1500;

interface Props {
  readonly client: Client;
  readonly person: Pick<Person, "id" | "role">;
  readonly id: string;
  readonly onOpen: (path: string) => void;
  readonly alone?: boolean; // there is no server, and no other page (app/demo.tsx)
}

// One attempt. While it is recorded or scored, the page polls its state, so that the score appears
// by itself.
export function AttemptPage({ client, person, id, onOpen, alone = false }: Props) {
  useEffect(prepareTooth, []);
  const { loaded, reload } = useRequest(id, (signal) => client.get("/attempts/{id}", { id, signal }));
  const attempt = loaded.state === "ready" ? loaded.value : undefined;
  const exercise = useRequest(attempt?.exercise.id, (signal) =>
    client.tagged("GET", "/exercises/{id}", { id: attempt?.exercise.id ?? "", signal }),
  );
  const graded = exercise.loaded.state !== "ready" || exercise.loaded.value.value.graded || attempt?.exam === true;
  const target = exercise.loaded.state === "ready" ? exercise.loaded.value.value.target : undefined;
  const anatomy = useMemo(() => (target === undefined ? undefined : anatomyOf(target)), [target]);
  const restoration =
    exercise.loaded.state === "ready" ? exercise.loaded.value.value.rubric.restoration?.name : undefined;
  const [done, setDone] = useState<number>(); // of the work, where it was stopped early; the score says it
  const polling = attempt !== undefined && isUnderWay(attempt.state);
  useRefresh(polling, kPollMs, reload);
  const rescore = useRescore(client, attempt, reload);

  const teacher = person.role !== "student";
  const place = useMemo(() => (teacher ? placeInQueue(id) : undefined), [id, teacher]);
  const to = (other: string | undefined) => {
    if (other !== undefined) onOpen(`/attempts/${other}`);
  };
  const release = useRef<() => void>(undefined); // and on to the next one, where that may be done now
  const review = useRef<Review>(undefined); // while there is a score to look at
  const undo = useReleaseUndo(async (released) => {
    const now = await client.get("/attempts/{id}", { id: released }); // with what others changed meanwhile
    return now.ok ? client.delete("/attempts/{id}/release", seen(now.value)) : now;
  });
  const keys = useKeys([
    ...playbackKeys(() => review.current?.control),
    { key: "i", what: say("attempt_key.less"), act: () => review.current?.plots.zoom?.(1) },
    { key: "o", what: say("attempt_key.more"), act: () => review.current?.plots.zoom?.(-1) },
    { key: "u", what: say("attempt_key.whole"), act: () => review.current?.plots.zoom?.(0) },
    { key: "v", what: say("attempt_key.lines"), act: () => review.current?.plots.more?.() },
    { key: "g", what: say("attempt_key.target"), act: () => review.current?.plots.target?.() },
    { key: "f", what: say("attempt_key.reference"), act: () => review.current?.plots.reference?.() },
    { key: "m", what: say("attempt_key.measure"), act: () => review.current?.plots.measure?.() },
    { key: "x", what: say("attempt_key.next_mark"), act: () => review.current?.toMark(1) },
    { key: "z", what: say("attempt_key.mark_before"), act: () => review.current?.toMark(-1) },
    ...(!teacher
      ? []
      : [
          ...undo.keys,
          ...(place === undefined
            ? []
            : [
                { key: "n", what: say("attempt_key.next"), act: () => to(place.next) },
                { key: "p", what: say("attempt_key.before"), act: () => to(place.previous) },
                { key: "b", what: say("queue.back"), act: () => onOpen(place.back) },
                { key: "r", what: say("attempt_key.release"), act: () => release.current?.() },
              ]),
          {
            key: "c",
            what: say("attempt_key.remark"),
            act: () => document.querySelector<HTMLElement>(".annotations-card .new-remark textarea")?.focus(),
          },
          {
            key: "t",
            what: say("attempt_key.time"),
            act: () => document.querySelector<HTMLElement>("#timeline")?.focus(),
          },
        ]),
  ]);

  if (loaded.state === "failed")
    return (
      <>
        {undo.notice}
        <AttemptError error={loaded.error} onRetry={reload} />
      </>
    );
  if (attempt === undefined)
    return (
      <>
        {undo.notice}
        <Loading what={say("loading.attempt")} />
      </>
    );
  const title = exerciseTitle(attempt.exercise);
  return (
    <>
      {undo.notice}
      <div class="attempt-top">
        {alone ? null : place !== undefined ? (
          <QueueBar client={client} place={place} />
        ) : (
          <nav class="trail" aria-label={say("common.where")}>
            <a href="/attempts">{teacher ? say("nav.attempts") : say("nav.my_attempts")}</a>
          </nav>
        )}
        <KeysHelp keys={keys} />
        <div class="attempt-title">
          <PageTitle document={alone ? say("demo.document", { title }) : title}>{title}</PageTitle>
          <p class="byline">
            {attempt.person.display_name}, {formatDateTime(attempt.ticketed_ms)}
            {restoration !== undefined && `, ${say("restoration.named", { material: say(`material.${restoration}`) })}`}{" "}
            <StateBadge attempt={attempt} />{" "}
            <Flags
              attempt={attempt}
              graded={graded && teacher}
              staff={teacher}
              appealed={attempt.appeal?.state === "open"}
              done={done}
            />
          </p>
        </div>
        {!teacher && attempt.state === "scored" && !isWithheld(attempt, teacher) && (
          <PrintButton look={() => review.current?.look} />
        )}
        {teacher && (
          <TeacherActions
            client={client}
            attempt={attempt}
            graded={graded}
            onChanged={reload}
            rescore={rescore}
            releaseNext={release}
            onNext={
              place === undefined ? undefined : () => (place.next === undefined ? onOpen(place.back) : to(place.next))
            }
          />
        )}
      </div>
      {isWithheld(attempt, teacher) ? (
        <WithheldAttempt attempt={attempt} />
      ) : attempt.state === "scored" ? (
        <ScoredAttempt
          reviewed={{
            client,
            attempt,
            personId: person.id,
            teacher,
            alone,
            anatomy,
            rescored: rescore.over,
          }}
          handle={review}
          onChanged={reload}
          rescore={rescore}
          onDone={setDone}
        />
      ) : (
        <UnscoredAttempt attempt={attempt} />
      )}
    </>
  );
}

interface ScoredProps {
  readonly reviewed: Reviewed;
  readonly handle: { current: Review | undefined };
  readonly onChanged: () => void;
  readonly rescore: Rescore;
  readonly onDone: (percent: number | undefined) => void;
}

function ScoredAttempt({ reviewed, handle, onChanged, rescore, onDone }: ScoredProps) {
  const review = useReview(reviewed);
  const { attempt, scored, done } = review;
  handle.current = review;
  useEffect(() => onDone(done), [done, onDone]);
  // The tooth first: it is drawn elsewhere while these are made.
  const step = useSteps(review.begun, 4);
  return (
    <>
      <div class="attempt-grid">
        <Judgement review={review} onChanged={onChanged} rescore={rescore} soon={step < 1} />
        {review.removed ? (
          <RemovedRecording removedMs={attempt.recording_removed_ms} />
        ) : (
          <Replay review={review} plots={step >= 2} />
        )}
      </div>
      {step >= 3 && (
        <div class="below">
          <Details review={review} />
          {step >= 4 && scored !== undefined && <MetricsPanel metrics={scored.metrics} />}
        </div>
      )}
    </>
  );
}

// The recording, and what else is known of it.
function Details({ review }: { readonly review: Review }) {
  const { attempt, scored } = review;
  return (
    <div class="columns">
      <RecordingPanel attempt={attempt} score={scored} alone={review.alone} />
      <div class="stack">
        <Contradictions attempt={attempt} />
        <Nearness near={attempt.nearness} />
        {(attempt.evidence !== null || attempt.sign_off !== null) && (
          <Closer show={({ EvidencePanel }) => <EvidencePanel attempt={attempt} />} />
        )}
        {scored !== undefined && <RunsPanel client={review.client} requestKey={review.key} attemptId={attempt.id} />}
        {scored?.envelope != null && (
          <EnvelopePanel
            client={review.client}
            exercise={attempt.exercise.id}
            envelope={scored.envelope}
            metrics={scored.metrics}
          />
        )}
      </div>
    </div>
  );
}

interface JudgementProps {
  readonly review: Review;
  readonly onChanged: () => void;
  readonly rescore: Rescore;
  readonly soon: boolean; // there is no time for it yet
}

// Score, appeal and remarks.
function Judgement({ review, onChanged, rescore, soon }: JudgementProps) {
  const { client, attempt, score, scored, recorded } = review;
  const { reference } = attempt;
  return (
    <div class="stack">
      {(score.loaded.state === "loading" || (soon && scored !== undefined)) && (
        <Card title={say("score.title")}>
          <Loading what={say("loading.score")} />
        </Card>
      )}
      {score.loaded.state === "failed" && score.loaded.error.code === "forbidden" && (
        <Card title={say("score.title")}>
          <Notice tone="neutral" title={say("attempt.marked_blind")}>
            <p>{say("attempt.marked_blind_text")}</p>
          </Notice>
        </Card>
      )}
      {score.loaded.state === "failed" && score.loaded.error.code !== "forbidden" && (
        <Card title={say("score.title")}>
          <ErrorNotice
            title={say("attempt.score_failed")}
            message={score.loaded.error.message}
            onRetry={score.reload}
          />
        </Card>
      )}
      {scored !== undefined && attempt.problem !== "" && (
        <Notice tone="warning" title={say("attempt.rescore_failed")}>
          <Closer show={({ Problem }) => <Problem attempt={attempt} />} />
        </Notice>
      )}
      {scored !== undefined && !soon && (
        <ScorePanel
          score={scored}
          reference={reference?.dentist ?? undefined}
          own={attempt.person.id === review.personId}
          graded={attempt.exercise.graded || attempt.exam}
          override={attempt.override}
          onPlace={review.removed ? undefined : review.showPlace}
        />
      )}
      {!review.alone && <AppealPanel client={client} attempt={attempt} rescore={rescore} onChanged={onChanged} />}
      {recorded !== undefined &&
        review.remarks.loaded.state === "ready" &&
        (review.annotates || review.marks.length > 0) && <AnnotationsPanel review={review} series={recorded} />}
    </div>
  );
}

// Picture and plots.
function Replay({ review, plots }: { readonly review: Review; readonly plots: boolean }) {
  const { beyondS, endS } = review;
  return (
    <div class="review">
      {beyondS !== undefined && endS !== undefined && (
        <p class="hint beyond" role="status">
          {say("attempt.beyond", { asked: formatMoment(beyondS), end: formatMoment(endS) })}
        </p>
      )}
      {review.noMark && (
        <p class="hint" role="status">
          {say("span_kind.none")}
        </p>
      )}
      <div class="review-tooth" ref={review.picture}>
        {review.back !== undefined && (
          <button type="button" class="button small way-back" onClick={review.back}>
            {say("score.back")}
          </button>
        )}
        <ToothPanel review={review} />
      </div>
      {plots && <ForcePanel review={review} />}
    </div>
  );
}

function RemovedRecording({ removedMs }: { readonly removedMs: number }) {
  return (
    <Card title={say("tooth_card.after")}>
      <Notice tone="neutral" title={say("attempt.removed", { when: formatDateTime(removedMs) })}>
        <p>{say("attempt.removed_text")}</p>
      </Notice>
    </Card>
  );
}

// Only people who decide about the attempt see this.
function Contradictions({ attempt }: { readonly attempt: AttemptDetail }) {
  const chunks = attempt.contradictions;
  if (chunks.length === 0 && !(attempt.flags.includes("contradicted") && attempt.may.includes("annotate"))) return null;
  return (
    <Card title={say("attempt_flag.contradicted")}>
      <p>{chunks.length === 0 ? say("attempt.two_recordings_text") : say("attempt.contradicted_text")}</p>
      <ul>
        {chunks.map((chunk) => (
          <li key={chunk.sha256}>
            {sayWith("attempt.chunk", {
              number: String(chunk.seq),
              when: formatDateTime(chunk.received_ms),
              hash: <code>{chunk.sha256.slice(0, 16)}…</code>,
            })}
          </li>
        ))}
      </ul>
    </Card>
  );
}

// A motion near an earlier one, for the reviewer: figures, and no verdict.
function Nearness({ near }: { readonly near: AttemptDetail["nearness"] }) {
  if (near === null || !near.worth_a_look) return null;
  const mm = (value: number) => formatQuantity(value, "mm");
  const whose =
    near.person === null ? say("attempt.near_unknown") : say("attempt.near_of", { name: near.person.display_name });
  return (
    <Card title={say("attempt_flag.near_another")}>
      <p>
        {sayWith("attempt.near_text", {
          nearest: mm(near.nearest_mm),
          whose: near.attempt_id === null ? whose : <a href={`/attempts/${near.attempt_id}`}>{whose}</a>,
          count: near.others,
          median: mm(near.median_mm),
          size: mm(near.size_mm),
        })}
      </p>
      <p class="hint">
        {say("evidence.proves_nothing")} {say("attempt.near_hint")}
      </p>
    </Card>
  );
}

function UnscoredAttempt({ attempt }: { readonly attempt: AttemptDetail }) {
  return (
    <>
      <Card title={say("score.title")}>
        <Closer show={({ Unscored }) => <Unscored attempt={attempt} />} />
      </Card>
      <Contradictions attempt={attempt} />
      <RecordingPanel attempt={attempt} score={undefined} />
    </>
  );
}

// Nothing is asked of the server that it would refuse: waiting is no error.
function WithheldAttempt({ attempt }: { readonly attempt: AttemptDetail }) {
  return (
    <>
      <Card title={say("score.title")}>
        <Notice tone="neutral" title={say("attempt.not_released")}>
          <p>{withheldText(attempt)}</p>
        </Notice>
      </Card>
      <RecordingPanel attempt={attempt} score={undefined} />
    </>
  );
}

function AttemptError({ error, onRetry }: { readonly error: ApiError; readonly onRetry: () => void }) {
  const missing = error.code === "not_found";
  const blind = error.code === "forbidden"; // the caller marks it and is not done
  return (
    <>
      <nav class="trail" aria-label={say("common.where")}>
        <a href="/attempts">{say("nav.attempts")}</a>
      </nav>
      <PageTitle document={say("attempt.one")}>{say("attempt.one")}</PageTitle>
      {blind ? (
        <Notice tone="neutral" title={say("attempt.marked_blind")}>
          <p>{say("attempt.marked_blind_page")}</p>
        </Notice>
      ) : (
        <ErrorNotice
          title={missing ? say("attempt.none_for_you") : say("attempt.failed")}
          message={missing ? say("attempt.none_for_you_text") : error.message}
          onRetry={missing ? undefined : onRetry}
        />
      )}
    </>
  );
}

// Counts up to `last` once `begun`, one a frame: parts of a screen that come one after the other leave room for what
// cannot wait, as a keystroke or a picture.
function useSteps(begun: boolean, last: number): number {
  const [step, setStep] = useState(0);
  useEffect(() => {
    if (!begun || step >= last) return undefined;
    const handle = requestAnimationFrame(() => setStep(step + 1));
    return () => cancelAnimationFrame(handle);
  }, [begun, step, last]);
  return step;
}
