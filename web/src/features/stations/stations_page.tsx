import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { failed, seen } from "../../api/http";
import type { EnrolCode, MadeEnrolCode, Station } from "../../api/types";
import { useChange } from "../../api/use_change";
import { usePages } from "../../api/use_pages";
import { useRequest } from "../../api/use_request";
import { formatDateTime } from "../../base/format";
import { relativeTime } from "../../base/local_time";
import { say, sayWith } from "../../base/words";
import { Badge, Brief, Card, Empty, ErrorNotice, Notice, PageTitle, Waits } from "../../widgets/basics";
import { Confirm, Dialog, FormButtons } from "../../widgets/dialog";
import { CopyText } from "../../widgets/copy";
import { TextField } from "../../widgets/form";
import { PagedList } from "../../widgets/pages";
import { type Column, DataTable } from "../../widgets/table";
import { ListedDevices } from "./listed_devices";

const kPageSize = 100;
const kCodeMinutes = 60;
const kUsualPort = 8443; // of the station link, for a server that does not tell its own
const kSeenNowMs = 2 * 60_000;

// The workstations; an admin enrols, renames and revokes them.
export function StationsPage({ client, admin }: { readonly client: Client; readonly admin: boolean }) {
  const pages = usePages("stations", (cursor, signal) =>
    client.page("/stations", { cursor, limit: kPageSize, signal }),
  );
  const [open, setOpen] = useState<{ readonly what: "rename" | "revoke"; readonly station: Station }>();
  const close = () => setOpen(undefined);
  const columns: readonly Column<Station>[] = [
    { title: say("common.station"), cell: (station) => station.name },
    { title: say("common.state"), cell: (station) => <StationState station={station} /> },
    {
      title: say("stations.seen"),
      cell: (station) =>
        station.last_seen_ms === 0 ? (
          say("common.never")
        ) : (
          <span title={formatDateTime(station.last_seen_ms)}>{relativeTime(station.last_seen_ms, Date.now())}</span>
        ),
    },
    {
      title: say("stations.software"),
      cell: (station) =>
        station.software === ""
          ? "–"
          : say("stations.core", { software: station.software, core: String(station.core_version) }),
    },
    { title: say("stations.enrolled_at"), cell: (station) => formatDateTime(station.enrolled_ms) },
    ...(admin
      ? [
          {
            title: say("common.change"),
            hideTitle: true,
            cell: (station: Station) =>
              station.revoked ? null : (
                <div class="row-tools">
                  <button type="button" class="button small" onClick={() => setOpen({ what: "rename", station })}>
                    <Brief
                      shown={say("stations.rename_ask")}
                      full={say("stations.rename_which", { name: station.name })}
                    />
                  </button>
                  <button type="button" class="button small" onClick={() => setOpen({ what: "revoke", station })}>
                    <Brief
                      shown={say("stations.revoke_ask")}
                      full={say("stations.revoke_which", { name: station.name })}
                    />
                  </button>
                </div>
              ),
          },
        ]
      : []),
  ];
  return (
    <>
      <PageTitle document={say("nav.stations")}>{say("nav.stations")}</PageTitle>
      {admin && <EnrolmentCodes client={client} />}
      <PagedList pages={pages} list="stations" empty={say("stations.none")}>
        {(stations) => (
          <Card className="flush">
            <DataTable
              label={say("nav.stations")}
              items={stations}
              rowKey={(station) => station.id}
              columns={columns}
            />
          </Card>
        )}
      </PagedList>
      <ListedDevices client={client} admin={admin} />
      {open?.what === "rename" && (
        <Rename client={client} station={open.station} onClose={close} onDone={pages.reload} />
      )}
      {open?.what === "revoke" && (
        <Confirm
          title={say("stations.revoke_title", { name: open.station.name })}
          action={say("stations.revoke")}
          onClose={close}
          onConfirm={() => failed(client.post("/stations/{id}/revoke", { id: open.station.id }), pages.reload)}
        >
          <p>{say("stations.revoke_text")}</p>
        </Confirm>
      )}
    </>
  );
}

function StationState({ station }: { readonly station: Station }) {
  if (station.revoked) return <Badge tone="bad">{say("stations.revoked")}</Badge>;
  return Date.now() - station.last_seen_ms < kSeenNowMs ? (
    <Badge tone="good">{say("cohorts.in_use")}</Badge>
  ) : (
    <Badge tone="neutral">{say("stations.enrolled")}</Badge>
  );
}

