import type { ApiResult, Client } from "../../api/client";
import type { AuditEntry, Job, Profile, Station } from "../../api/types";
import { ok } from "../../base/result";
import { formatDateTime, formatNumber, unitText } from "../../base/format";
import { Badge, Card, Empty, type Tone } from "../../widgets/basics";
import { AdminList, type Column, DataTable } from "./admin_list";

const kAuditRows = 200;

interface Props {
  readonly client: Client;
}

export function PeoplePage({ client }: Props) {
  return (
    <AdminList title="People" empty="There is no cohort yet." ask={async (signal) => mapOk(await client.cohorts(signal), (value) => value.cohorts)}>
      {(cohorts) => cohorts.map((cohort) => (
        <Card key={cohort.id} title={cohort.name}>
          {cohort.members.length === 0 ? <Empty>Nobody is in this cohort yet.</Empty> : (
            <DataTable label={`Members of ${cohort.name}`} items={cohort.members}
                       columns={[{ title: "Name", cell: (member) => member.display_name }, { title: "Role", cell: (member) => capital(member.role) }]} />
          )}
        </Card>
      ))}
    </AdminList>
  );
}

const kStationColumns: readonly Column<Station>[] = [
  { title: "Station", cell: (station) => station.name },
  { title: "State", cell: (station) => station.revoked ? <Badge tone="bad">Revoked</Badge> : <Badge tone="good">Enrolled</Badge> },
  { title: "Enrolled", cell: (station) => formatDateTime(station.enrolled_ms) },
  { title: "Last seen", cell: (station) => station.last_seen_ms === 0 ? "Never" : formatDateTime(station.last_seen_ms) },
];

export function StationsPage({ client }: Props) {
  return (
    <AdminList title="Stations" empty="No station is enrolled yet." ask={async (signal) => mapOk(await client.stations(signal), (value) => value.stations)}>
      {(stations) => <Card><DataTable label="Stations" items={stations} columns={kStationColumns} /></Card>}
    </AdminList>
  );
}

const kNumberColumns: readonly Column<Profile["numbers"][number]>[] = [
  { title: "Number", cell: (number) => capital(number.name.replaceAll("_", " ")) },
  { title: "Value", number: true, cell: (number) => `${formatNumber(number.value, 3)} ${unitText(number.unit)}` },
  { title: "Where it is from", cell: (number) => number.source },
];

export function ProfilesPage({ client }: Props) {
  return (
    <AdminList title="Device profiles" empty="There is no device profile yet."
               ask={async (signal) => mapOk(await client.profiles(signal), (value) => value.profiles)}>
      {(profiles) => profiles.map((profile) => (
        <Card key={profile.name} title={profile.title}>
          <DataTable label={`Numbers of ${profile.title}`} items={profile.numbers} columns={kNumberColumns} />
        </Card>
      ))}
    </AdminList>
  );
}

const kJobTones: Readonly<Record<Job["state"], Tone>> = { queued: "neutral", running: "neutral", done: "good", failed: "bad" };
const kJobColumns: readonly Column<Job>[] = [
  { title: "Job", cell: (job) => <a href={`/attempts/${job.attempt_id}`}>{capital(job.kind)} attempt {job.attempt_id.slice(0, 8)}</a> },
  { title: "State", cell: (job) => <Badge tone={kJobTones[job.state]}>{capital(job.state)}</Badge> },
  { title: "Tries", number: true, cell: (job) => job.tries },
  { title: "Problem", cell: (job) => job.error === "" ? "–" : job.error },
];

export function JobsPage({ client }: Props) {
  return (
    <AdminList title="Jobs" empty="There is no job." ask={async (signal) => mapOk(await client.jobs(signal), (value) => value.jobs)}>
      {(jobs) => <Card><DataTable label="Jobs" items={jobs} columns={kJobColumns} /></Card>}
    </AdminList>
  );
}

const kAuditColumns: readonly Column<AuditEntry>[] = [
  { title: "When", cell: (entry) => <span class="nowrap">{formatDateTime(entry.at_ms)}</span> },
  { title: "Who", cell: (entry) => entry.actor },
  { title: "What", cell: (entry) => <code>{entry.action}</code> },
  { title: "On", cell: (entry) => <code>{entry.object}</code> },
  { title: "Before", cell: (entry) => <code class="json">{entry.before === "" ? "–" : entry.before}</code> },
  { title: "After", cell: (entry) => <code class="json">{entry.after === "" ? "–" : entry.after}</code> },
];

export function AuditPage({ client }: Props) {
  return (
    <AdminList title="Audit" empty="Nothing was changed yet." ask={async (signal) => mapOk(await client.audit(kAuditRows, signal), (value) => value.audit)}>
      {(entries) => <Card><DataTable label="Audit, newest first" items={entries} columns={kAuditColumns} /></Card>}
    </AdminList>
  );
}

function mapOk<T, U>(result: ApiResult<T>, change: (value: T) => U): ApiResult<U> {
  return result.ok ? ok(change(result.value)) : result;
}

function capital(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
