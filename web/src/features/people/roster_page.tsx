import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { RosterOutcome } from "../../api/types";
import { useChange } from "../../api/use_change";
import { useRequest } from "../../api/use_request";
import { csvText } from "../../base/csv";
import { downloadFile } from "../../base/download";
import { formatNumber } from "../../base/format";
import { say, sayWith } from "../../base/words";
import { Badge, Card, ErrorNotice, Notice, PageTitle, type Tone } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { FileField, SelectField } from "../../widgets/form";
import { DataTable } from "../../widgets/table";
import { PrintSlips } from "./password_slips";

const kMaxBytes = 1 << 20; // of a request's body
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
    setProblem(
      tooLarge
        ? say("roster.too_large", { found: formatNumber(chosen.size, 0), most: formatNumber(kMaxBytes, 0) })
        : undefined,
    );
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
      <nav class="trail" aria-label={say("common.where")}>
        <a href="/people">{say("nav.people")}</a>
      </nav>
      <PageTitle document={say("roster.title")}>{say("roster.title")}</PageTitle>
      {done !== undefined ? (
        <Done report={done} />
      ) : (
        <>
          <Card title={say("roster.file")}>
            <p>
              {sayWith("roster.format", {
                login: <code>"login"</code>,
                display_name: <code>"display_name"</code>,
                role: <code>"role"</code>,
                cohort: <code>"cohort"</code>,
              })}
            </p>
            <div class="form-grid">
              <FileField
                label={say("roster.csv")}
                accept=".csv,text/csv"
                onFile={(chosen) => void choose(chosen)}
                problem={problem}
              />
              <SelectField
                label={say("roster.cohort")}
                value={cohort}
                onValue={(name) => {
                  setCohort(name);
                  void check(file, name);
                }}
                options={[
                  { value: "", title: say("common.none") },
                  ...names.map((name) => ({ value: name, title: name })),
                ]}
              />
            </div>
            <p>
              <button
                type="button"
                class="button quiet"
                onClick={() => downloadFile("roster_example.csv", "text/csv", kExample)}
              >
                {say("roster.example")}
              </button>
            </p>
          </Card>
          {change.error !== undefined && <ErrorNotice title={say("roster.not_read")} message={change.error.message} />}
          {trial !== undefined && <Trial report={trial} busy={change.busy} onImport={() => void carryOut()} />}
        </>
      )}
    </>
  );
}

function Trial({
  report,
  busy,
  onImport,
}: {
  readonly report: RosterOutcome;
  readonly busy: boolean;
  readonly onImport: () => void;
}) {
  const { problems } = report;
  if (problems.length > 0) {
    return (
      <Card title={say("roster.against")}>
        <Notice tone="bad" title={say("roster.problems", { count: report.problem_count })}>
          <p>{say("roster.correct")}</p>
        </Notice>
        <DataTable
          label={say("roster.problems_table")}
          items={problems}
          dense
          columns={[
            { title: say("roster.row"), number: true, cell: (item) => item.row },
            { title: say("roster.column"), cell: (item) => (item.column === "" ? "–" : <code>{item.column}</code>) },
            { title: say("roster.found"), cell: (item) => item.found },
            { title: say("roster.expected"), cell: (item) => item.expected },
          ]}
        />
      </Card>
    );
  }
  const nothing = report.created === 0 && report.updated === 0;
  return (
    <Card title={say("roster.would")}>
      <Notice tone={nothing ? "neutral" : "good"} title={countText(report)}>
        {report.new_cohorts.length > 0 && <p>{say("roster.new_cohorts", { names: report.new_cohorts.join(", ") })}</p>}
        {report.ignored_columns.length > 0 && (
          <p>{say("roster.ignored", { names: report.ignored_columns.join(", ") })}</p>
        )}
      </Notice>
      <Rows report={report} />
      <div class="button-row">
        <Button busy={busy} blocked={nothing ? say("roster.nothing") : undefined} onClick={onImport}>
          {busy ? say("roster.importing") : say("roster.import", { count: report.created + report.updated })}
        </Button>
      </div>
    </Card>
  );
}

const kTones: Readonly<Record<string, Tone>> = { create: "good", update: "warning", unchanged: "neutral" };
const kTitles: Readonly<Record<string, string>> = {
  get create() {
    return say("roster.create");
  },
  get update() {
    return say("roster.update");
  },
  get unchanged() {
    return say("roster.unchanged");
  },
};

function Rows({ report }: { readonly report: RosterOutcome }) {
  const shown = report.people.slice(0, kShownRows);
  return (
    <>
      <DataTable
        label={say("roster.rows")}
        items={shown}
        dense
        columns={[
          { title: say("roster.row"), number: true, cell: (item) => item.row },
          { title: say("account.login"), cell: (item) => <code>{item.login}</code> },
          {
            title: say("roster.happens"),
            cell: (item) => (
              <Badge tone={kTones[item.change] ?? "neutral"}>{kTitles[item.change] ?? item.change}</Badge>
            ),
          },
          { title: say("roster.detail"), cell: (item) => detailText(item) },
        ]}
      />
      {report.people.length > shown.length && (
        <p class="hint">{say("roster.first_rows", { shown: shown.length, count: report.people.length })}</p>
      )}
    </>
  );
}

function detailText({ renames, joins, note }: RosterOutcome["people"][number]): string {
  return (
    [renames ? say("roster.renames") : "", joins ? say("roster.joins") : "", note]
      .filter((part) => part !== "")
      .join("; ") || "–"
  );
}

function Done({ report }: { readonly report: RosterOutcome }) {
  const { passwords } = report;
  const save = () =>
    downloadFile(
      "passwords.csv",
      "text/csv",
      csvText(
        ["login", "display_name", "cohort", "password"],
        passwords.map((row) => [row.login, row.display_name, row.cohort, row.password]),
      ),
    );
  return (
    <Card title={say("roster.imported")}>
      <Notice tone="good" title={countText(report)} />
      {passwords.length > 0 && (
        <>
          <Notice tone="warning" title={say("roster.passwords_now")}>
            <p>{say("roster.passwords_text")}</p>
            <button type="button" class="button" onClick={save}>
              {say("roster.save_passwords", { count: passwords.length })}
            </button>{" "}
            <PrintSlips slips={passwords} />
          </Notice>
          <DataTable
            label={say("roster.new_passwords")}
            items={passwords}
            dense
            columns={[
              { title: say("account.name"), cell: (row) => row.display_name },
              { title: say("account.login"), cell: (row) => <code>{row.login}</code> },
              { title: say("account.password"), cell: (row) => <code>{row.password}</code> },
            ]}
          />
        </>
      )}
      <p>
        <a href="/people">{say("roster.go_people")}</a>
      </p>
    </Card>
  );
}

function countText({ created, updated, unchanged }: RosterOutcome): string {
  return say("roster.count", { created, updated, unchanged });
}
