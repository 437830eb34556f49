import type { Client } from "../../api/client";
import { type CriterionProgress, type Done, nextStep, progressOf } from "../../api/progress";
import type { Attempt } from "../../api/types";
import { scoreOf } from "../../api/worded";
import { useRequest } from "../../api/use_request";
import { formatPoints, lostText } from "../../base/format";
import { ok } from "../../base/result";
import { say } from "../../base/words";
import { Card } from "../../widgets/basics";
import { Curve } from "../../widgets/curve";
import { NextStepNotice } from "../../widgets/next_step";
import { DataTable } from "../../widgets/table";

const kMaxScores = 20; // the newest that are read

// How one comes on, and what to work at next. Nothing where no score may be seen yet.
export function ProgressCard({ client, attempts }: { readonly client: Client; readonly attempts: readonly Attempt[] }) {
  const seen = attempts.filter((attempt) => attempt.computed_score !== null).slice(0, kMaxScores);
  const { loaded } = useRequest(
    seen.length === 0 ? undefined : seen.map(({ id, computed_score: score }) => `${id} ${score}`).join(),
    async (signal) => {
      const scores = await Promise.all(
        seen.map(async ({ id, ticketed_ms: atMs }): Promise<Done[]> => {
          const score = await scoreOf(client, id, signal);
          return score.ok ? [{ id, atMs, score: score.value }] : [];
        }),
      );
      return ok(scores.flat());
    },
  );
  const done = loaded.state === "ready" ? loaded.value : [];
  const rows = progressOf(done);
  if (rows.length === 0) return null;
  const next = nextStep(done);
  return (
    <Card title={say("progress.title")}>
      {next !== undefined && <NextStepNotice next={next} />}
      <DataTable
        label={say("progress.table")}
        items={rows}
        rowKey={(row) => row.name}
        dense
        columns={[
          { title: say("common.criterion"), cell: (row) => row.title },
          { title: say("progress.over"), cell: lostCurve },
          { title: say("progress.best"), number: true, cell: (row) => lostText(row.least) },
          { title: say("progress.last"), number: true, cell: (row) => lostText(row.last) },
        ]}
      />
      <p class="hint">{say("progress.of", { count: done.length })}</p>
    </Card>
  );
}

// As a score goes: what lost nothing is on top.
function lostCurve({ title, lost, most }: CriterionProgress) {
  return (
    <Curve
      shares={lost.map((points) => (most > 0 ? 1 - points / most : 1))}
      label={say("progress.lost_curve", { title, points: lost.map(formatPoints).join(", ") })}
    />
  );
}
