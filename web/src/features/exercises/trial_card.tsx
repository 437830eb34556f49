import { useEffect, useRef, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ApiResult } from "../../api/http";
import { placeText } from "../../api/place_text";
import { placedMessage } from "../../api/placed";
import type { ExerciseTrial, TrialScore } from "../../api/types";
import { formatDuration, formatPoints, formatScore, kScoreStep } from "../../base/format";
import { say, sayIf } from "../../base/words";
import { Badge, Card, ErrorNotice, Notice, Progress } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { priceTitle } from "./price";

const kPollMs = 500;

// Tries an exercise document and asks until it is done or failed; `onChange` hears of each step. If the person leaves
// before, the server ends it.
async function tryExercise(
  client: Client,
  text: string,
  onChange: (now: ExerciseTrial) => void,
  signal: AbortSignal,
): Promise<ApiResult<ExerciseTrial>> {
  let now: ApiResult<ExerciseTrial> = await client.post("/exercise-trials", { body: text });
  while (now.ok && (now.value.state === "waiting" || now.value.state === "working")) {
    const { id } = now.value;
    if (!signal.aborted) onChange(now.value);
    await new Promise((done) => setTimeout(done, kPollMs));
    if (signal.aborted) {
      await client.delete("/exercise-trials/{id}", { id });
      return now;
    }
    now = await client.get("/exercise-trials/{id}", { id });
  }
  return now;
}

interface Props {
  readonly client: Client;
  readonly text: string; // the exercise document
  readonly blocked: string | undefined; // why it cannot be tried now
}

// What the exercise gives two attempts without a hand: the target cut exactly, and an untouched
// tooth. Nothing is stored.
export function TrialCard({ client, text, blocked }: Props) {
  const [now, setNow] = useState<ExerciseTrial>();
  const [of, setOf] = useState("");
  const [refused, setRefused] = useState<string>();
  const running = useRef<AbortController | undefined>(undefined);
  useEffect(() => () => running.current?.abort(), []);
  const busy = now !== undefined && (now.state === "waiting" || now.state === "working");
  const run = async () => {
    const controller = new AbortController();
    running.current = controller;
    setOf(text);
    setRefused(undefined);
    const result = await tryExercise(client, text, setNow, controller.signal);
    if (controller.signal.aborted) return;
    setNow(result.ok ? result.value : undefined);
    if (!result.ok) setRefused(placedMessage(result.error, placeText(result.error.field)));
  };
  const stop = () => {
    running.current?.abort();
    setNow(undefined);
  };
  return (
    <Card title={say("trial.title")}>
      <p class="hint">{say("trial.hint")}</p>
      <div class="button-row">
        {busy ? (
          <button type="button" class="button" onClick={stop}>
            {say("trial.stop")}
          </button>
        ) : (
          <Button kind="" blocked={blocked} onClick={() => void run()}>
            {say("trial.try")}
          </Button>
        )}
      </div>
      {refused !== undefined && <ErrorNotice title={say("trial.not_tried")} message={refused} />}
      {now?.problem != null && <ErrorNotice title={say("trial.not_tried")} message={now.problem.message} />}
      {busy && <Progress label={workText(now)} share={now.state === "working" ? now.share : undefined} />}
      <div class={of === text ? "stack" : "stack stale"} aria-live="polite">
        {now?.exact != null && now.untouched !== null && (
          <>
            {of !== text && (
              <Notice tone="warning">
                <p>{say("trial.stale")}</p>
              </Notice>
            )}
            <Outcome exact={now.exact} untouched={now.untouched} />
            <p class="hint">{say("trial.took", { time: formatDuration(now.took_s) })}</p>
          </>
        )}
      </div>
    </Card>
  );
}

function workText({ state, ahead }: ExerciseTrial): string {
  return state === "waiting" ? say("trial.waiting", { count: ahead }) : say("trial.working");
}

function Outcome({ exact, untouched }: { readonly exact: TrialScore; readonly untouched: TrialScore }) {
  const exactIsRight = costsOf(exact).length === 0 && !exact.failed;
  const untouchedIsRight = isNothing(untouched.score);
  return (
    <>
      <Score title={say("trial.exact")} score={exact} right={exactIsRight} />
      {!exactIsRight && <p>{say("trial.exact_wrong")}</p>}
      <Score title={say("trial.untouched")} score={untouched} right={untouchedIsRight} />
      {!untouchedIsRight && <p>{say("trial.untouched_wrong")}</p>}
    </>
  );
}

function isNothing(points: number): boolean {
  return points < kScoreStep / 2;
}

function costsOf({ lost }: TrialScore): TrialScore["lost"] {
  return lost.filter(({ points }) => !isNothing(points));
}

interface ScoreProps {
  readonly title: string;
  readonly score: TrialScore;
  readonly right: boolean;
}

// With what it cost, where the score is not what it should be.
function Score({ title, score, right }: ScoreProps) {
  return (
    <div>
      <p>
        <Badge tone={right ? "good" : "bad"}>{say("trial.points", { title, points: formatScore(score.score) })}</Badge>
      </p>
      {!right && (
        <ul>
          {score.critical.map((error) => (
            <li key={error}>{sayIf(`critical_error.${error}`) ?? error}</li>
          ))}
          {costsOf(score).map(({ name, points }) => (
            <li key={name}>{say("trial.costs", { title: lostTitle(name), points: formatPoints(points) })}</li>
          ))}
        </ul>
      )}
    </div>
  );
}

// Of a region, of the whole, or of the hand.
function lostTitle(name: string): string {
  return sayIf(`metric.${name}`) ?? sayIf(`place.${name}`) ?? priceTitle(name);
}
