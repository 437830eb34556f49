import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { RosterOutcome } from "../../api/types";
import { useChange } from "../../api/use_change";
import { useRequest } from "../../api/use_request";
import { csvText } from "../../base/csv";
import { downloadFile } from "../../base/download";
import { formatNumber } from "../../base/format";
import { say, sayWith } from "../../base/words";
import { Badge, Card, ErrorNotice, Notice, PageTitle } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { CheckField, FileField, SelectField } from "../../widgets/form";
import { DataTable } from "../../widgets/table";
import { PrintSlips } from "./password_slips";
import {
  asksAboutOthers,
  detailText,
  importRoster,
  leftOutText,
  type Others,
  readings,
  type RosterImport,
} from "./roster";

const kMaxBytes = 1 << 20; // of a request's body
const kShownRows = 500;
const kExample = "login,display_name,role,cohort\r\nstudent.one,Student One,student,Preclinic A\r\n";

const kAsFound: RosterImport = { cohort: "", reading: undefined, ignoreUnknown: false, move: false };

// A roster from the registrar's office: first what would happen, then, on confirmation, the import.
export function RosterPage({ client }: { readonly client: Client }) {
  const [file, setFile] = useState<ArrayBuffer>();
  const [problem, setProblem] = useState<string>();
  const [how, setHow] = useState(kAsFound);
  const [others, setOthers] = useState<Others>("");
  const [trial, setTrial] = useState<RosterOutcome>();
  const [done, setDone] = useState<RosterOutcome>();
  const change = useChange();
  const cohorts = useRequest("cohorts", (signal) => client.all("/cohorts", { signal }));
  const names = cohorts.loaded.state === "ready" ? cohorts.loaded.value.map((item) => item.name) : [];

  // The last trial stays until the next is there: the focus is in one of its fields.
  const check = async (bytes: ArrayBuffer | undefined, next: RosterImport) => {
    setHow(next);
    if (bytes === undefined) return setTrial(undefined);
    const result = await change.run(() => importRoster(client, bytes, next, true));
    setTrial(result?.ok === true ? result.value : undefined);
  };
  const choose = async (chosen: File | undefined) => {
    const tooLarge = chosen !== undefined && chosen.size > kMaxBytes;
    setProblem(
      tooLarge
        ? say("roster.too_large", { found: formatNumber(chosen.size, 0), most: formatNumber(kMaxBytes, 0) })
        : undefined,
    );
    const bytes = chosen === undefined || tooLarge ? undefined : await chosen.arrayBuffer();
    setFile(bytes);
    setTrial(undefined);
    setOthers("");
    await check(bytes, { ...how, reading: undefined });
  };
  const carryOut = async () => {
    if (file === undefined) return;
    const move = others === "leave";
    const result = await change.run(() => importRoster(client, file, { ...how, move }, false));
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
                accept=".csv,.txt,text/csv,text/plain"
                onFile={(chosen) => void choose(chosen)}
                problem={problem}
              />
              <SelectField
                label={say("roster.cohort")}
                value={how.cohort}
                onValue={(cohort) => void check(file, { ...how, cohort })}
                options={[
                  { value: "", title: say("common.none") },
                  ...names.map((name) => ({ value: name, title: name })),
                ]}
              />
            </div>
            <CheckField
              label={say("roster.ignore_unknown")}
              value={how.ignoreUnknown}
              onValue={(ignoreUnknown) => void check(file, { ...how, ignoreUnknown })}
            />
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
          {trial !== undefined && (
            <Trial
              report={trial}
              busy={change.busy}
              others={others}
              onOthers={setOthers}
              onReading={(reading) => void check(file, { ...how, reading })}
              onImport={() => void carryOut()}
            />
          )}
        </>
      )}
    </>
  );
}

interface TrialProps {
  readonly report: RosterOutcome;
  readonly busy: boolean;
  readonly others: Others;
  readonly onOthers: (others: Others) => void;
  readonly onReading: (reading: RosterOutcome["reading"]) => void;
  readonly onImport: () => void;
}

function Trial({ report, busy, others, onOthers, onReading, onImport }: TrialProps) {
  const reading = (
    <SelectField
      label={say("roster.reading")}
      hint={say("roster.reading_hint")}
      value={report.reading}
      onValue={onReading}
      options={readings()}
    />
  );
  const { problems } = report;
  if (problems.length > 0) {
    return (
      <Card title={say("roster.against")}>
        <Notice tone="bad" title={say("roster.problems", { count: report.problem_count })}>
          <p>{say("roster.correct")}</p>
        </Notice>
        {reading}
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
  const asks = asksAboutOthers(report);
  const blocked = nothing ? say("roster.nothing") : asks && others === "" ? say("roster.others_first") : undefined;
  return (
    <Card title={say("roster.would")}>
      <Notice tone={nothing ? "neutral" : "good"} title={countText(report)}>
        {report.new_cohorts.length > 0 && <p>{say("roster.new_cohorts", { names: report.new_cohorts.join(", ") })}</p>}
        {report.ignored_columns.length > 0 && (
          <p>{say("roster.ignored", { names: report.ignored_columns.join(", ") })}</p>
        )}
        {report.left_out.length > 0 && <p>{leftOutText(report)}</p>}
      </Notice>
      <div class="form-grid">
        {reading}
        {asks && (
          <SelectField
            label={say("roster.others")}
            value={others}
            onValue={onOthers}
            options={[
              { value: "", title: say("roster.others_choose") },
              { value: "keep", title: say("roster.others_keep") },
              { value: "leave", title: say("roster.others_leave") },
            ]}
          />
        )}
      </div>
      <Rows report={report} others={others} />
      <div class="button-row">
        <Button busy={busy} blocked={blocked} onClick={onImport}>
          {busy ? say("roster.importing") : say("roster.import", { count: report.created + report.updated })}
        </Button>
      </div>
    </Card>
  );
}

const kTones = { create: "good", update: "warning", unchanged: "neutral" } as const;

function Rows({ report, others }: { readonly report: RosterOutcome; readonly others: Others }) {
  const shown = report.people.slice(0, kShownRows);
  return (
    <>
      <DataTable
        label={say("roster.rows")}
        items={shown}
        dense
        columns={[
          { title: say("roster.row"), number: true, cell: (item) => item.row },
          { title: say("account.name"), cell: (item) => item.display_name },
          { title: say("account.login"), cell: (item) => <code>{item.login}</code> },
          { title: say("account.role"), cell: (item) => say(`role.${item.role}`) },
          { title: say("common.cohort"), cell: (item) => item.cohort || "–" },
          {
            title: say("roster.happens"),
            cell: (item) => <Badge tone={kTones[item.change]}>{say(`roster.${item.change}`)}</Badge>,
          },
          { title: say("roster.detail"), cell: (item) => detailText(item, others) },
        ]}
      />
      {report.people.length > shown.length && (
        <p class="hint">{say("roster.first_rows", { shown: shown.length, count: report.people.length })}</p>
      )}
    </>
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
