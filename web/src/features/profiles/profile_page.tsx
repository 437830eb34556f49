import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { type ApiResult, placedMessage } from "../../api/http";
import type { Calibration, Profile, ProfileDetail } from "../../api/types";
import { useChange } from "../../api/use_change";
import { useRequest } from "../../api/use_request";
import { formatBytes, formatDateTime, formatNumber, unitText } from "../../base/format";
import { Card, Empty, ErrorNotice, Loading, Notice, PageTitle } from "../../widgets/basics";
import { FileField } from "../../widgets/form";
import { DataTable } from "../../widgets/table";
import { Trend } from "../../widgets/trend";
import { DrawnReport } from "./drawn_report";
import { calibrationSeries, type CalibrationSeries } from "./calibration_series";
import { CriteriaPanel } from "./criteria_panel";
import { FeelCard } from "./feel_card";

export function ProfilePage({ client, name, admin }: { readonly client: Client; readonly name: string; readonly admin: boolean }) {
  const { loaded, reload } = useRequest(name, (signal) => client.profiles.get(name, signal));
  return (
    <>
      <nav class="trail" aria-label="Where you are"><a href="/profiles">Device profiles</a></nav>
      <PageTitle document={loaded.state === "ready" ? loaded.value.title : "Device profile"}>{loaded.state === "ready" ? loaded.value.title : "Device profile"}</PageTitle>
      {loaded.state === "loading" && <Loading what="the profile" />}
      {loaded.state === "failed" && <ErrorNotice title="The profile could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && <LoadedProfile client={client} profile={loaded.value} admin={admin} />}
    </>
  );
}

function LoadedProfile({ client, profile, admin }: { readonly client: Client; readonly profile: ProfileDetail; readonly admin: boolean }) {
  // Id of the report that is drawn; in the address too, so that it can be passed on.
  const [drawn, setDrawn] = useState(() => new URLSearchParams(location.search).get("report") ?? undefined);
  const draw = (id: string | undefined) => {
    history.replaceState(history.state, "", id === undefined ? location.pathname : `${location.pathname}?report=${encodeURIComponent(id)}`);
    setDrawn(id);
  };
  return (
    <>
      <p class="byline"><code>{profile.name}</code>, version {profile.version}{admin && <>{" · "}<a href={`/editor?profile=${profile.name}`}>Edit its numbers</a></>}</p>
      <Card title="Stability criteria"><CriteriaPanel criteria={profile.criteria} /></Card>
      <FeelCard client={client} profile={profile} />
      <Card title="Numbers"><Numbers profile={profile} /></Card>
      <Calibrations client={client} profile={profile} admin={admin} />
      <div class="columns">
        <Card title="Versions">
          <Versions client={client} profile={profile} />
        </Card>
        <Card title="Qualification reports"><Reports client={client} profile={profile} admin={admin} drawn={drawn} onDraw={draw} /></Card>
      </div>
      {drawn !== undefined && <DrawnReport key={drawn} client={client} id={drawn} onClose={() => draw(undefined)} />}
    </>
  );
}

function Numbers({ profile }: { readonly profile: Profile }) {
  return (
    <DataTable label={`Numbers of ${profile.title}`} items={profile.numbers} dense columns={[
      { title: "Number", cell: (number) => capital(number.name.replaceAll("_", " ")) },
      { title: "Value", number: true, cell: (number) => <span class="nowrap">{formatNumber(number.value, 3)} {unitText(number.unit)}</span> },
      { title: "Source", cell: (number) => number.source },
    ]} />
  );
}

function Versions({ client, profile }: { readonly client: Client; readonly profile: ProfileDetail }) {
  const { loaded, reload } = useRequest(`${profile.name} ${profile.version}`, (signal) => client.profiles.versions(profile.name, signal));
  if (loaded.state === "loading") return <Loading what="versions" />;
  if (loaded.state === "failed") return <ErrorNotice title="The versions could not be loaded" message={loaded.error.message} onRetry={reload} />;
  return (
    <DataTable label="Versions" items={loaded.value} dense columns={[
      { title: "Version", cell: (version) => version.version },
      { title: "Title", cell: (version) => version.title },
      { title: "Saved", cell: (version) => formatDateTime(version.created_ms) },
    ]} />
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
  const { loaded, reload } = useRequest(profile.name, (signal) => client.profiles.reports(profile.name, signal));
  return (
    <>
      {loaded.state === "loading" && <Loading what="reports" />}
      {loaded.state === "failed" && <ErrorNotice title="The reports could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && (loaded.value.length === 0 ? <Empty>No report of enamel-lab qualify is attached.</Empty> : (
        <DataTable label="Qualification reports" items={loaded.value} dense columns={[
          { title: "Report", cell: (report) => <a href={client.profiles.reportAddress(report.id)} download>{formatDateTime(report.created_ms)}</a> },
          { title: "Of version", number: true, cell: (report) => report.version },
          { title: "Size", number: true, cell: (report) => formatBytes(report.bytes) },
          { title: "Drawing", hideTitle: true, cell: (report) => report.media_type === "application/json" && (
            <div class="row-tools">
              <button type="button" class="button small" aria-pressed={drawn === report.id} onClick={() => onDraw(drawn === report.id ? undefined : report.id)}>
                Draw<span class="hidden"> the report of {formatDateTime(report.created_ms)}</span>
              </button>
            </div>) },
        ]} />
      ))}
      {admin && (
        <UploadForm label="Attach a report (JSON or HTML)" accept=".json,.html,application/json,text/html" hint="As enamel-lab qualify --report writes it. It belongs to the newest version."
                    send={(text, file) => client.profiles.addReport(profile.name, text, file.name.endsWith(".html") ? "text/html" : "application/json")} onDone={reload} />
      )}
    </>
  );
}

