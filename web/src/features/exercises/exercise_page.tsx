import "../../api/shared";
import "../../widgets/shared";
import type { Client } from "../../api/client";
import type { Attempt, Exercise } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatDateTime, formatNumber, formatPoints, formatLimit, formatScore, micrometresAsMm } from "../../base/format";
import { Flags, StateBadge } from "../../widgets/attempt_state";
import { Badge, Card, Empty, ErrorNotice, Loading, PageTitle } from "../../widgets/basics";
import { DataTable } from "../../widgets/table";
import { burText, falls, fullMarksText, kStateTexts, noMarksText, ownerText, shankText, timeLimitText, touchCuesText, versionText } from "./exercise_text";
import { ReferencesCard, VersionsCard } from "./history_cards";
import { InitialTooth } from "./initial_tooth";
import { ProgressCard } from "./progress_card";
import { StaffActions } from "./staff_actions";
import { outlinePaths, outlineViewBox } from "./target_outline";

const kAttemptsShown = 50;

interface Props {
  readonly client: Client;
  readonly id: string;
  readonly personId: string;
  readonly teacher: boolean;
  readonly onOpen: (path: string) => void;
}

export function ExercisePage({ client, id, personId, teacher, onOpen }: Props) {
  const { loaded, reload } = useRequest(id, (signal) => client.teaching.exercise(id, signal));
  if (loaded.state === "loading") return <Loading what="the exercise" />;
  if (loaded.state === "failed") {
    return (
      <>
        <PageTitle document="Exercise">Exercise</PageTitle>
        <ErrorNotice title="The exercise could not be loaded" message={loaded.error.message} onRetry={reload} />
      </>
    );
  }
  const exercise = loaded.value.value;
  const state = kStateTexts[exercise.state];
  return (
    <>
      <nav class="trail" aria-label="Where you are"><a href="/exercises">Exercises</a></nav>
      <div class="attempt-head">
        <div>
          <div class="title-row">
            <PageTitle document={exercise.title}>{exercise.title}</PageTitle>
            {teacher && <Badge tone={state.tone}>{state.title}</Badge>}
            <Badge tone="neutral">{exercise.graded ? "Graded: the score shows after release" : "Practice: the score shows at once"}</Badge>
          </div>
          {teacher && <p class="byline"><code>{exercise.name}</code>, {versionText(exercise)} · {ownerText(exercise)}</p>}
        </div>
        {teacher && <StaffActions client={client} exercise={exercise} tag={loaded.value.tag} onChanged={reload} onOpen={onOpen} />}
      </div>
      <p class="lead instructions">{exercise.instructions}</p>
      <div class="columns">
        <div class="stack">
          <Card title="What is asked"><TargetOutline exercise={exercise} /><Target exercise={exercise} /></Card>
          <Card title="How it is scored"><Rubric exercise={exercise} /></Card>
        </div>
        <InitialTooth client={client} exercise={exercise} />
      </div>
      {teacher
        ? <div class="columns"><ReferencesCard client={client} exercise={exercise} /><VersionsCard client={client} exercise={exercise} /></div>
        : <OwnAttempts client={client} exercise={exercise} personId={personId} />}
    </>
  );
}

// From above, mesial to the right and buccal up, with the leeway around it.
function TargetOutline({ exercise }: { readonly exercise: Exercise }) {
  const { target } = exercise;
  return (
    <svg class="target-outline" viewBox={outlineViewBox(target)} role="img" aria-label="What is to be cut, seen from above">
      {outlinePaths(target).map((path) => path.what === "goes" && <path class="leeway" d={path.d} style={{ strokeWidth: 2 * target.leeway_side_um }} />)}
      {outlinePaths(target).map((path) => <path class={path.what} d={path.d} />)}
    </svg>
  );
}

