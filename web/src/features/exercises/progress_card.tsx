import type { Client } from "../../api/client";
import type { Attempt } from "../../api/types";
import { scoreOf } from "../../api/worded";
import { useRequest } from "../../api/use_request";
import { formatNumber, formatPoints } from "../../base/format";
import { ok } from "../../base/result";
import { say } from "../../base/words";
import { Card, Notice } from "../../widgets/basics";
import { DataTable } from "../../widgets/table";
import { type CriterionProgress, type Done, nextStep, progressOf } from "./progress";

const kMostScores = 20; // the newest that are read
const kWidth = 120;
const kHeight = 28;
const kInset = 4;

// How one comes on, and what to work at next. Nothing where no score may be seen yet.
export function ProgressCard({ client, attempts }: { readonly client: Client; readonly attempts: readonly Attempt[] }) {
  const seen = attempts.filter((attempt) => attempt.computed_score !== null).slice(0, kMostScores);
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
      {next !== undefined && (
        <Notice tone="neutral" title={say("progress.next", { title: next.title })}>
          <p>
            {next.of === 1
              ? say("progress.lost_once", { points: formatPoints(next.lost) })
              : say("progress.lost_often", { points: formatPoints(next.lost), count: next.of })}{" "}
            {next.reason}
          </p>
        </Notice>
      )}
      <DataTable
        label={say("progress.table")}
        items={rows}
        rowKey={(row) => row.name}
        dense
        columns={[
          { title: say("common.criterion"), cell: (row) => row.title },
          { title: say("progress.over"), cell: (row) => <Curve row={row} /> },
          { title: say("progress.best"), number: true, cell: (row) => pointsText(row, row.best) },
          { title: say("progress.last"), number: true, cell: (row) => pointsText(row, row.last) },
        ]}
      />
      <p class="hint">{say("progress.of", { count: done.length })}</p>
    </Card>
  );
}

function pointsText({ maxPoints }: CriterionProgress, share: number): string {
  return `${formatPoints(share * maxPoints)} / ${formatPoints(maxPoints)}`;
}

function Curve({ row: { shares, title } }: { readonly row: CriterionProgress }) {
  const x = (i: number) =>
    shares.length === 1 ? kWidth / 2 : kInset + ((kWidth - 2 * kInset) * i) / (shares.length - 1);
  const y = (share: number) => kHeight - kInset - (kHeight - 2 * kInset) * share;
  return (
    <svg
      class="curve"
      viewBox={`0 0 ${kWidth} ${kHeight}`}
      role="img"
      aria-label={say("progress.curve", {
        title,
        shares: shares.map((share) => `${formatNumber(100 * share, 0)} %`).join(", "),
      })}
    >
      <line x1="0" x2={kWidth} y1={y(1)} y2={y(1)} />
      <polyline points={shares.map((share, i) => `${x(i)},${y(share)}`).join(" ")} />
      <circle cx={x(shares.length - 1)} cy={y(shares.at(-1) ?? 0)} r="3" />
    </svg>
  );
}
