import { useRef } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ServerHealth } from "../../api/types";
import { useRefresh } from "../../api/use_refresh";
import { useRequest } from "../../api/use_request";
import { formatBytes, formatNumber } from "../../base/format";
import { relativeTime } from "../../base/local_time";
import { say } from "../../base/words";
import { Card, Notice, PageTitle, Waits } from "../../widgets/basics";
import { BackupCard } from "./backup_card";
import { Facts } from "./facts";
import { FirstSteps } from "./first_steps";
import { budgetText, countText, findingsOf, perSecond, shortTime } from "./health_text";

const kPollMs = 5000;
const kBackupPollMs = 1000; // while one runs here, which somebody watches

// How the server does: what is wrong first, then the figures.
export function HealthPage({ client }: { readonly client: Client }) {
  const { loaded, reload } = useRequest("health", (signal) => client.get("/health", { signal }));
  const now = loaded.state === "ready" ? loaded.value : undefined;
  useRefresh(true, now?.backups.running?.here === true ? kBackupPollMs : kPollMs, reload);
  const before = useRef<ServerHealth | undefined>(undefined);
  const last = useRef<ServerHealth | undefined>(undefined);
  if (now !== last.current) [before.current, last.current] = [last.current, now];
  return (
    <>
      <PageTitle document={say("nav.health")}>{say("nav.health")}</PageTitle>
      <Waits loaded={loaded} reload={reload} what={say("loading.health")} failed={say("health.failed")} />
      {now !== undefined && (
        <>
          <Findings health={now} />
          <FirstSteps client={client} backedUp={now.backup !== null} stations={now.stations.enrolled} />
          <Figures client={client} health={now} before={before.current} onStart={reload} />
        </>
      )}
    </>
  );
}

function Findings({ health }: { readonly health: ServerHealth }) {
  const findings = findingsOf(health);
  return (
    <div class="stack" aria-live="polite">
      {findings.length === 0 && (
        <Notice tone="good" title={say("health.well")}>
          <p>{say("health.well_text")}</p>
        </Notice>
      )}
      {findings.map(({ tone, title, text, link }) => (
        <Notice key={title} tone={tone} title={title}>
          <p>
            {text}
            {link !== undefined && (
              <>
                {" "}
                <a href={link.path}>{link.title}</a>
              </>
            )}
          </p>
        </Notice>
      ))}
    </div>
  );
}

function Figures({
  client,
  health,
  before,
  onStart,
}: {
  readonly client: Client;
  readonly health: ServerHealth;
  readonly before: ServerHealth | undefined;
  readonly onStart: () => void;
}) {
  const { ingest, commits, disk, jobs, stations, recordings, sign_ins: door, budgets } = health;
  const chunks = perSecond(before, health, (each) => each.ingest.chunks);
  const count = (value: number) => countText(value, jobs.counted_up_to);
  return (
    <>
      <div class="health">
        <Card title={say("health.recordings")}>
          <Facts
            rows={[
              [
                say("health.connected"),
                say("count.of", { part: String(stations.online), whole: String(stations.enrolled) }),
              ],
              [say("health.in_progress"), formatNumber(recordings.open, 0)],
              [say("health.silent"), formatNumber(recordings.late.length, 0)],
              [
                say("health.arriving"),
                chunks === undefined ? "–" : say("health.a_second", { count: formatNumber(chunks, 1) }),
              ],
              [say("health.finished"), formatNumber(ingest.sealed, 0)],
              [say("health.taken"), formatBytes(ingest.chunk_bytes)],
            ]}
          />
        </Card>
        <Card title={say("health.writing")}>
          <Facts
            rows={[
              [say("health.writes_99"), commits.timed === 0 ? "–" : shortTime(commits.p99_s)],
              [say("health.writes"), formatNumber(commits.count, 0)],
              [say("health.writes_failed"), formatNumber(commits.failed, 0)],
              [say("health.free"), formatBytes(disk.free_bytes)],
              [say("health.kept_free"), formatBytes(disk.kept_free_bytes)],
              [say("health.database"), `${formatBytes(disk.database_bytes)} + ${formatBytes(disk.log_bytes)}`],
            ]}
          />
        </Card>
        <Card title={say("health.scoring")} aside={<a href="/jobs">{say("health.all_jobs")}</a>}>
          <Facts
            rows={[
              [say("job_state.queued"), count(jobs.queued)],
              [say("job_state.running"), count(jobs.running)],
              [say("job_state.failed"), count(jobs.failed)],
            ]}
          />
        </Card>
        <Card title={say("health.sign_ins")} aside={<a href="/audit?action=session.">{say("health.in_audit")}</a>}>
          <Facts
            rows={[
              [say("health.signed_in"), formatNumber(door.signed_in, 0)],
              [say("health.wrong"), formatNumber(door.refused, 0)],
              [say("health.held_back"), formatNumber(door.throttled, 0)],
              [say("health.turned_away"), formatNumber(door.busy, 0)],
            ]}
          />
        </Card>
        <Card title={say("health.budgets")}>
          <Facts rows={budgets.map(budgetText)} />
        </Card>
        <BackupCard client={client} health={health} onStart={onStart} />
      </div>
      <p class="hint">
        {say("health.counted", { since: relativeTime(health.started_ms, health.now_ms), count: commits.timed })}
      </p>
    </>
  );
}