function Calibrations({ client, profile, admin }: { readonly client: Client; readonly profile: ProfileDetail; readonly admin: boolean }) {
  const { loaded, reload } = useRequest(profile.name, (signal) => client.profiles.calibrations(profile.name, signal));
  return (
    <Card title="Calibrations">
      {loaded.state === "loading" && <Loading what="calibrations" />}
      {loaded.state === "failed" && <ErrorNotice title="The calibrations could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && (loaded.value.length === 0 ? <Empty>No device of this kind was measured yet.</Empty>
        : <CalibrationHistory calibrations={loaded.value} profile={profile} />)}
      {admin && (
        <UploadForm label="Add a calibration (JSON)" accept=".json,application/json" hint="As enamel-station calibrate --out writes it."
                    send={(text) => client.profiles.addCalibration(profile.name, text)} onDone={reload} />
      )}
    </Card>
  );
}

function CalibrationHistory({ calibrations, profile }: { readonly calibrations: readonly Calibration[]; readonly profile: ProfileDetail }) {
  const devices = [...new Set(calibrations.map((calibration) => calibration.device))];
  const numbers = new Map(profile.numbers.map((number) => [number.name, number.value]));
  return (
    <>
      {devices.map((device) => {
        const own = calibrations.filter((calibration) => calibration.device === device);
        return (
          <section key={device} aria-label={`Device ${device}`}>
            <h3>{device}</h3>
            <div class="trends">{calibrationSeries(own, numbers).map((series) => <CalibrationTrend key={series.title} series={series} />)}</div>
          </section>
        );
      })}
      <DataTable label="All calibrations" items={calibrations} dense columns={[
        { title: "Measured", cell: (item) => formatDateTime(item.measured_ms) },
        { title: "Device", cell: (item) => item.device },
        { title: "Station", cell: (item) => item.document.station === "" ? "–" : item.document.station },
        { title: "Figures", cell: (item) => figuresText(item, numbers) },
        { title: "Measured by", cell: (item) => <>{item.document.software}<span class="sub">{item.document.method}</span></> },
      ]} />
    </>
  );
}

function CalibrationTrend({ series }: { readonly series: CalibrationSeries }) {
  const last = series.points.at(-1)?.value ?? Number.NaN;
  const claim = series.claim === undefined ? undefined : { value: series.claim, title: "profile" };
  return (
    <figure class="trend-figure">
      <figcaption>{series.title}</figcaption>
      <Trend points={series.points} unit={series.unit} claim={claim}
             label={`${series.title} over time: ${formatNumber(last, 2)} ${series.unit} at last${series.claim === undefined ? "" : `, the profile says ${formatNumber(series.claim, 2)}`}`} />
    </figure>
  );
}

function figuresText(calibration: Calibration, numbers: ReadonlyMap<string, number>): string {
  return calibrationSeries([calibration], numbers).map(({ title, unit, points }) => {
    const point = points[0]!;
    const uncertainty = point.uncertainty > 0 ? ` ± ${formatNumber(point.uncertainty, 2)}` : "";
    return `${title} ${formatNumber(point.value, 2)}${uncertainty} ${unit}`;
  }).join("; ");
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
      {change.error !== undefined && <ErrorNotice title="Not added" message={placedMessage(change.error)} />}
      {added && change.error === undefined && <Notice tone="good"><p>Added.</p></Notice>}
      <div><button type="submit" class="button" disabled={change.busy || file === undefined}>Add</button></div>
    </form>
  );
}

function capital(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
