import type { ServerHealth } from "../../api/types";
import { formatBytes, formatDuration, formatNumber, plural } from "../../base/format";
import type { Tone } from "../../widgets/basics";

// What is wrong with the server, in words, and what to do. The worst comes first.

export interface Finding {
  readonly tone: Tone;
  readonly title: string;
  readonly text: string;
  readonly link?: { readonly path: string; readonly title: string };
}

const kDayMs = 86_400_000;
const kBackupLateMs = 8 * kDayMs;               // a backup a week, and a day to spare
const kSlowCommitS = 0.5;                       // a station's spool waits for it, and a person at the page
const kManyJobs = 50;
const kManyThrottled = 20;                      // what one person who has forgotten a password makes
const kRank: Readonly<Record<Tone, number>> = { bad: 0, warning: 1, neutral: 2, good: 3 };

export function findingsOf(health: ServerHealth): Finding[] {
  return [...ingestFindings(health), ...diskFindings(health), ...workFindings(health), ...backupFindings(health), ...doorFindings(health)]
    .sort((a, b) => kRank[a.tone] - kRank[b.tone]);
}

function ingestFindings({ ingest, recordings, stations }: ServerHealth): Finding[] {
  const out: Finding[] = [];
  if (!ingest.takes_recordings) {
    out.push({ tone: "bad", title: "Recordings are not taken", text: sentence(ingest.problem) });
  }
  if (ingest.waiting !== "") out.push({ tone: "warning", title: "Changes wait", text: sentence(ingest.waiting) });
  if (recordings.late.length > 0) {
    const longest = Math.max(...recordings.late.map((row) => row.silent_ms));
    out.push({ tone: "warning", title: `Nothing comes from ${plural(recordings.late.length, "attempt")} in progress`,
               text: `Silent for up to ${formatDuration(longest / 1000)}. Look at the station: is it switched on, is the network cable in? What it records is kept there.`, link: { path: "/live", title: "Live" } });
  }
  if (stations.enrolled === 0) out.push({ tone: "warning", title: "No station is enrolled", text: "Make an enrolment code and type the command that is shown at the station.", link: { path: "/stations", title: "Stations" } });
  return out;
}

function diskFindings({ disk, commits }: ServerHealth): Finding[] {
  const out: Finding[] = [];
  if (disk.free_bytes < 2 * disk.kept_free_bytes) {
    out.push({ tone: disk.free_bytes < disk.kept_free_bytes ? "bad" : "warning", title: "The disk is nearly full",
               text: `${formatBytes(disk.free_bytes)} are free; recordings stop below ${formatBytes(disk.kept_free_bytes)}. Make room, or set a retention rule.` });
  }
  if (commits.failed > 0) out.push({ tone: "warning", title: `${plural(commits.failed, "change")} could not be written since the start`, text: "The server's log says why. Look at the disk." });
  if (commits.timed > 0 && commits.p99_s > kSlowCommitS) {
    out.push({ tone: "warning", title: "Writing is slow", text: `One write in a hundred takes ${shortTime(commits.p99_s)} or longer. See what else uses this disk.` });
  }
  return out;
}

function workFindings({ jobs }: ServerHealth): Finding[] {
  const out: Finding[] = [];
  if (jobs.failed > 0) {
    out.push({ tone: "warning", title: `${countText(jobs.failed, jobs.counted_up_to)} ${jobs.failed === 1 ? "job has" : "jobs have"} failed`, text: "Their attempts have no score. Open them: each says why. Then score again.", link: { path: "/jobs?state=failed", title: "Failed jobs" } });
  }
  if (jobs.queued > kManyJobs) {
    out.push({ tone: "warning", title: `${countText(jobs.queued, jobs.counted_up_to)} jobs wait`, text: "Scores come late. If this goes on, let the server use more threads (--job-threads).", link: { path: "/jobs?state=queued", title: "Waiting jobs" } });
  }
  return out;
}

function backupFindings({ backup, now_ms: now }: ServerHealth): Finding[] {
  const todo = "Run enamel-server backup on the server, best every night.";
  if (backup === null) return [{ tone: "warning", title: "No backup was made yet", text: todo }];
  const out: Finding[] = [];
  if (backup.missing > 0) out.push({ tone: "bad", title: `The last backup misses ${plural(backup.missing, "file")}`, text: "They were gone or damaged in the data folder. Run enamel-server verify: it names them." });
  if (now - backup.at_ms > kBackupLateMs) out.push({ tone: "warning", title: `The last backup is ${plural(Math.floor((now - backup.at_ms) / kDayMs), "day")} old`, text: todo });
  return out;
}

function doorFindings({ sign_ins: door }: ServerHealth): Finding[] {
  if (door.throttled < kManyThrottled) return [];
  return [{ tone: "warning", title: `${plural(door.throttled, "sign-in")} were held back since the start`, text: "Somebody may be guessing passwords. The audit trail says at which address.", link: { path: "/audit?action=session.refused", title: "Refused sign-ins" } }];
}

// As far as the server counts.
export function countText(count: number, upTo: number): string {
  return count >= upTo ? `${formatNumber(upTo, 0)} or more` : formatNumber(count, 0);
}

const kKept: Readonly<Record<string, string>> = { unfinished: "Attempts never finished", recordings: "Recordings", attempts: "Attempts with their scores" };

// What a rule removes, and when.
export function retentionText({ what, days }: ServerHealth["retention"][number]): readonly [string, string] {
  return [kKept[what] ?? what, `removed after ${plural(days, "day")}`];
}

// As the server says it, which is without a capital and a full stop.
function sentence(text: string): string {
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}${text.endsWith(".") ? "" : "."}`;
}

// Of a write: thousandths are what tells a fast disk from a slow one.
export function shortTime(seconds: number): string {
  return seconds < 1 ? `${formatNumber(1000 * seconds, seconds < 0.01 ? 1 : 0)}\u00a0ms` : formatDuration(seconds);
}

// Of a count that rises, how much in a second between two looks; undefined where the server was started anew in between.
export function perSecond(before: ServerHealth | undefined, now: ServerHealth, count: (health: ServerHealth) => number): number | undefined {
  if (before === undefined || before.started_ms !== now.started_ms || now.now_ms <= before.now_ms) return undefined;
  return (count(now) - count(before)) / ((now.now_ms - before.now_ms) / 1000);
}
