import { useState } from "preact/hooks";
import { wordedTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import { addressOf, type ApiResult } from "../../api/http";
import { placedMessage } from "../../api/placed";
import type { Profile, ProfileDetail } from "../../api/types";
import { useChange } from "../../api/use_change";
import { useRequest } from "../../api/use_request";
import { formatBytes, formatDateTime, formatNumber, unitText } from "../../base/format";
import { say, sayWith } from "../../base/words";
import { Brief, Card, Empty, ErrorNotice, Notice, PageTitle, Waits } from "../../widgets/basics";
import { Button, needed } from "../../widgets/button";
import { FileField } from "../../widgets/form";
import { DataTable } from "../../widgets/table";
import { Trend } from "../../widgets/trend";
import { DrawnReport } from "./drawn_report";
import { type Calibration, calibrationSeries, type CalibrationSeries } from "./calibration_series";
import { CriteriaPanel } from "./criteria_panel";
import { FeelCard } from "./feel_card";
import { numberTitle } from "./profile_text";

export function ProfilePage({
  client,
  name,
  admin,
}: {
  readonly client: Client;
  readonly name: string;
  readonly admin: boolean;
}) {
  const { loaded, reload } = useRequest(name, (signal) => client.get("/profiles/{name}", { name, signal }));
  const title = loaded.state === "ready" ? wordedTitle(loaded.value.title) : say("profile.one");
  return (
    <>
      <nav class="trail" aria-label={say("common.where")}>
        <a href="/profiles">{say("profiles.title")}</a>
      </nav>
      <PageTitle document={title}>{title}</PageTitle>
      <Waits loaded={loaded} reload={reload} what={say("loading.profile")} failed={say("profile.failed")} />
      {loaded.state === "ready" && <LoadedProfile client={client} profile={loaded.value} admin={admin} />}
    </>
  );
}

function LoadedProfile({
  client,
  profile,
  admin,
}: {
  readonly client: Client;
  readonly profile: ProfileDetail;
  readonly admin: boolean;
}) {
  // Id of the report that is drawn; in the address too, so that it can be passed on.
  const [drawn, setDrawn] = useState(() => new URLSearchParams(location.search).get("report") ?? undefined);
  const draw = (id: string | undefined) => {
    history.replaceState(
      history.state,
      "",
      id === undefined ? location.pathname : `${location.pathname}?report=${encodeURIComponent(id)}`,
    );
    setDrawn(id);
  };
  return (
    <>
      <p class="byline">
        {sayWith("profile.byline", { name: <code>{profile.name}</code>, version: String(profile.version) })}
        {admin && (
          <>
            {" · "}
            <a href={`/editor?profile=${profile.name}`}>{say("profile.edit")}</a>
          </>
        )}
      </p>
      <Card title={say("profile.criteria")}>
        <CriteriaPanel criteria={profile.criteria} />
      </Card>
      <FeelCard profile={profile} />
      <Card title={say("profile.numbers")}>
        <Numbers profile={profile} />
      </Card>
      <Calibrations client={client} profile={profile} admin={admin} />
      <div class="columns">
        <Card title={say("version.title")}>
          <Versions client={client} profile={profile} />
        </Card>
        <Card title={say("profile.reports")}>
          <Reports client={client} profile={profile} admin={admin} drawn={drawn} onDraw={draw} />
        </Card>
      </div>
      {drawn !== undefined && <DrawnReport key={drawn} client={client} id={drawn} onClose={() => draw(undefined)} />}
    </>
  );
}

function Numbers({ profile }: { readonly profile: Profile }) {
  return (
    <DataTable
      label={say("profile.numbers_of", { device: wordedTitle(profile.title) })}
      items={profile.numbers}
      dense
      columns={[
        { title: say("profile.number"), cell: (number) => numberTitle(number.name) },
        {
          title: say("profile.value"),
          number: true,
          cell: (number) => <span class="nowrap">{valueText(number)}</span>,
        },
        { title: say("profile.source"), cell: (number) => wordedTitle(number.source) },
      ]}
    />
  );
}

function Versions({ client, profile }: { readonly client: Client; readonly profile: ProfileDetail }) {
  const { loaded, reload } = useRequest(`${profile.name} ${profile.version}`, (signal) =>
    client.all("/profiles/{name}/versions", { name: profile.name, signal }),
  );
  if (loaded.state !== "ready")
    return <Waits loaded={loaded} reload={reload} what={say("loading.versions")} failed={say("version.failed")} />;
  return (
    <DataTable
      label={say("version.title")}
      items={loaded.value}
      dense
      columns={[
        { title: say("version.one"), cell: (version) => version.version },
        { title: say("editor.title_field"), cell: (version) => wordedTitle(version.title) },
        { title: say("profile.saved"), cell: (version) => formatDateTime(version.created_ms) },
      ]}
    />
  );
}

interface ReportsProps {
  readonly client: Client;
  readonly profile: ProfileDetail;
  readonly admin: boolean;
  readonly drawn: string | undefined;
  readonly onDraw: (id: string | undefined) => void;
}

function Reports({ client, profile, admin, drawn, onDraw }: ReportsProps) {
  const { loaded, reload } = useRequest(profile.name, (signal) =>
    client.all("/profiles/{name}/reports", { name: profile.name, signal }),
  );
  return (
    <>
      <Waits loaded={loaded} reload={reload} what={say("loading.reports")} failed={say("profile.reports_failed")} />
      {loaded.state === "ready" &&
        (loaded.value.length === 0 ? (
          <Empty>{say("profile.no_report")}</Empty>
        ) : (
          <DataTable
            label={say("profile.reports")}
            items={loaded.value}
            dense
            columns={[
              {
                title: say("profile.report"),
                cell: (report) => (
                  <a href={addressOf("/profile-reports/{id}", { id: report.id })} download>
                    {formatDateTime(report.created_ms)}
                  </a>
                ),
              },
              { title: say("profile.of_version"), number: true, cell: (report) => report.version },
              { title: say("profile.size"), number: true, cell: (report) => formatBytes(report.bytes) },
              {
                title: say("profile.drawing"),
                hideTitle: true,
                cell: (report) =>
                  report.media_type === "application/json" && (
                    <div class="row-tools">
                      <button
                        type="button"
                        class="button small"
                        aria-pressed={drawn === report.id}
                        onClick={() => onDraw(drawn === report.id ? undefined : report.id)}
                      >
                        <Brief
                          shown={say("profile.draw")}
                          full={say("profile.draw_which", { when: formatDateTime(report.created_ms) })}
                        />
                      </button>
                    </div>
                  ),
              },
            ]}
          />
        ))}
      {admin && (
        <UploadForm
          label={say("profile.attach")}
          accept=".json,.html,application/json,text/html"
          hint={say("profile.attach_hint")}
          send={(text, file) =>
            client.post("/profiles/{name}/reports", {
              name: profile.name,
              body: text,
              type: file.name.endsWith(".html") ? "text/html" : "application/json",
            })
          }
          onDone={reload}
        />
      )}
    </>
  );
}

function Calibrations({
  client,
  profile,
  admin,
}: {
  readonly client: Client;
  readonly profile: ProfileDetail;
  readonly admin: boolean;
}) {
  const { loaded, reload } = useRequest(profile.name, (signal) =>
    client.all("/profiles/{name}/calibrations", { name: profile.name, signal }),
  );
  return (
    <Card title={say("calibration.title")}>
      <Waits loaded={loaded} reload={reload} what={say("loading.calibrations")} failed={say("calibration.failed")} />
      {loaded.state === "ready" &&
        (loaded.value.length === 0 ? (
          <Empty>{say("calibration.none")}</Empty>
        ) : (
          <CalibrationHistory
            calibrations={loaded.value as readonly unknown[] as readonly Calibration[]}
            profile={profile}
          />
        ))}
      {admin && (
        <UploadForm
          label={say("calibration.add")}
          accept=".json,application/json"
          hint={say("calibration.add_hint")}
          send={(text) => client.post("/profiles/{name}/calibrations", { name: profile.name, body: text })}
          onDone={reload}
        />
      )}
    </Card>
  );
}

function CalibrationHistory({
  calibrations,
  profile,
}: {
  readonly calibrations: readonly Calibration[];
  readonly profile: ProfileDetail;
}) {
  const devices = [...new Set(calibrations.map((calibration) => calibration.device))];
  const numbers = new Map(profile.numbers.map((number) => [number.name, number.value]));
  return (
    <>
      {devices.map((device) => {
        const own = calibrations.filter((calibration) => calibration.device === device);
        return (
          <section key={device} aria-label={say("calibration.device", { device })}>
            <h3>{device}</h3>
            <div class="trends">
              {calibrationSeries(own, numbers).map((series) => (
                <CalibrationTrend key={series.title} series={series} />
              ))}
            </div>
          </section>
        );
      })}
      <DataTable
        label={say("calibration.all")}
        items={calibrations}
        dense
        columns={[
          { title: say("calibration.measured"), cell: (item) => formatDateTime(item.measured_ms) },
          { title: say("common.device"), cell: (item) => item.device },
          {
            title: say("common.station"),
            cell: (item) => (item.document.station === "" ? "–" : item.document.station),
          },
          { title: say("calibration.figures"), cell: (item) => figuresText(item, numbers) },
          {
            title: say("calibration.measured_by"),
            cell: (item) => (
              <>
                {item.document.software}
                <span class="sub">{item.document.method}</span>
              </>
            ),
          },
        ]}
      />
    </>
  );
}

function CalibrationTrend({ series }: { readonly series: CalibrationSeries }) {
  const last = series.points.at(-1)?.value ?? Number.NaN;
  const told = { figure: series.title, value: formatNumber(last, 2), unit: series.unit };
  const claim = series.claim === undefined ? undefined : { value: series.claim, title: say("calibration.profile") };
  return (
    <figure class="trend-figure">
      <figcaption>{series.title}</figcaption>
      <Trend
        points={series.points}
        unit={series.unit}
        claim={claim}
        label={
          series.claim === undefined
            ? say("calibration.trend", told)
            : say("calibration.trend_claim", { ...told, claim: formatNumber(series.claim, 2) })
        }
      />
    </figure>
  );
}

function figuresText(calibration: Calibration, numbers: ReadonlyMap<string, number>): string {
  return calibrationSeries([calibration], numbers)
    .map(({ title, unit, points }) => {
      const point = points[0]!;
      const told = { figure: title, value: formatNumber(point.value, 2), unit };
      return point.uncertainty > 0
        ? say("calibration.figure_about", { ...told, uncertainty: formatNumber(point.uncertainty, 2) })
        : say("calibration.figure", told);
    })
    .join("; ");
}

interface UploadProps {
  readonly label: string;
  readonly accept: string;
  readonly hint: string;
  readonly send: (text: string, file: File) => Promise<ApiResult<unknown>>;
  readonly onDone: () => void;
}

function UploadForm({ label, accept, hint, send, onDone }: UploadProps) {
  const [file, setFile] = useState<File>();
  const [added, setAdded] = useState(false);
  const change = useChange();
  const submit = async (event: Event) => {
    event.preventDefault();
    if (file === undefined) return;
    const text = await file.text();
    const result = await change.run(() => send(text, file));
    setAdded(result?.ok === true);
    if (result?.ok === true) onDone();
  };
  return (
    <form class="form narrow" onSubmit={(event) => void submit(event)}>
      <FileField label={label} accept={accept} onFile={setFile} hint={hint} />
      {change.error !== undefined && (
        <ErrorNotice title={say("common.not_added")} message={placedMessage(change.error)} />
      )}
      {added && change.error === undefined && (
        <Notice tone="good">
          <p>{say("profile.added")}</p>
        </Notice>
      )}
      <div>
        <Button kind="" busy={change.busy} blocked={needed({ [label]: file })}>
          {say("common.add")}
        </Button>
      </div>
    </form>
  );
}

function valueText({ value, unit }: Profile["numbers"][number]): string {
  if (unit === "ticks") return say("count.ticks", { count: value });
  if (unit === "driven") return say("profile.driven", { count: value });
  return `${formatNumber(value, 3)} ${unitText(unit)}`;
}
