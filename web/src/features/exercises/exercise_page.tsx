import { useEffect, useMemo, useState } from "preact/hooks";
import { exerciseTitle, wordedText, wordedTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import type { Attempt, Exercise } from "../../api/types";
import { useRequest } from "../../api/use_request";
import {
  formatDateTime,
  formatNumber,
  formatPoints,
  formatLimit,
  formatScore,
  micrometresAsMm,
} from "../../base/format";
import { keepTrying } from "../../base/keep_trying";
import { say, sayIf } from "../../base/words";
import { Flags, StateBadge } from "../../widgets/attempt_state";
import { Badge, Card, Empty, PageTitle, Waits } from "../../widgets/basics";
import { DataTable } from "../../widgets/table";
import {
  burText,
  fullMarksText,
  stateText,
  noMarksText,
  ownerText,
  shankText,
  timeLimitText,
  touchCuesText,
  versionText,
} from "./exercise_text";
import { ReferencesCard, VersionsCard } from "./history_cards";
import { InitialTooth } from "./initial_tooth";
import { ProgressCard } from "./progress_card";
import { PricesTable } from "./prices_table";
import { sourceText } from "./restoration_text";
import { StaffActions } from "./staff_actions";
import { outlinePaths, outlineViewBox } from "../../widgets/target_outline";

const kAttemptsShown = 50;

interface Props {
  readonly client: Client;
  readonly id: string;
  readonly personId: string;
  readonly teacher: boolean;
  readonly onOpen: (path: string) => void;
}

export function ExercisePage({ client, id, personId, teacher, onOpen }: Props) {
  const { loaded, reload } = useRequest(id, (signal) => client.tagged("GET", "/exercises/{id}", { id, signal }));
  const draw = useTargetLines();
  if (loaded.state !== "ready")
    return (
      <Waits loaded={loaded} reload={reload} what={say("loading.exercise")} failed={say("exercise_page.failed")}>
        <PageTitle document={say("common.exercise")}>{say("common.exercise")}</PageTitle>
      </Waits>
    );
  const exercise = loaded.value.value;
  const state = stateText(exercise.state);
  return (
    <>
      <nav class="trail" aria-label={say("common.where")}>
        <a href="/exercises">{say("nav.exercises")}</a>
      </nav>
      <div class="attempt-head">
        <div>
          <div class="title-row">
            <PageTitle document={exerciseTitle(exercise)}>{exerciseTitle(exercise)}</PageTitle>
            {teacher && <Badge tone={state.tone}>{state.title}</Badge>}
            <Badge tone="neutral">
              {exercise.graded ? say("exercise_page.graded_text") : say("exercise_page.practice_text")}
            </Badge>
          </div>
          {teacher && (
            <p class="byline">
              <code>{exercise.name}</code>, {versionText(exercise)} · {ownerText(exercise)}
            </p>
          )}
        </div>
        {teacher && (
          <StaffActions client={client} exercise={exercise} tag={loaded.value.tag} onChanged={reload} onOpen={onOpen} />
        )}
      </div>
      <p class="lead instructions">{wordedText(exercise.instructions)}</p>
      <div class="columns">
        <Card title={say("exercise_page.asked")}>
          <TargetOutline exercise={exercise} border={draw?.borderOf(exercise.target)} />
          <Target exercise={exercise} />
        </Card>
        <ToothWithTarget client={client} exercise={exercise} draw={draw} />
      </div>
      <Card title={say("exercise_page.scored")}>
        <Rubric exercise={exercise} />
      </Card>
      {teacher ? (
        <div class="columns">
          <ReferencesCard client={client} exercise={exercise} />
          <VersionsCard client={client} exercise={exercise} />
        </div>
      ) : (
        <OwnAttempts client={client} exercise={exercise} personId={personId} />
      )}
    </>
  );
}

// What draws a target, which a visit to other pages need not load. Undefined: not yet.
type TargetLines = typeof import("../../widgets/target_lines");
function useTargetLines(): TargetLines | undefined {
  const [draw, setDraw] = useState<TargetLines>();
  useEffect(() => {
    const shown = new AbortController();
    void keepTrying(() => import("../../widgets/target_lines"), shown.signal).then(setDraw);
    return () => shown.abort();
  }, []);
  return draw;
}

interface ToothProps {
  readonly client: Client;
  readonly exercise: Exercise;
  readonly draw: TargetLines | undefined;
}

// The tooth before anything is cut, with what is to be cut drawn over it, where the server says where that is.
function ToothWithTarget({ client, exercise, draw }: ToothProps) {
  const lines = useMemo(() => draw?.linesOfTarget(exercise.target), [draw, exercise.target]);
  return (
    <InitialTooth client={client} exercise={exercise} title={say("exercise_page.before")} lines={lines}>
      {lines !== undefined && (
        <p class="hint">{say(exercise.target.prepared ? "editor.preview_prepared" : "editor.preview_lines")}</p>
      )}
    </InitialTooth>
  );
}

// From above, the scene's x to the right and buccal up, with the leeway around it.
function TargetOutline({ exercise, border }: { readonly exercise: Exercise; readonly border: string | undefined }) {
  const { target } = exercise;
  const paths = outlinePaths(target);
  return (
    <svg class="target-outline" viewBox={outlineViewBox(target)} role="img" aria-label={say("exercise_page.outline")}>
      {paths.map(
        (path) =>
          path.what === "goes" && <path class="leeway" d={path.d} style={{ strokeWidth: 2 * target.leeway_side_um }} />,
      )}
      {paths.map((path) => (
        <path class={path.what === "goes" && border !== undefined ? "goes area" : path.what} d={path.d} />
      ))}
      {border !== undefined && <path d={border} />}
    </svg>
  );
}

function Target({ exercise }: { readonly exercise: Exercise }) {
  const { target, handpiece, touch_cues, rubric } = exercise;
  return (
    <dl class="facts stacked">
      {rubric.restoration !== null && (
        <div>
          <dt>{say("restoration.material")}</dt>
          <dd>{say(`material.${rubric.restoration.name}`)}</dd>
        </div>
      )}
      <div>
        <dt>{say("exercise_page.bur")}</dt>
        <dd>{burText(exercise.burs)}</dd>
      </div>
      <div>
        <dt>{say("exercise_page.shank")}</dt>
        <dd>{shankText(exercise.burs[0]!)}</dd>
      </div>
      <div>
        <dt>{say("exercise_page.handpiece")}</dt>
        <dd>
          {handpiece === null
            ? say("exercise_page.keeps_speed")
            : say("exercise_page.stalls", { torque: formatNumber(handpiece.stall_un_m / 1000, 2) })}
        </dd>
      </div>
      <div>
        <dt>{say("exercise_page.cues")}</dt>
        <dd>{touchCuesText(touch_cues)}</dd>
      </div>
      {exercise.rubber_dam && (
        <div>
          <dt>{say("exercise_page.rubber_dam")}</dt>
          <dd>{say("editor.yes")}</dd>
        </div>
      )}
      <div>
        <dt>{say("exercise_page.time_limit")}</dt>
        <dd>{timeLimitText(exercise.time_limit_s)}</dd>
      </div>
      <div>
        <dt>{say("exercise_page.length")}</dt>
        <dd>{micrometresAsMm(2 * (target.half_size_um[0] ?? 0))}</dd>
      </div>
      <div>
        <dt>{say("exercise_page.width")}</dt>
        <dd>{micrometresAsMm(2 * (target.half_size_um[1] ?? 0))}</dd>
      </div>
      <div>
        <dt>{say("exercise_page.depth")}</dt>
        <dd>{micrometresAsMm(target.depth_um)}</dd>
      </div>
      <div>
        <dt>{say("exercise_page.beyond")}</dt>
        <dd>{micrometresAsMm(target.leeway_side_um)}</dd>
      </div>
      <div>
        <dt>{say("exercise_page.below")}</dt>
        <dd>{micrometresAsMm(target.leeway_bottom_um)}</dd>
      </div>
      <div>
        <dt>{say("exercise_page.stay")}</dt>
        <dd>{say("exercise_page.stay_text", { width: micrometresAsMm(target.container_um) })}</dd>
      </div>
    </dl>
  );
}

function Rubric({ exercise }: { readonly exercise: Exercise }) {
  const { prices, criteria, critical, restoration } = exercise.rubric;
  return (
    <>
      <PricesTable prices={prices} />
      {criteria.length > 0 && (
        <>
          <h3>{say("rubric.hand")}</h3>
          <DataTable
            label={say("rubric.hand")}
            items={criteria}
            rowKey={(criterion) => criterion.metric}
            dense
            columns={[
              {
                title: say("common.criterion"),
                cell: (criterion) => (
                  <>
                    {wordedTitle(criterion.title)}
                    {criterion.fails_above !== null && (
                      <span class="sub">
                        {say("exercise_page.fails_above", {
                          limit: formatLimit(criterion.fails_above, criterion.unit),
                        })}
                      </span>
                    )}
                  </>
                ),
              },
              { title: say("exercise_page.costs_nothing"), cell: ({ map, unit }) => fullMarksText(map, unit) },
              { title: say("exercise_page.costs_all"), cell: ({ map, unit }) => noMarksText(map, unit) },
              { title: say("price.at_most"), number: true, cell: (criterion) => formatPoints(criterion.points) },
            ]}
          />
        </>
      )}
      {restoration !== null && (
        <>
          <p class="hint">{say("restoration.named", { material: say(`material.${restoration.name}`) })}</p>
          <p class="hint">{say("restoration.source", { source: sourceText(restoration) })}</p>
        </>
      )}
      {critical.length > 0 && (
        <>
          <h3>{say("score.not_acceptable")}</h3>
          <ul>
            {critical.map(({ error, metric, unit, limit, above }) => (
              <li key={`${error} ${metric}`}>
                {say(above ? "exercise_page.critical_above" : "exercise_page.critical_below", {
                  error: sayIf(`critical_error.${error}`) ?? error,
                  metric: sayIf(`metric.${metric}`) ?? metric,
                  limit: formatLimit(limit, unit),
                })}
              </li>
            ))}
          </ul>
        </>
      )}
    </>
  );
}

function OwnAttempts({
  client,
  exercise,
  personId,
}: {
  readonly client: Client;
  readonly exercise: Exercise;
  readonly personId: string;
}) {
  const { loaded, reload } = useRequest(exercise.id, (signal) =>
    client.page("/attempts", { exercise: exercise.id, person: personId, limit: kAttemptsShown, signal }),
  );
  return (
    <>
      {loaded.state === "ready" && <ProgressCard client={client} attempts={loaded.value.items} />}
      <Card title={say("nav.my_attempts")}>
        <Waits loaded={loaded} reload={reload} what={say("loading.attempts")} failed={say("list_failed.attempts")} />
        {loaded.state === "ready" &&
          (loaded.value.items.length === 0 ? (
            <Empty>{say("exercise_page.none")}</Empty>
          ) : (
            <DataTable
              label={say("exercise_page.mine")}
              items={loaded.value.items}
              rowKey={(attempt) => attempt.id}
              columns={[
                {
                  title: say("common.when"),
                  cell: (attempt: Attempt) => (
                    <a href={`/attempts/${attempt.id}`}>{formatDateTime(attempt.ticketed_ms)}</a>
                  ),
                },
                { title: say("common.state"), cell: (attempt: Attempt) => <StateBadge attempt={attempt} /> },
                {
                  title: say("common.score"),
                  number: true,
                  cell: (attempt: Attempt) => <span class="score-cell">{formatScore(attempt.score)}</span>,
                },
                {
                  title: say("attempts.flags"),
                  cell: (attempt: Attempt) => (
                    <Flags attempt={attempt} graded={exercise.graded || attempt.exam} staff={false} />
                  ),
                },
              ]}
            />
          ))}
      </Card>
    </>
  );
}
