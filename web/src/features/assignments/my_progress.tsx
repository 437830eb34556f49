import type { Client } from "../../api/client";
import { type Done, nextStep } from "../../api/progress";
import type { Attempt } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { scoreOf } from "../../api/worded";
import { formatNumber, formatScore } from "../../base/format";
import { ok } from "../../base/result";
import { say } from "../../base/words";
import { Curve } from "../../widgets/curve";
import { NextStepNotice } from "../../widgets/next_step";

const kMaxAttempts = 20;
const kLookedAt = 3; // scores that say what to work on (api/progress.ts)

interface Seen extends Attempt {
  readonly score: number;
}
interface Mine {
  readonly seen: readonly Seen[]; // newest first, those whose score may be seen
  readonly done: readonly Done[];
}

// A student's attempts under an assignment: the best and the last score, how they came on, and what to do next.
export function MyProgress({ client, assignment, used }: { client: Client; assignment: string; used: number }) {
  const { loaded } = useRequest(`${assignment} ${used}`, async (signal) => {
    const attempts = await client.page("/attempts", { assignment, state: "scored", limit: kMaxAttempts, signal });
    if (!attempts.ok) return attempts;
    const seen = attempts.value.items.filter((attempt): attempt is Seen => attempt.score !== null);
    const done = await Promise.all(
      seen.slice(0, kLookedAt).map(async ({ id, ticketed_ms: atMs }): Promise<Done[]> => {
        const score = await scoreOf(client, id, signal);
        return score.ok ? [{ id, atMs, score: score.value }] : [];
      }),
    );
    return ok<Mine>({ seen, done: done.flat() });
  });
  if (loaded.state !== "ready") return null;
  const { seen, done } = loaded.value;
  const [last] = seen;
  if (last === undefined) return null;
  const best = seen.reduce((a, b) => (b.score > a.score ? b : a));
  const oldestFirst = seen.map(({ score }) => score).reverse();
  const next = nextStep(done);
  return (
    <>
      <dl class="facts my-scores">
        {seen.length > 1 && <ScoreFact title={say("progress.best")} attempt={best} />}
        <ScoreFact title={say("progress.last")} attempt={last} />
        {seen.length > 1 && (
          <div>
            <dt>{say("progress.over")}</dt>
            <dd>
              <Curve
                shares={oldestFirst.map((score) => score / 100)}
                label={say("progress.curve", {
                  title: say("common.score"),
                  shares: oldestFirst.map((score) => `${formatNumber(score, 0)} %`).join(", "),
                })}
              />
            </dd>
          </div>
        )}
      </dl>
      {next !== undefined && <NextStepNotice next={next} />}
    </>
  );
}

function ScoreFact({ title, attempt: { id, score } }: { readonly title: string; readonly attempt: Seen }) {
  return (
    <div>
      <dt>{title}</dt>
      <dd>
        <a href={`/attempts/${id}`}>{formatScore(score)}</a>
      </dd>
    </div>
  );
}
