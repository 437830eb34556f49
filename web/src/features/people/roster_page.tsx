import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { RosterOutcome } from "../../api/types";
import { useChange } from "../../api/use_change";
import { useRequest } from "../../api/use_request";
import { csvText } from "../../base/csv";
import { downloadText } from "../../base/download";
import { formatNumber, plural } from "../../base/format";
import { Badge, Card, ErrorNotice, Notice, PageTitle, type Tone } from "../../widgets/basics";
import { FileField, SelectField } from "../../widgets/form";
import { DataTable } from "../../widgets/table";

const kMaxBytes = 1 << 20;                      // of a request's body
const kShownRows = 500;
const kExample = "login,display_name,role,cohort\r\nstudent.one,Student One,student,Preclinic A\r\n";

interface Chosen {
  readonly name: string;
  readonly text: string;
}

// A roster from the registrar's office: first what would happen, then, on confirmation, the import.
export function RosterPage({ client }: { readonly client: Client }) {
  const [file, setFile] = useState<Chosen>();
  const [problem, setProblem] = useState<string>();
  const [cohort, setCohort] = useState("");
  const [trial, setTrial] = useState<RosterOutcome>();
  const [done, setDone] = useState<RosterOutcome>();
  const change = useChange();
  const cohorts = useRequest("cohorts", (signal) => client.people.allCohorts(signal));
  const names = cohorts.loaded.state === "ready" ? cohorts.loaded.value.map((item) => item.name) : [];

  const check = async (chosen: Chosen | undefined, into: string) => {
    setTrial(undefined);
    if (chosen === undefined) return;
    const result = await change.run(() => client.people.importRoster(chosen.text, true, into));
    if (result?.ok === true) setTrial(result.value);
  };
  const choose = async (chosen: File | undefined) => {
    const tooLarge = chosen !== undefined && chosen.size > kMaxBytes;
    setProblem(tooLarge ? `The file has ${formatNumber(chosen.size, 0)} bytes, at most ${formatNumber(kMaxBytes, 0)} are allowed. Split it.` : undefined);
    const next = chosen === undefined || tooLarge ? undefined : { name: chosen.name, text: await chosen.text() };
    setFile(next);
    await check(next, cohort);
  };
  const carryOut = async () => {
    if (file === undefined) return;
    const result = await change.run(() => client.people.importRoster(file.text, false, cohort));
    if (result?.ok === true) setDone(result.value);
  };

  return (
    <>
      <nav class="trail" aria-label="Where you are"><a href="/people">People</a></nav>
      <PageTitle document="Import a roster">Import a roster</PageTitle>
      {done !== undefined ? <Done report={done} /> : (
        <>
          <Card title="1. The file">
            <p>A CSV file (UTF-8, commas) with the columns <code>login</code>, <code>display_name</code>, <code>role</code> and <code>cohort</code>, in any order, named in the first row.
              Who is there already keeps role and password; nobody is removed; importing the same file twice changes nothing. Somebody in several cohorts has a row for each.</p>
            <div class="form-grid">
              <FileField label="Roster (CSV)" accept=".csv,text/csv" onFile={(chosen) => void choose(chosen)} problem={problem} />
              <SelectField label="Cohort for rows without one" value={cohort}
                           onValue={(name) => { setCohort(name); void check(file, name); }}
                           options={[{ value: "", title: "None" }, ...names.map((name) => ({ value: name, title: name }))]} />
            </div>
            <p><button type="button" class="button quiet" onClick={() => downloadText("roster_example.csv", "text/csv", kExample)}>Download an example</button></p>
          </Card>
          {change.error !== undefined && <ErrorNotice title="The roster was not read" message={change.error.message} />}
          {trial !== undefined && <Trial report={trial} busy={change.busy} onImport={() => void carryOut()} />}
        </>
      )}
    </>
  );
}

