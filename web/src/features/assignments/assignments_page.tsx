import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Assignment } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { Badge, Card, Empty, ErrorNotice, Loading, PageTitle } from "../../widgets/basics";
import { SelectField } from "../../widgets/form";
import { DataTable } from "../../widgets/table";
import { AssignmentEditor } from "./assignment_editor";
import { dueText, exerciseTitle, limitText } from "./assignment_text";
import { PhaseBadge } from "./my_work_page";

interface Props {
  readonly client: Client;
  readonly query: URLSearchParams;
  readonly onQuery: (query: Readonly<Record<string, string>>) => void;
  readonly onOpen: (id: string) => void;
}

// What is assigned to which cohort, for who teaches.
export function AssignmentsPage({ client, query, onQuery, onOpen }: Props) {
  const cohort = query.get("cohort") ?? "";
  const { loaded, reload } = useRequest(`assignments ${cohort}`, (signal) => client.teaching.assignments({ cohort }, signal));
  const cohorts = useRequest("cohorts", (signal) => client.people.allCohorts(signal));
  const names = cohorts.loaded.state === "ready" ? cohorts.loaded.value : [];
  const [adding, setAdding] = useState(false);
  const now = Date.now();
  return (
    <>
      <div class="toolbar">
        <PageTitle document="Assignments">Assignments</PageTitle>
        <button type="button" class="button primary" onClick={() => setAdding(true)}>Assign an exercise…</button>
      </div>
      <div class="filters">
        <SelectField label="Cohort" value={cohort} onValue={(id) => onQuery({ cohort: id })}
                     options={[{ value: "", title: "All" }, ...names.map((item) => ({ value: item.id, title: item.name }))]} />
      </div>
      {loaded.state === "loading" && <Loading what="assignments" />}
      {loaded.state === "failed" && <ErrorNotice title="The assignments could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && (loaded.value.length === 0 ? <Empty>Nothing is assigned yet.</Empty>
        : (
          <Card className="flush">
            <DataTable label="Assignments" items={loaded.value} rowKey={(item) => item.id} columns={[
              { title: "Exercise", cell: (item: Assignment) => <a href={`/assignments/${item.id}`}>{exerciseTitle(item)}</a> },
              { title: "Cohort", cell: (item: Assignment) => item.cohort?.name ?? "Everybody" },
              { title: "State", cell: (item: Assignment) => <span class="flags">{item.exam && <Badge tone="warning">Exam</Badge>}<PhaseBadge assignment={item} now={now} /></span> },
              { title: "Due", cell: (item: Assignment) => dueText(item, now) },
              { title: "Attempts allowed", cell: limitText },
              { title: "Grading", cell: (item: Assignment) => <a href={`/grading?assignment=${item.id}`}>Grade<span class="hidden"> {exerciseTitle(item)}</span></a> },
            ]} />
          </Card>
        ))}
      {adding && <AssignmentEditor client={client} cohort={cohort} onClose={() => setAdding(false)} onMade={(made) => onOpen(made.id)} />}
    </>
  );
}