function Target({ exercise }: { readonly exercise: Exercise }) {
  const { target, handpiece, touch_cues } = exercise;
  return (
    <dl class="facts stacked">
      <div><dt>Bur</dt><dd>{burText(exercise.bur)}</dd></div>
      <div><dt>Shank</dt><dd>{shankText(exercise.bur)}</dd></div>
      <div><dt>Handpiece</dt><dd>{handpiece === null ? "Keeps its speed" : `Stalls at ${formatNumber(handpiece.stall_un_m / 1000, 2)} mN·m`}</dd></div>
      <div><dt>Touch cues</dt><dd>{touchCuesText(touch_cues)}</dd></div>
      <div><dt>Time limit</dt><dd>{timeLimitText(exercise.time_limit_s)}</dd></div>
      <div><dt>Length, mesial to distal</dt><dd>{micrometresAsMm(2 * (target.half_size_um[0] ?? 0))}</dd></div>
      <div><dt>Width, buccal to lingual</dt><dd>{micrometresAsMm(2 * (target.half_size_um[1] ?? 0))}</dd></div>
      <div><dt>Depth</dt><dd>{micrometresAsMm(target.depth_um)}</dd></div>
      <div><dt>May go beyond the walls</dt><dd>{micrometresAsMm(target.leeway_side_um)}</dd></div>
      <div><dt>May go below the floor</dt><dd>{micrometresAsMm(target.leeway_bottom_um)}</dd></div>
      <div><dt>Must stay</dt><dd>the {micrometresAsMm(target.container_um)} around that</dd></div>
    </dl>
  );
}

function Rubric({ exercise }: { readonly exercise: Exercise }) {
  const { criteria, gates } = exercise.rubric;
  const total = criteria.reduce((sum, criterion) => sum + criterion.points, 0);
  return (
    <>
      <DataTable label="Rubric" items={criteria} rowKey={(criterion) => criterion.metric} dense columns={[
        { title: "Criterion", cell: (criterion) => (
          <>{criterion.title}{criterion.fails_above !== null && <span class="sub">Above {formatLimit(criterion.fails_above, criterion.unit)} the whole attempt is not passed</span>}</>) },
        { title: "Full marks", cell: (criterion) => fullMarksText(criterion.map, criterion.unit) },
        { title: "No marks", cell: (criterion) => noMarksText(criterion.map, criterion.unit) },
        { title: "Points", number: true, cell: (criterion) => formatPoints(criterion.points) },
      ]} />
      <p class="hint">{formatPoints(total)} points in all.</p>
      {gates.map((gate) => (
        <p class="hint" key={gate.metric}>
          {gate.title}: every criterion counts in full {falls(gate.map) ? "up to" : "from"} {fullMarksText(gate.map, gate.unit)} and not at all {falls(gate.map) ? "from" : "up to"} {noMarksText(gate.map, gate.unit)}.
        </p>
      ))}
    </>
  );
}

function OwnAttempts({ client, exercise, personId }: { readonly client: Client; readonly exercise: Exercise; readonly personId: string }) {
  const { loaded, reload } = useRequest(exercise.id, (signal) => client.attempts({ exercise: exercise.id, person: personId, limit: kAttemptsShown }, signal));
  return (
    <>
      {loaded.state === "ready" && <ProgressCard client={client} attempts={loaded.value.items} />}
      <Card title="My attempts">
        {loaded.state === "loading" && <Loading what="attempts" />}
        {loaded.state === "failed" && <ErrorNotice title="The attempts could not be loaded" message={loaded.error.message} onRetry={reload} />}
        {loaded.state === "ready" && (loaded.value.items.length === 0 ? <Empty>No attempt yet. Sign in at a station and choose this exercise there.</Empty> : (
          <DataTable label="My attempts at this exercise" items={loaded.value.items} rowKey={(attempt) => attempt.id} columns={[
            { title: "When", cell: (attempt: Attempt) => <a href={`/attempts/${attempt.id}`}>{formatDateTime(attempt.ticketed_ms)}</a> },
            { title: "State", cell: (attempt: Attempt) => <StateBadge attempt={attempt} /> },
            { title: "Score", number: true, cell: (attempt: Attempt) => <span class="score-cell">{formatScore(attempt.score)}</span> },
            { title: "Flags", cell: (attempt: Attempt) => <Flags attempt={attempt} graded={exercise.graded || attempt.exam} staff={false} /> },
          ]} />
        ))}
      </Card>
    </>
  );
}
