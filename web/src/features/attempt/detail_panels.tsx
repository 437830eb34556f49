import { wordedTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import { addressOf } from "../../api/http";
import type { AttemptDetail, Metric, Score } from "../../api/types";
import { useRequest } from "../../api/use_request";
import {
  formatBytes,
  formatDateTime,
  formatDuration,
  formatLimit,
  formatNumber,
  formatQuantity,
  formatScore,
} from "../../base/format";
import { metricTitle } from "../../base/metric_titles";
import { say } from "../../base/words";
import { Badge, Card, Notice } from "../../widgets/basics";
import { still } from "../../widgets/still";
import { DataTable } from "../../widgets/table";
import { heldBy, recordingFacts, saidFacts } from "./summary";

export const RecordingPanel = still(function RecordingPanel({
  attempt,
  score,
  alone = false,
}: {
  readonly attempt: AttemptDetail;
  readonly score: Score | undefined;
  readonly alone?: boolean; // there is no server
}) {
  const facts = recordingFacts(attempt, score);
  return (
    <Card title={say("recording.title")}>
      <Notice tone={facts.complete ? "good" : "warning"} title={facts.headline}>
        {facts.details.length > 0 && (
          <ul>
            {facts.details.map((text) => (
              <li key={text}>{text}</li>
            ))}
          </ul>
        )}
      </Notice>
      <dl class="facts stacked">
        <div>
          <dt>{say("recording.ticks")}</dt>
          <dd>{formatNumber(attempt.ticks, 0)}</dd>
        </div>
        <div>
          <dt>{say("recording.gaps")}</dt>
          <dd>
            {attempt.gap_ticks === 0 ? say("common.none_there") : say("count.ticks", { count: attempt.gap_ticks })}
          </dd>
        </div>
        <div>
          <dt>{say("recording.duration")}</dt>
          <dd>{formatDuration(attempt.duration_s)}</dd>
        </div>
        <div>
          <dt>{say("recording.size")}</dt>
          <dd>{formatBytes(attempt.trace_bytes)}</dd>
        </div>
        <div>
          <dt>{say("common.station")}</dt>
          <dd>{attempt.station.name}</dd>
        </div>
        <div>
          <dt>{say("common.device")}</dt>
          <dd>{wordedTitle(attempt.profile.title)}</dd>
        </div>
        <div>
          <dt>{say("recording.held_by")}</dt>
          <dd>{heldBy(attempt.hand)}</dd>
        </div>
        {saidFacts(attempt.facts).map(({ name, value }) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>{value}</dd>
          </div>
        ))}
        {score !== undefined && (
          <div>
            <dt>{say("recording.replay")}</dt>
            <dd>{say("recording.core", { version: String(score.core_version) })}</dd>
          </div>
        )}
        {attempt.result_fingerprint !== null && (
          <div>
            <dt>{say("recording.fingerprint")}</dt>
            <dd class="fingerprint">{attempt.result_fingerprint}</dd>
          </div>
        )}
      </dl>
      {attempt.result_fingerprint !== null && !alone && (
        <p class="no-print">
          <a href={addressOf("/attempts/{id}/signed-result", { id: attempt.id })} download>
            {say("recording.save_signed")}
          </a>
        </p>
      )}
    </Card>
  );
});

export const MetricsPanel = still(function MetricsPanel({ metrics }: { readonly metrics: readonly Metric[] }) {
  return (
    <Card title={say("recording.all_measurements")}>
      <dl class="facts stacked two">
        {metrics.map((metric) => (
          <div key={metric.name}>
            <dt>{metricTitle(metric.name, metric.unit)}</dt>
            <dd>
              {formatQuantity(metric.value, metric.unit)}
              {metric.below_grid !== undefined && (
                <p class="hint">{say("reason.below_grid", { limit: formatLimit(metric.below_grid, metric.unit) })}</p>
              )}
            </dd>
          </div>
        ))}
      </dl>
    </Card>
  );
});

// Every time the attempt was scored; nothing to say as long as that was once.
export const RunsPanel = still(function RunsPanel({
  client,
  requestKey,
  attemptId,
}: {
  readonly client: Client;
  readonly requestKey: string;
  readonly attemptId: string;
}) {
  const { loaded } = useRequest(requestKey, (signal) =>
    client.all("/attempts/{id}/results", { id: attemptId, signal }),
  );
  if (loaded.state !== "ready" || loaded.value.length < 2) return null;
  return (
    <Card title={say("recording.runs")}>
      <DataTable
        label={say("recording.runs_table")}
        items={loaded.value}
        dense
        columns={[
          { title: say("common.when"), cell: (run) => formatDateTime(run.scored_ms) },
          { title: say("jobs.why"), cell: (run) => say(`run_cause.${run.cause}`) },
          {
            title: say("common.score"),
            number: true,
            cell: (run) => (
              <>
                {formatScore(run.score.score)}{" "}
                {run.score.critical_fail && <Badge tone="bad">{say("attempt_flag.critical")}</Badge>}
              </>
            ),
          },
        ]}
      />
      <p class="hint">{say("recording.newest_counts")}</p>
    </Card>
  );
});
