import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { EnrolCode, MadeEnrolCode, Station } from "../../api/types";
import { tagOf } from "../../api/http";
import { useChange } from "../../api/use_change";
import { usePages } from "../../api/use_pages";
import { useRequest } from "../../api/use_request";
import { formatDateTime } from "../../base/format";
import { relativeTime } from "../../base/local_time";
import { Badge, Card, Empty, ErrorNotice, Loading, Notice, PageTitle } from "../../widgets/basics";
import { Confirm, Dialog, FormButtons } from "../../widgets/dialog";
import { CopyText } from "../../widgets/copy";
import { TextField } from "../../widgets/form";
import { PagedList } from "../../widgets/pages";
import { type Column, DataTable } from "../../widgets/table";
import { ListedDevices } from "./listed_devices";

const kPageSize = 100;
const kCodeMinutes = 60;
const kUsualPort = 8443;                        // of the station link, for a server that does not tell its own
const kSeenNowMs = 2 * 60_000;

// The workstations; an admin enrols, renames and revokes them.
export function StationsPage({ client, admin }: { readonly client: Client; readonly admin: boolean }) {
  const pages = usePages("stations", (cursor, signal) => client.stations.list({ cursor, limit: kPageSize }, signal));
  const [open, setOpen] = useState<{ readonly what: "rename" | "revoke"; readonly station: Station }>();
  const close = () => setOpen(undefined);
  const columns: readonly Column<Station>[] = [
    { title: "Station", cell: (station) => station.name },
    { title: "State", cell: (station) => <StationState station={station} /> },
    { title: "Seen last", cell: (station) => station.last_seen_ms === 0 ? "Never" : <span title={formatDateTime(station.last_seen_ms)}>{relativeTime(station.last_seen_ms, Date.now())}</span> },
    { title: "Software", cell: (station) => station.software === "" ? "–" : `${station.software}, core ${station.core_version}` },
    { title: "Enrolled", cell: (station) => formatDateTime(station.enrolled_ms) },
    ...(admin ? [{ title: "Change", hideTitle: true, cell: (station: Station) => station.revoked ? null : (
      <div class="row-tools">
        <button type="button" class="button small" onClick={() => setOpen({ what: "rename", station })}>Rename…<span class="hidden"> {station.name}</span></button>
        <button type="button" class="button small" onClick={() => setOpen({ what: "revoke", station })}>Revoke…<span class="hidden"> {station.name}</span></button>
      </div>
    ) }] : []),
  ];
  return (
    <>
      <PageTitle document="Stations">Stations</PageTitle>
      {admin && <EnrolmentCodes client={client} />}
      <PagedList pages={pages} what="stations" empty="No station is enrolled yet.">
        {(stations) => <Card className="flush"><DataTable label="Stations" items={stations} rowKey={(station) => station.id} columns={columns} /></Card>}
      </PagedList>
      <ListedDevices client={client} admin={admin} />
      {open?.what === "rename" && <Rename client={client} station={open.station} onClose={close} onDone={pages.reload} />}
      {open?.what === "revoke" && (
        <Confirm title={`Revoke ${open.station.name}?`} action="Revoke the station" onClose={close}
                 onConfirm={async () => {
                   const result = await client.stations.revoke(open.station.id);
                   if (!result.ok) return result.error.message;
                   pages.reload();
                   return undefined;
                 }}>
          <p>The station is cut off at once and refused from now on. What it has not sent yet stays in its spool. This cannot be undone: to use the machine again, enrol it with a new code.</p>
        </Confirm>
      )}
    </>
  );
}

function StationState({ station }: { readonly station: Station }) {
  if (station.revoked) return <Badge tone="bad">Revoked</Badge>;
  return Date.now() - station.last_seen_ms < kSeenNowMs ? <Badge tone="good">In use</Badge> : <Badge tone="neutral">Enrolled</Badge>;
}