function Rename({
  client,
  station,
  onClose,
  onDone,
}: {
  readonly client: Client;
  readonly station: Station;
  readonly onClose: () => void;
  readonly onDone: () => void;
}) {
  const [name, setName] = useState(station.name);
  const change = useChange();
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await change.run(() =>
      client.patch("/stations/{id}", { ...seen(station), body: { name: name.trim() } }),
    );
    if (result?.ok !== true) return;
    onDone();
    onClose();
  };
  return (
    <Dialog title={say("stations.rename_title", { name: station.name })} onClose={onClose}>
      <form class="form" onSubmit={(event) => void submit(event)}>
        <TextField
          label={say("account.name")}
          value={name}
          onValue={setName}
          required
          maxLength={64}
          problem={change.error?.field === "name" ? change.error.message : undefined}
        />
        {change.error !== undefined && change.error.field !== "name" && (
          <ErrorNotice title={say("stations.not_renamed")} message={change.error.message} />
        )}
        <FormButtons action={say("stations.rename")} busy={change.busy} onCancel={onClose} />
      </form>
    </Dialog>
  );
}

function EnrolmentCodes({ client }: { readonly client: Client }) {
  const { loaded, reload } = useRequest("codes", (signal) => client.all("/enrolment-codes", { signal }));
  const [made, setMade] = useState<MadeEnrolCode>();
  const [ending, setEnding] = useState<EnrolCode>();
  const change = useChange();
  const make = async () => {
    const result = await change.run(() => client.post("/enrolment-codes", { body: { minutes: kCodeMinutes } }));
    if (result?.ok !== true) return;
    setMade(result.value);
    reload();
  };
  return (
    <Card
      title={say("stations.enrol")}
      aside={
        <button type="button" class="button primary" disabled={change.busy} onClick={() => void make()}>
          {say("stations.make_code")}
        </button>
      }
    >
      {change.error !== undefined && (
        <ErrorNotice title={say("stations.no_code_made")} message={change.error.message} />
      )}
      <Waits loaded={loaded} reload={reload} what={say("loading.codes")} failed={say("stations.codes_failed")} />
      {loaded.state === "ready" &&
        (loaded.value.length === 0 ? (
          <Empty>{say("stations.no_code")}</Empty>
        ) : (
          <DataTable
            label={say("stations.codes")}
            items={loaded.value}
            rowKey={(code) => code.id}
            dense
            columns={[
              { title: say("stations.open_since"), cell: (code) => formatDateTime(code.created_ms) },
              { title: say("stations.good_until"), cell: (code) => formatDateTime(code.expires_ms) },
              {
                title: say("stations.withdraw_column"),
                hideTitle: true,
                cell: (code) => (
                  <div class="row-tools">
                    <button type="button" class="button small" onClick={() => setEnding(code)}>
                      {say("stations.withdraw_ask")}
                    </button>
                  </div>
                ),
              },
            ]}
          />
        ))}
      {made !== undefined && <NewCode code={made} onClose={() => setMade(undefined)} />}
      {ending !== undefined && (
        <Confirm
          title={say("stations.withdraw_title")}
          action={say("stations.withdraw")}
          onClose={() => setEnding(undefined)}
          onConfirm={() => failed(client.delete("/enrolment-codes/{id}", { id: ending.id }), reload)}
        >
          <p>{say("stations.withdraw_text")}</p>
        </Confirm>
      )}
    </Card>
  );
}

function NewCode({ code, onClose }: { readonly code: MadeEnrolCode; readonly onClose: () => void }) {
  return (
    <Dialog title={say("stations.enrol")} onClose={onClose} wide>
      <ol class="steps">
        <li>
          <p>{sayWith("stations.type_command", { place: <code>STATION</code> })}</p>
          <CopyText text={enrolCommand(code)} what={say("copy.command")} />
        </li>
        <li>{say("stations.appears")}</li>
      </ol>
      <p>{say("stations.code_alone")}</p>
      <CopyText text={code.code} what={say("copy.code")} />
      <Notice tone="warning" title={say("common.shown_now")}>
        <p>{say("stations.code_good", { until: formatDateTime(code.expires_ms) })}</p>
      </Notice>
      <div class="button-row end">
        <button type="button" class="button primary" onClick={onClose}>
          {say("common.close")}
        </button>
      </div>
    </Dialog>
  );
}

function enrolCommand({ code, station_port: port }: MadeEnrolCode): string {
  return `enamel-station enrol --server ${window.location.hostname}:${port > 0 ? port : kUsualPort} --code ${code} --name STATION`;
}
