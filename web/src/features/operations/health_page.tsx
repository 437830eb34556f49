import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ServerHealth } from "../../api/types";
import { useRefresh } from "../../api/use_refresh";
import { useRequest } from "../../api/use_request";
import { formatBytes, formatDateTime, formatNumber, plural } from "../../base/format";
import { relativeTime } from "../../base/local_time";
import { Card, ErrorNotice, Loading, Notice, PageTitle } from "../../widgets/basics";
import { FirstSteps } from "./first_steps";
import { countText, findingsOf, perSecond, retentionText, shortTime } from "./health_text";

const kPollMs = 5000;

// How the server does: what is wrong first, then the figures.
export function HealthPage({ client }: { readonly client: Client }) {
  const { loaded, reload } = useRequest("health", (signal) => client.operations.health(signal));
  useRefresh(true, kPollMs, reload);
  const now = loaded.state === "ready" ? loaded.value : undefined;
  const before = useRef<ServerHealth | undefined>(undefined);
  const last = useRef<ServerHealth | undefined>(undefined);
  if (now !== last.current) [before.current, last.current] = [last.current, now];
  return (
    <>
      <PageTitle document="Health">Health</PageTitle>
      {loaded.state === "loading" && <Loading what="the server's state" />}
      {loaded.state === "failed" && <ErrorNotice title="The server does not say how it does" message={loaded.error.message} onRetry={reload} />}
      {now !== undefined && <><Findings health={now} /><FirstSteps client={client} backedUp={now.backup !== null} stations={now.stations.enrolled} /><Figures health={now} before={before.current} /></>}
    </>
  );
}

function Findings({ health }: { readonly health: ServerHealth }) {
  const findings = findingsOf(health);
  return (
    <div class="stack" aria-live="polite">
      {findings.length === 0 && <Notice tone="good" title="Nothing needs you"><p>Recordings are taken, and the last backup is whole.</p></Notice>}
      {findings.map(({ tone, title, text, link }) => (
        <Notice key={title} tone={tone} title={title}><p>{text}{link !== undefined && <> <a href={link.path}>{link.title}</a></>}</p></Notice>
      ))}
    </div>
  );
}

function Figures({ health, before }: { readonly health: ServerHealth; readonly before: ServerHealth | undefined }) {
  const { ingest, commits, disk, jobs, stations, recordings, sign_ins: door, backup, retention } = health;
  const chunks = perSecond(before, health, (each) => each.ingest.chunks);
  const count = (value: number) => countText(value, jobs.counted_up_to);
  return (
    <>
      <div class="health">
        <Card title="Recordings">
          <Facts rows={[["Stations connected", `${stations.online} of ${stations.enrolled}`], ["Attempts in progress", formatNumber(recordings.open, 0)], ["Of those silent", formatNumber(recordings.late.length, 0)],
                        ["Pieces arriving now", chunks === undefined ? "–" : `${formatNumber(chunks, 1)} a second`], ["Attempts finished", formatNumber(ingest.sealed, 0)], ["Taken in all", formatBytes(ingest.chunk_bytes)]]} />
        </Card>
        <Card title="Writing to disk">
          <Facts rows={[["99 of 100 writes take at most", commits.timed === 0 ? "–" : shortTime(commits.p99_s)], ["Writes", formatNumber(commits.count, 0)], ["Writes that failed", formatNumber(commits.failed, 0)],
                        ["Free on the disk", formatBytes(disk.free_bytes)], ["Kept free", formatBytes(disk.kept_free_bytes)], ["Database and its log", `${formatBytes(disk.database_bytes)} + ${formatBytes(disk.log_bytes)}`]]} />
        </Card>
        <Card title="Scoring" aside={<a href="/jobs">All jobs</a>}>
          <Facts rows={[["Waiting", count(jobs.queued)], ["Running", count(jobs.running)], ["Failed", count(jobs.failed)]]} />
        </Card>
        <Card title="Sign-ins" aside={<a href="/audit?action=session.">In the audit trail</a>}>
          <Facts rows={[["Signed in", formatNumber(door.signed_in, 0)], ["Wrong password", formatNumber(door.refused, 0)], ["Held back", formatNumber(door.throttled, 0)], ["Turned away, too many at once", formatNumber(door.busy, 0)]]} />
        </Card>
        <Card title="Backup and retention">
          <Facts rows={[["Last backup", backup === null ? "never" : <span title={formatDateTime(backup.at_ms)}>{relativeTime(backup.at_ms, health.now_ms)}</span>], ["Files it misses", backup === null ? "–" : formatNumber(backup.missing, 0)],
                        ...(retention.length === 0 ? [["Kept", "everything, for good"] as const] : retention.map(retentionText))]} />
        </Card>
      </div>
      <p class="hint">Counted since the server started, {relativeTime(health.started_ms, health.now_ms)}. The last {plural(commits.timed, "write")} were timed. Figures for a monitoring system are at /metrics.</p>
    </>
  );
}

function Facts({ rows }: { readonly rows: ReadonlyArray<readonly [string, ComponentChildren]> }) {
  return <dl class="facts stacked">{rows.map(([name, value], i) => <div key={i}><dt>{name}</dt><dd>{value}</dd></div>)}</dl>;
}
