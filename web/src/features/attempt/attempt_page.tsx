import "../../api/shared";
import "../../widgets/shared";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { wordedTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import type { ApiError } from "../../api/http";
import type { Annotation, AttemptDetail, Deduction, Person } from "../../api/types";
import { scoreOf } from "../../api/worded";
import { useRequest } from "../../api/use_request";
import { useRefresh } from "../../api/use_refresh";
import { unreachable } from "../../base/assert";
import { momentOf, momentQuery } from "../../base/moment_link";
import { placeInQueue } from "../../base/queue";
import { formatDateTime, formatMoment, formatQuantity } from "../../base/format";
import { say, sayWith } from "../../base/words";
import { Flags, isUnderWay, StateBadge, stoppedEarly } from "../../widgets/attempt_state";
import { Card, ErrorNotice, Loading, Notice, PageTitle, Progress } from "../../widgets/basics";
import { KeysHelp, useKeys } from "../../widgets/keys";
import { useReleaseUndo } from "../../widgets/release_undo";
import type { PointMm } from "../../widgets/tooth/scene";
import type { LookHandle } from "../../widgets/tooth/tooth_view";
import { AnnotationsPanel } from "./annotations_panel";
import { AppealPanel } from "./appeal_panel";
import { gapsOf, seriesEndS, stepAt } from "./clock";
import { MetricsPanel, RecordingPanel, RunsPanel } from "./detail_panels";
import { ForcePanel, type PlotKeys } from "./force_panel";
import { EnvelopePanel } from "./envelope_panel";
import { type Mark, marksOf, stepOfTick } from "./moments";
import { nextMark, spansOf } from "./spans";
import { ScorePanel } from "./score_panel";
import { toleranceMm } from "./tolerance";
import { QueueBar } from "./queue_bar";
import { isWithheld, withheldText } from "./summary";
import { TeacherActions } from "./teacher_actions";
import { ToothPanel } from "./tooth_panel";
import { type PlaybackControl, playbackKeys, usePlayback } from "./use_playback";

const kPollMs = 1500;
const kBeyondS = 0.05;                          // an address has hundredths; less is rounding
const kNoRemarks: readonly Annotation[] = [];

interface Props {
  readonly client: Client;
  readonly person: Person;
  readonly id: string;
  readonly onOpen: (path: string) => void;
}

// One attempt. While it is recorded or scored its state is asked for again and again, so that the
// score appears by itself.
export function AttemptPage({ client, person, id, onOpen }: Props) {
  const { loaded, reload } = useRequest(id, (signal) => client.attempt(id, signal));
  const attempt = loaded.state === "ready" ? loaded.value : undefined;
  const exercise = useRequest(attempt?.exercise.id, (signal) => client.teaching.exercise(attempt?.exercise.id ?? "", signal));
  const graded = exercise.loaded.state !== "ready" || exercise.loaded.value.value.graded || attempt?.exam === true;
  const tolerance = toleranceMm(exercise.loaded.state === "ready" ? exercise.loaded.value.value.rubric.criteria : []);
  const [done, setDone] = useState<number>();       // of the work, where it was stopped early; the score says it
  const polling = attempt !== undefined && isUnderWay(attempt.state);
  useRefresh(polling, kPollMs, reload);

  const teacher = person.role !== "student";
  const place = useMemo(() => teacher ? placeInQueue(id) : undefined, [id, teacher]);
  const to = (other: string | undefined) => { if (other !== undefined) onOpen(`/attempts/${other}`); };
  const release = useRef<() => void>(undefined);    // and on to the next one, where that may be done now
  const control = useRef<PlaybackControl>(undefined);
  const plots = useMemo((): PlotKeys => ({}), []);
  const toMark = useRef<(direction: -1 | 1) => void>(undefined);
  const undo = useReleaseUndo(async (released) => {
    const now = await client.attempt(released);     // with what others changed meanwhile
    return now.ok ? client.teaching.withdrawRelease(now.value) : now;
  });
  const keys = useKeys([...playbackKeys(() => control.current),
    { key: "i", what: say("attempt_key.less"), act: () => plots.zoom?.(1) }, { key: "o", what: say("attempt_key.more"), act: () => plots.zoom?.(-1) },
    { key: "u", what: say("attempt_key.whole"), act: () => plots.zoom?.(0) },
    { key: "v", what: say("attempt_key.lines"), act: () => plots.more?.() },
    { key: "x", what: say("attempt_key.next_mark"), act: () => toMark.current?.(1) },
    { key: "z", what: say("attempt_key.mark_before"), act: () => toMark.current?.(-1) },
    ...(!teacher ? [] : [
    ...undo.keys,
    ...(place === undefined ? [] : [
      { key: "n", what: say("attempt_key.next"), act: () => to(place.next) }, { key: "p", what: say("attempt_key.before"), act: () => to(place.previous) },
      { key: "b", what: say("queue.back"), act: () => onOpen(place.back) }, { key: "r", what: say("attempt_key.release"), act: () => release.current?.() },
    ]),
    { key: "c", what: say("attempt_key.remark"), act: () => document.querySelector<HTMLElement>(".annotations-card .new-remark textarea")?.focus() },
    { key: "t", what: say("attempt_key.time"), act: () => document.querySelector<HTMLElement>("#timeline")?.focus() },
  ])]);

  if (loaded.state === "failed") return <>{undo.notice}<AttemptError error={loaded.error} onRetry={reload} /></>;
  if (attempt === undefined) return <>{undo.notice}<Loading what={say("loading.attempt")} /></>;
  return (
    <>
      {undo.notice}
      <div class="trail-row">
        {place !== undefined ? <QueueBar client={client} place={place} />
          : <nav class="trail" aria-label={say("common.where")}><a href="/attempts">{teacher ? say("nav.attempts") : say("nav.my_attempts")}</a></nav>}
        <KeysHelp keys={keys} />
      </div>
      <div class="attempt-head">
        <div>
          <PageTitle document={wordedTitle(attempt.exercise.title)}>{wordedTitle(attempt.exercise.title)}</PageTitle>
          <p class="byline">
            {attempt.person.display_name}, {formatDateTime(attempt.ticketed_ms)} <StateBadge attempt={attempt} /> <Flags attempt={attempt} graded={graded && teacher} staff={teacher} appealed={attempt.appeal?.state === "open"} done={done} />
          </p>
        </div>
        {teacher ? <TeacherActions client={client} attempt={attempt} graded={graded} onChanged={reload} releaseNext={release}
                                   onNext={place === undefined ? undefined : () => place.next === undefined ? onOpen(place.back) : to(place.next)} />
                 : attempt.state === "scored" && <button type="button" class="button print-button" onClick={() => window.print()}>{say("attempt.print")}</button>}
      </div>
      {isWithheld(attempt, teacher) ? <WithheldAttempt attempt={attempt} /> : attempt.state === "scored" ? <ScoredAttempt client={client} personId={person.id} attempt={attempt} tolerance={tolerance} teacher={teacher} playback={control} toMark={toMark} plots={plots} onChanged={reload} onDone={setDone} /> : <UnscoredAttempt attempt={attempt} />}
    </>
  );
}

function ScoredAttempt({ client, attempt, tolerance, teacher, playback, toMark, plots, onChanged, onDone, personId }:
                       { readonly plots: PlotKeys; readonly playback: { current: PlaybackControl | undefined }; readonly toMark: { current: ((direction: -1 | 1) => void) | undefined }; readonly personId: string; readonly onDone: (percent: number | undefined) => void; readonly client: Client; readonly attempt: AttemptDetail; readonly tolerance: number; readonly teacher: boolean; readonly onChanged: () => void }) {
  const { id } = attempt;
  // Release changes what a student gets, not what a teacher gets; a new score changes it for both.
  const key = `${id} ${teacher || attempt.released} ${attempt.computed_score} ${attempt.reference?.attempt_id}`;
  const score = useRequest(key, (signal) => scoreOf(client, id, signal));
  const removed = attempt.recording_removed_ms > 0;
  const series = useRequest(removed ? undefined : key, (signal) => client.series(id, signal));
  const remarks = useRequest(key, (signal) => client.teaching.annotations(id, signal));
  const [timeS, setTimeS] = useState<number>();     // undefined until first moved: the end
  const asked = useMemo(() => momentOf(new URLSearchParams(window.location.search)), []);
  const asksDone = useRef(false);                   // nothing that is still to come changes the moment it names
  const look = useMemo((): LookHandle => ({ begin: asked.look, now: undefined }), [asked]);
  const [noMark, setNoMark] = useState(false);      // somebody asked for the next one, and there is none
  const [chosen, setChosen] = useState<string>();   // id of a remark
  const [point, setPoint] = useState<PointMm>();    // clicked on the tooth, for the next remark
  const recorded = series.loaded.state === "ready" ? series.loaded.value : undefined;
  const control = usePlayback(client, removed ? undefined : id, key, timeS, setTimeS);
  playback.current = control;
  // The picture without a playback: some megabytes more, and nothing moves.
  const still = control !== undefined && (control.playback.state.state === "waiting" || control.playback.state.state === "failed");
  const surface = useRequest(still ? key : undefined, (signal) => client.surface(id, signal));
  const endS = control?.clock?.endS ?? (recorded === undefined ? undefined : seriesEndS(recorded));
  // The one moment of picture, plots and remarks: until somebody moves it, the end.
  const momentS = timeS ?? endS ?? 0;
  const cursor = recorded === undefined ? 0 : stepAt(recorded, momentS);
  const setCursor = (step: number) => {
    if (recorded !== undefined) setTimeS(step >= recorded.t_s.length - 1 ? endS : recorded.t_s[step]);
  };
  const said = remarks.loaded.state === "ready" ? remarks.loaded.value : kNoRemarks;
  const marks = useMemo(() => recorded === undefined ? [] : marksOf(recorded, said), [recorded, said]);
  const scored = score.loaded.state === "ready" ? score.loaded.value : undefined;
  const head = control?.playback.head;
  const whole = control?.playback.whole === true;
  const spans = useMemo(() => {
    if (recorded === undefined) return [];
    const { clock, playback: played } = control ?? {};
    const gaps = !whole || head === undefined || clock === undefined || played === undefined ? [] : gapsOf(head, played.poses).map((gap) => ({ ...gap, endS: clock.timeOf(gap.frames) }));
    return spansOf(recorded, gaps, scored?.deductions ?? []);
  }, [recorded, scored, head, whole, control?.clock]);
  toMark.current = (direction) => {
    const at = nextMark(spans, momentS, direction);
    setNoMark(at === undefined && scored !== undefined);
    if (at !== undefined) setTimeS(at);
  };
  const done = scored === undefined ? undefined : stoppedEarly(scored);
  useEffect(() => onDone(done), [done, onDone]);
  const reference = attempt.reference === null ? undefined : attempt.reference.dentist ?? say("attempt.earlier_reference");
  const annotates = attempt.may.includes("annotate");
  // A link may name the moment; it is opened as soon as the recording is there.
  useEffect(() => {
    if (endS !== undefined && asked.seconds !== undefined && !asksDone.current) setTimeS(Math.min(asked.seconds, endS));
    if (control?.playback.whole === true || still) asksDone.current = true;
  }, [endS, asked, control?.playback.whole]);
  const { loop, clock } = control ?? {};
  const range = loop?.to === undefined || clock === undefined ? undefined : [clock.timeOf(loop.from), clock.timeOf(loop.to)] as const;
  const beyond = endS !== undefined && asked.seconds !== undefined && asked.seconds > endS + kBeyondS ? asked.seconds : undefined;
  const link = () => window.location.origin + window.location.pathname + momentQuery({ seconds: momentS, look: look.now?.() });
  const tooth = useRef<HTMLDivElement>(null);
  // Whatever has a time or a place is shown there, wherever on the page it was clicked.
  const go = (step: number | undefined) => {
    if (step !== undefined) setCursor(step);
    tooth.current?.scrollIntoView({ block: "nearest" });
  };
  const choose = (mark: Mark) => {
    setChosen(mark.annotation.id);
    go(mark.step);
  };
  const showPlace = (deduction: Deduction) => {
    const [x, y, z] = deduction.position_mm;
    if (x !== undefined && y !== undefined && z !== undefined) setPoint([x, y, z]);
    go(recorded !== undefined && deduction.stroke_count > 0 ? stepOfTick(recorded, deduction.first_tick) : undefined);
  };
  return (
    <>
      <div class="attempt-grid">
        <div class="stack">
          {score.loaded.state === "loading" && <Card title={say("score.title")}><Loading what={say("loading.score")} /></Card>}
          {score.loaded.state === "failed" && <ScoreError error={score.loaded.error} onRetry={score.reload} />}
          {scored !== undefined && attempt.problem !== "" && <Notice tone="warning" title={say("attempt.rescore_failed")}><p>{attempt.problem}</p></Notice>}
          {scored !== undefined && <ScorePanel score={scored} reference={reference} override={attempt.override} onPlace={removed ? undefined : showPlace} />}
          <AppealPanel client={client} attempt={attempt} onChanged={onChanged} />
          {recorded !== undefined && remarks.loaded.state === "ready" && (annotates || marks.length > 0) && (
            <AnnotationsPanel client={client} attemptId={id} personId={personId} teacher={annotates} series={recorded} marks={marks} chosen={chosen} timeS={momentS} cursor={cursor}
                              point={point} onPoint={setPoint} onChoose={choose} onChanged={remarks.reload} />
          )}
        </div>
        {removed ? <RemovedRecording removedMs={attempt.recording_removed_ms} /> : (
          <div class="review">
            {beyond !== undefined && endS !== undefined && (
              <p class="hint beyond" role="status">{say("attempt.beyond", { asked: formatMoment(beyond), end: formatMoment(endS) })}</p>
            )}
            {noMark && <p class="hint" role="status">{say("span_kind.none")}</p>}
            <div class="review-tooth" ref={tooth}>
              {control !== undefined && <ToothPanel client={client} attempt={attempt} staff={teacher} timeS={momentS} surface={surface.loaded} control={control} toleranceMm={tolerance} series={recorded} cursor={recorded === undefined || timeS === undefined ? undefined : cursor} marks={marks} chosen={chosen} point={point} look={look} onMark={choose}
                          onPoint={annotates ? setPoint : undefined} onRetry={surface.reload} />}
            </div>
            <ForcePanel client={client} attempt={attempt.id} exercise={attempt.exercise.id} series={series.loaded} cursor={cursor} timeS={momentS} range={range} marks={marks} spans={spans} onTime={setTimeS} keys={plots} chosen={chosen} onMark={choose} onCursor={setCursor} onRetry={series.reload} link={link} />
          </div>
        )}
      </div>
      <div class="columns wide-right">
        <div class="stack">
          <RecordingPanel attempt={attempt} score={scored} />
          <Contradictions attempt={attempt} />
          <Nearness near={attempt.nearness} />
          {scored !== undefined && <RunsPanel client={client} requestKey={key} attemptId={id} />}
        </div>
        <div class="stack">
          {scored?.envelope != null && <EnvelopePanel client={client} exercise={attempt.exercise.id} envelope={scored.envelope} metrics={scored.metrics} judged={scored.criteria.map((criterion) => criterion.name)} />}
          {scored !== undefined && <MetricsPanel metrics={scored.metrics} />}
        </div>
      </div>
    </>
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

// Only who decides about the attempt is told.
function Contradictions({ attempt }: { readonly attempt: AttemptDetail }) {
  const chunks = attempt.contradictions;
  if (chunks.length === 0 && !(attempt.flags.includes("contradicted") && attempt.may.includes("annotate"))) return null;
  return (
    <Card title={say("attempt_flag.contradicted")}>
      <p>{chunks.length === 0 ? say("attempt.two_recordings_text") : say("attempt.contradicted_text")}</p>
      <ul>{chunks.map((chunk) => <li key={chunk.sha256}>{sayWith("attempt.chunk", { number: String(chunk.seq), when: formatDateTime(chunk.received_ms), hash: <code>{chunk.sha256.slice(0, 16)}…</code> })}</li>)}</ul>
    </Card>
  );
}

// Of a motion that lies near an earlier one's, for who reviews the attempt: what was found, and no verdict.
function Nearness({ near }: { readonly near: AttemptDetail["nearness"] }) {
  if (near === null || !near.worth_a_look) return null;
  const mm = (value: number) => formatQuantity(value, "mm");
  const whose = near.person === null ? say("attempt.near_unknown") : say("attempt.near_of", { name: near.person.display_name });
  return (
    <Card title={say("attempt_flag.near_another")}>
      <p>{sayWith("attempt.near_text", { nearest: mm(near.nearest_mm), whose: near.attempt_id === null ? whose : <a href={`/attempts/${near.attempt_id}`}>{whose}</a>, count: near.others, median: mm(near.median_mm), size: mm(near.size_mm) })}</p>
      <p class="hint">{say("attempt.near_hint")}</p>
    </Card>
  );
}

function UnscoredAttempt({ attempt }: { readonly attempt: AttemptDetail }) {
  return (
    <>
      <Card title={say("score.title")}>{unscoredText(attempt)}</Card>
      <Contradictions attempt={attempt} />
      <RecordingPanel attempt={attempt} score={undefined} />
    </>
  );
}

function unscoredText(attempt: AttemptDetail) {
  switch (attempt.state) {
    case "ticketed": return <p>{say("attempt.not_begun")}</p>;
    case "recording": return <Progress label={say("attempt.recording")} share={undefined} />;
    case "sealed": return <Progress label={say("attempt_state.sealed")} share={undefined} />;
    case "scoring": return <Progress label={say("attempt.scoring")} share={attempt.progress} />;
    case "failed": return <Notice tone="bad" title={say("attempt.not_scored")}><p>{attempt.problem}</p></Notice>;
    case "quarantined":
      return (
        <Notice tone="bad" title={say("attempt.set_aside")}>
          <p>{attempt.problem}</p><p>{say("attempt.set_aside_text")}</p>
        </Notice>
      );
    case "scored": return null;
    default: return unreachable(attempt.state);
  }
}

// Nothing is asked of the server that it would refuse: waiting is no error.
function WithheldAttempt({ attempt }: { readonly attempt: AttemptDetail }) {
  return (
    <>
      <Card title={say("score.title")}>
        <Notice tone="neutral" title={say("attempt.not_released")}><p>{withheldText(attempt)}</p></Notice>
      </Card>
      <RecordingPanel attempt={attempt} score={undefined} />
    </>
  );
}

function ScoreError({ error, onRetry }: { readonly error: ApiError; readonly onRetry: () => void }) {
  return <Card title={say("score.title")}><ErrorNotice title={say("attempt.score_failed")} message={error.message} onRetry={onRetry} /></Card>;
}

function AttemptError({ error, onRetry }: { readonly error: ApiError; readonly onRetry: () => void }) {
  const missing = error.code === "not_found";
  return (
    <>
      <nav class="trail" aria-label={say("common.where")}><a href="/attempts">{say("nav.attempts")}</a></nav>
      <PageTitle document={say("attempt.one")}>{say("attempt.one")}</PageTitle>
      <ErrorNotice title={missing ? say("attempt.none_for_you") : say("attempt.failed")}
                   message={missing ? say("attempt.none_for_you_text") : error.message}
                   onRetry={missing ? undefined : onRetry} />
    </>
  );
}
