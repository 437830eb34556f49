import type { Client } from "../../api/client";
import type { AttemptDetail, Metric, Score } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatBytes, formatDateTime, formatDuration, formatNumber, formatQuantity, formatScore, metricTitle, plural } from "../../base/format";
import { Badge, Card, Notice } from "../../widgets/basics";
import { DataTable } from "../../widgets/table";
import { heldBy, recordingFacts, saidFacts } from "./summary";

export function RecordingPanel({ attempt, score }: { readonly attempt: AttemptDetail; readonly score: Score | undefined }) {
  const facts = recordingFacts(attempt, score);
  return (
    <Card title="Recording">
      <Notice tone={facts.complete ? "good" : "warning"} title={facts.headline}>
        {facts.details.length > 0 && <ul>{facts.details.map((text) => <li key={text}>{text}</li>)}</ul>}
      </Notice>
      <dl class="facts stacked">
        <div><dt>Ticks</dt><dd>{formatNumber(attempt.ticks, 0)}</dd></div>
        <div><dt>Gaps</dt><dd>{attempt.gap_ticks === 0 ? "None" : plural(attempt.gap_ticks, "tick")}</dd></div>
        <div><dt>Duration</dt><dd>{formatDuration(attempt.duration_s)}</dd></div>
        <div><dt>Chunks, size</dt><dd>{formatNumber(attempt.chunks, 0)}, {formatBytes(attempt.trace_bytes)}</dd></div>
        <div><dt>Station</dt><dd>{attempt.station.name}</dd></div>
        <div><dt>Device</dt><dd>{attempt.profile.title}</dd></div>
        <div><dt>Held by</dt><dd>{heldBy(attempt.hand)}</dd></div>
        {saidFacts(attempt.facts).map(({ name, value }) => <div key={name}><dt>{name}</dt><dd>{value}</dd></div>)}
        {score !== undefined && <div><dt>Replay</dt><dd>core version {score.core_version}</dd></div>}
      </dl>
    </Card>
  );
}

export function MetricsPanel({ metrics }: { readonly metrics: readonly Metric[] }) {
  return (
    <Card title="All measurements">
      <dl class="facts stacked two">
        {metrics.map((metric) => (
          <div key={metric.name}><dt>{metricTitle(metric.name, metric.unit)}</dt><dd>{formatQuantity(metric.value, metric.unit)}</dd></div>
        ))}
      </dl>
    </Card>
  );
}

const kCauses: Readonly<Record<string, string>> = {
  seal: "When the attempt was finished", reference: "A new reference came", rescore: "Asked for by an instructor", appeal: "After an appeal", rubric: "Scored again with the whole cohort", restore: "An earlier score counts again",
};

// Every time the attempt was scored; nothing to say as long as that was once.
export function RunsPanel({ client, requestKey, attemptId }: { readonly client: Client; readonly requestKey: string; readonly attemptId: string }) {
  const { loaded } = useRequest(requestKey, (signal) => client.teaching.results(attemptId, signal));
  if (loaded.state !== "ready" || loaded.value.length < 2) return null;
  return (
    <Card title="Scored more than once">
      <DataTable label="Scoring runs, newest first" items={loaded.value} dense columns={[
        { title: "When", cell: (run) => formatDateTime(run.scored_ms) },
        { title: "Why", cell: (run) => kCauses[run.cause] ?? run.cause },
        { title: "Score", number: true, cell: (run) => <>{formatScore(run.score.score)} {run.score.critical_fail && <Badge tone="bad">Critical</Badge>}</> },
      ]} />
      <p class="hint">The newest counts.</p>
    </Card>
  );
}
