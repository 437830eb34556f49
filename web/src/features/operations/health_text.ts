import type { ServerHealth } from "../../api/types";
import { formatBytes, formatDuration, formatNumber } from "../../base/format";
import { say, sayIf } from "../../base/words";
import type { Tone } from "../../widgets/basics";

// Problems of the server in words, with what to do. The worst comes first.

export interface Finding {
  readonly tone: Tone;
  readonly title: string;
  readonly text: string;
  readonly link?: { readonly path: string; readonly title: string };
}

const kDayMs = 86_400_000;
const kBackupLateMs = 8 * kDayMs; // a backup a week, and a day to spare
const kSlowCommitS = 0.5; // a station's spool waits for it, and a person at the page
const kManyJobs = 50;
const kManyThrottled = 20; // what one person who has forgotten a password makes
const kRank: Readonly<Record<Tone, number>> = { bad: 0, warning: 1, neutral: 2, good: 3 };

export function findingsOf(health: ServerHealth): Finding[] {
  return [
    ...ingestFindings(health),
    ...clockFindings(health),
    ...standbyFindings(health),
    ...diskFindings(health),
    ...workFindings(health),
    ...backupFindings(health),
    ...doorFindings(health),
  ].sort((a, b) => kRank[a.tone] - kRank[b.tone]);
}

function ingestFindings({ ingest, recordings, standby, stations }: ServerHealth): Finding[] {
  const out: Finding[] = [];
  if (!ingest.takes_recordings) {
    out.push({ tone: "bad", title: say("finding.not_taken"), text: sentence(ingest.problem) });
  }
  // A missing standby has a finding of its own.
  if (ingest.waiting !== "" && standby !== "missing")
    out.push({ tone: "warning", title: say("finding.waits"), text: sentence(ingest.waiting) });
  if (recordings.late.length > 0) {
    const longest = Math.max(...recordings.late.map((row) => row.silent_ms));
    out.push({
      tone: "warning",
      title: say("finding.silent", { count: recordings.late.length }),
      text: say("finding.silent_text", { span: formatDuration(longest / 1000) }),
      link: { path: "/live", title: say("nav.live") },
    });
  }
  if (stations.enrolled === 0)
    out.push({
      tone: "warning",
      title: say("finding.no_station"),
      text: say("finding.no_station_text"),
      link: { path: "/stations", title: say("nav.stations") },
    });
  return out;
}

function clockFindings({ clock }: ServerHealth): Finding[] {
  if (clock.problem === "") return [];
  const span = formatDuration(Math.abs(clock.ahead_ms) / 1000);
  return [
    {
      tone: "bad",
      title: say("finding.clock"),
      text: clock.ahead_ms > 0 ? say("finding.clock_ahead", { span }) : say("finding.clock_behind", { span }),
    },
  ];
}

function standbyFindings({ standby }: ServerHealth): Finding[] {
  if (standby === "missing")
    return [{ tone: "bad", title: say("finding.standby_missing"), text: say("finding.standby_missing_text") }];
  if (standby !== "none" && standby !== "behind") return [];
  return [{ tone: "warning", title: say("finding.standby"), text: say("finding.standby_text") }];
}

function diskFindings({ disk, commits }: ServerHealth): Finding[] {
  const out: Finding[] = [];
  if (disk.free_bytes < 2 * disk.kept_free_bytes) {
    out.push({
      tone: disk.free_bytes < disk.kept_free_bytes ? "bad" : "warning",
      title: say("finding.disk"),
      text: say("finding.disk_text", { free: formatBytes(disk.free_bytes), kept: formatBytes(disk.kept_free_bytes) }),
    });
  }
  if (commits.failed > 0)
    out.push({
      tone: "warning",
      title: say("finding.writes", { count: commits.failed }),
      text: say("finding.writes_text"),
    });
  if (commits.timed > 0 && commits.p99_s > kSlowCommitS) {
    out.push({
      tone: "warning",
      title: say("finding.slow"),
      text: say("finding.slow_text", { span: shortTime(commits.p99_s) }),
    });
  }
  return out;
}