function Rename({ client, station, onClose, onDone }: { readonly client: Client; readonly station: Station; readonly onClose: () => void; readonly onDone: () => void }) {
  const [name, setName] = useState(station.name);
  const change = useChange();
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await change.run(() => client.stations.rename(station.id, name.trim(), tagOf(station.revision)));
    if (result?.ok !== true) return;
    onDone();
    onClose();
  };
  return (
    <Dialog title={`Rename ${station.name}`} onClose={onClose}>
      <form class="form" onSubmit={(event) => void submit(event)}>
        <TextField label="Name" value={name} onValue={setName} required maxLength={64} problem={change.error?.field === "name" ? change.error.message : undefined} />
        {change.error !== undefined && change.error.field !== "name" && <ErrorNotice title="Not renamed" message={change.error.message} />}
        <FormButtons action="Rename" disabled={change.busy} onCancel={onClose} />
      </form>
    </Dialog>
  );
}

function EnrolmentCodes({ client }: { readonly client: Client }) {
  const { loaded, reload } = useRequest("codes", (signal) => client.stations.codes(signal));
  const [made, setMade] = useState<MadeEnrolCode>();
  const [ending, setEnding] = useState<EnrolCode>();
  const change = useChange();
  const make = async () => {
    const result = await change.run(() => client.stations.makeCode(kCodeMinutes));
    if (result?.ok !== true) return;
    setMade(result.value);
    reload();
  };
  return (
    <Card title="Enrol a station" aside={<button type="button" class="button primary" disabled={change.busy} onClick={() => void make()}>Make a code</button>}>
      {change.error !== undefined && <ErrorNotice title="No code was made" message={change.error.message} />}
      {loaded.state === "loading" && <Loading what="open codes" />}
      {loaded.state === "failed" && <ErrorNotice title="The open codes could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && (loaded.value.length === 0 ? <Empty>No code is open.</Empty> : (
        <DataTable label="Open codes" items={loaded.value} rowKey={(code) => code.id} dense columns={[
          { title: "Open since", cell: (code) => formatDateTime(code.created_ms) },
          { title: "Good until", cell: (code) => formatDateTime(code.expires_ms) },
          { title: "Withdraw", hideTitle: true, cell: (code) => (
            <div class="row-tools"><button type="button" class="button small" onClick={() => setEnding(code)}>Withdraw…</button></div>) },
        ]} />
      ))}
      {made !== undefined && <NewCode code={made} onClose={() => setMade(undefined)} />}
      {ending !== undefined && (
        <Confirm title="Withdraw this code?" action="Withdraw the code" onClose={() => setEnding(undefined)}
                 onConfirm={async () => {
                   const result = await client.stations.withdrawCode(ending.id);
                   if (!result.ok) return result.error.message;
                   reload();
                   return undefined;
                 }}>
          <p>Nobody can enrol a station with it any more. You can make another at any time.</p>
        </Confirm>
      )}
    </Card>
  );
}

function NewCode({ code, onClose }: { readonly code: MadeEnrolCode; readonly onClose: () => void }) {
  return (
    <Dialog title="Enrol a station" onClose={onClose} wide>
      <ol class="steps">
        <li>At the station, type this command with a name of your choice in place of <code>STATION</code>:<CopyText text={enrolCommand(code)} what="the command" /></li>
        <li>The station appears in the list below as soon as it is enrolled.</li>
      </ol>
      <p>The code alone:</p>
      <CopyText text={code.code} what="the code" />
      <Notice tone="warning" title="Shown only now">
        <p>Good for one station until {formatDateTime(code.expires_ms)}. The part after @ tells the station which server to trust.</p>
      </Notice>
      <div class="button-row end"><button type="button" class="button primary" onClick={onClose}>Close</button></div>
    </Dialog>
  );
}

function enrolCommand({ code, station_port: port }: MadeEnrolCode): string {
  return `enamel-station enrol --server ${window.location.hostname}:${port > 0 ? port : kUsualPort} --code ${code} --name STATION`;
}