function Trial({ report, busy, onImport }: { readonly report: RosterOutcome; readonly busy: boolean; readonly onImport: () => void }) {
  const { problems } = report;
  if (problems.length > 0) {
    return (
      <Card title="2. What stands against it">
        <Notice tone="bad" title={`${plural(report.problem_count, "problem")}: nothing was imported`}>
          <p>Correct the file and choose it again. Rows are counted as a spreadsheet counts them: the header is row 1.</p>
        </Notice>
        <DataTable label="Problems in the roster" items={problems} dense columns={[
          { title: "Row", number: true, cell: (item) => item.row },
          { title: "Column", cell: (item) => item.column === "" ? "–" : <code>{item.column}</code> },
          { title: "Found", cell: (item) => item.found },
          { title: "Expected", cell: (item) => item.expected },
        ]} />
      </Card>
    );
  }
  const nothing = report.created === 0 && report.updated === 0;
  return (
    <Card title="2. What would happen">
      <Notice tone={nothing ? "neutral" : "good"} title={countText(report)}>
        {report.new_cohorts.length > 0 && <p>New cohorts: {report.new_cohorts.join(", ")}.</p>}
        {report.ignored_columns.length > 0 && <p>Columns that are not used: {report.ignored_columns.join(", ")}.</p>}
      </Notice>
      <Rows report={report} />
      <div class="button-row">
        <button type="button" class="button primary" disabled={busy || nothing} onClick={onImport}>
          {nothing ? "Nothing to import" : busy ? "Importing…" : `Import ${plural(report.created + report.updated, "person", "people")}`}
        </button>
      </div>
    </Card>
  );
}

const kTones: Readonly<Record<string, Tone>> = { create: "good", update: "warning", unchanged: "neutral" };
const kTitles: Readonly<Record<string, string>> = { create: "New", update: "Changed", unchanged: "As it is" };

function Rows({ report }: { readonly report: RosterOutcome }) {
  const shown = report.people.slice(0, kShownRows);
  return (
    <>
      <DataTable label="Rows of the roster" items={shown} dense columns={[
        { title: "Row", number: true, cell: (item) => item.row },
        { title: "Login", cell: (item) => <code>{item.login}</code> },
        { title: "What happens", cell: (item) => <Badge tone={kTones[item.change] ?? "neutral"}>{kTitles[item.change] ?? item.change}</Badge> },
        { title: "In detail", cell: (item) => detailText(item) },
      ]} />
      {report.people.length > shown.length && <p class="hint">The first {formatNumber(shown.length, 0)} of {plural(report.people.length, "row")} are shown.</p>}
    </>
  );
}

function detailText({ renames, joins, note }: RosterOutcome["people"][number]): string {
  return [renames ? "gets another name" : "", joins ? "joins the cohort" : "", note].filter((part) => part !== "").join("; ") || "–";
}

function Done({ report }: { readonly report: RosterOutcome }) {
  const { passwords } = report;
  const save = () => downloadText("passwords.csv", "text/csv", csvText(["login", "display_name", "cohort", "password"],
    passwords.map((row) => [row.login, row.display_name, row.cohort, row.password])));
  return (
    <Card title="Imported">
      <Notice tone="good" title={countText(report)} />
      {passwords.length > 0 && (
        <>
          <Notice tone="warning" title="Passwords are shown only now">
            <p>Save them, hand out each one, then delete the file. Each is good for signing in once, within days (7 where nothing else is set), and a new one is chosen then.</p>
            <button type="button" class="button" onClick={save}>Save {plural(passwords.length, "password")} as CSV</button>
          </Notice>
          <DataTable label="New passwords" items={passwords} dense columns={[
            { title: "Name", cell: (row) => row.display_name }, { title: "Login", cell: (row) => <code>{row.login}</code> },
            { title: "Password", cell: (row) => <code>{row.password}</code> },
          ]} />
        </>
      )}
      <p><a href="/people">Go to people</a></p>
    </Card>
  );
}

function countText({ created, updated, unchanged }: RosterOutcome): string {
  return `${formatNumber(created, 0)} new, ${formatNumber(updated, 0)} changed, ${formatNumber(unchanged, 0)} as they are`;
}