function workFindings({ jobs }: ServerHealth): Finding[] {
  const out: Finding[] = [];
  if (jobs.failed > 0) {
    out.push({
      tone: "warning",
      title: say("finding.jobs_failed", { count: jobs.failed, text: countText(jobs.failed, jobs.counted_up_to) }),
      text: say("finding.jobs_failed_text"),
      link: { path: "/jobs?state=failed", title: say("finding.jobs_failed_link") },
    });
  }
  if (jobs.queued > kManyJobs) {
    out.push({
      tone: "warning",
      title: say("finding.jobs_wait", { count: countText(jobs.queued, jobs.counted_up_to) }),
      text: say("finding.jobs_wait_text"),
      link: { path: "/jobs?state=queued", title: say("finding.jobs_wait_link") },
    });
  }
  return out;
}

function backupFindings({ backup, backups: { failed, drill }, now_ms: now }: ServerHealth): Finding[] {
  const todo = say("finding.backup_todo");
  const out: Finding[] = [];
  if (failed !== null)
    out.push({ tone: "warning", title: say("finding.backup_failed"), text: sentence(failed.problem) });
  if (drill !== null && drill.problem !== "")
    out.push({ tone: "warning", title: say("finding.drill_failed"), text: sentence(drill.problem) });
  if (backup === null) return [...out, { tone: "warning", title: say("finding.no_backup"), text: todo }];
  if (backup.missing > 0)
    out.push({
      tone: "bad",
      title: say("finding.backup_misses", { count: backup.missing }),
      text: say("finding.backup_misses_text"),
    });
  if (now - backup.at_ms > kBackupLateMs)
    out.push({
      tone: "warning",
      title: say("finding.backup_old", { count: Math.floor((now - backup.at_ms) / kDayMs) }),
      text: todo,
    });
  return out;
}

function doorFindings({ sign_ins: door }: ServerHealth): Finding[] {
  if (door.throttled < kManyThrottled) return [];
  return [
    {
      tone: "warning",
      title: say("finding.held_back", { count: door.throttled }),
      text: say("finding.held_back_text"),
      link: { path: "/audit?action=session.refused", title: say("finding.held_back_link") },
    },
  ];
}

// As far as the server counts.
export function countText(count: number, upTo: number): string {
  return count >= upTo ? say("health.or_more", { count: formatNumber(upTo, 0) }) : formatNumber(count, 0);
}

const kept = (): Readonly<Record<string, string>> => ({
  unfinished: say("retention.unfinished"),
  recordings: say("health.recordings"),
  attempts: say("retention.attempts"),
});

// What a rule removes, and when.
export function retentionText({ what, days }: ServerHealth["retention"][number]): readonly [string, string] {
  return [kept()[what] ?? what, say("retention.after", { count: days })];
}

// A budget: what the party that uses most uses, which one that is, and how often one wanted more.
export function budgetText(budget: ServerHealth["budgets"][number]): readonly [string, string] {
  const { most, limit, of, refused, unit } = budget;
  const amount = (value: number) => {
    // In MiB, as the setting has it.
    if (unit === "bytes") return `${formatNumber(value / 2 ** 20, 1)}\u00a0MiB`;
    return `${formatNumber(value, 0)}${unit === "percent" ? "\u00a0%" : ""}`;
  };
  let use = say("count.of", { part: amount(most), whole: amount(limit) });
  if (of !== null) {
    use = say("health.budget_by", { use, who: of.kind === "address" ? say("health.an_address") : of.name });
  }
  return [
    sayIf(`budget.${budget.budget}`) ?? budget.budget,
    refused === 0 ? use : say("health.budget_refused", { use, count: refused }),
  ];
}

// As the server says it, which is without a capital and a full stop.
function sentence(text: string): string {
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}${text.endsWith(".") ? "" : "."}`;
}

// Of a write: thousandths are what tells a fast disk from a slow one.
export function shortTime(seconds: number): string {
  return seconds < 1 ? `${formatNumber(1000 * seconds, seconds < 0.01 ? 1 : 0)}\u00a0ms` : formatDuration(seconds);
}

// Of a count that rises, how much in a second between two looks; undefined where the server
// restarted in between.
export function perSecond(
  before: ServerHealth | undefined,
  now: ServerHealth,
  count: (health: ServerHealth) => number,
): number | undefined {
  if (before === undefined || before.started_ms !== now.started_ms || now.now_ms <= before.now_ms) return undefined;
  return (count(now) - count(before)) / ((now.now_ms - before.now_ms) / 1000);
}
