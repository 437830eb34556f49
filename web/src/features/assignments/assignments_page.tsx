import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Assignment } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { say } from "../../base/words";
import { Badge, Brief, Card, Empty, PageTitle, Waits } from "../../widgets/basics";
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

// The exercises assigned to each cohort, for instructors.
export function AssignmentsPage({ client, query, onQuery, onOpen }: Props) {
  const cohort = query.get("cohort") ?? "";
  const { loaded, reload } = useRequest(`assignments ${cohort}`, (signal) =>
    client.all("/assignments", { cohort, signal }),
  );
  const cohorts = useRequest("cohorts", (signal) => client.all("/cohorts", { signal }));
  const names = cohorts.loaded.state === "ready" ? cohorts.loaded.value : [];
  const [adding, setAdding] = useState(false);
  const now = Date.now();
  return (
    <>
      <div class="toolbar">
        <PageTitle document={say("nav.assignments")}>{say("nav.assignments")}</PageTitle>
        <button type="button" class="button primary" onClick={() => setAdding(true)}>
          {say("assignments.assign_ask")}
        </button>
      </div>
      <div class="filters">
        <SelectField
          label={say("common.cohort")}
          value={cohort}
          onValue={(id) => onQuery({ cohort: id })}
          options={[
            { value: "", title: say("common.all") },
            ...names.map((item) => ({ value: item.id, title: item.name })),
          ]}
        />
      </div>
      <Waits
        loaded={loaded}
        reload={reload}
        what={say("loading.assignments")}
        failed={say("assignments.list_failed")}
      />
      {loaded.state === "ready" &&
        (loaded.value.length === 0 ? (
          <Empty>{say("assignments.none")}</Empty>
        ) : (
          <Card className="flush">
            <DataTable
              label={say("nav.assignments")}
              items={loaded.value}
              rowKey={(item) => item.id}
              columns={[
                {
                  title: say("common.exercise"),
                  cell: (item: Assignment) => <a href={`/assignments/${item.id}`}>{exerciseTitle(item)}</a>,
                },
                {
                  title: say("common.cohort"),
                  cell: (item: Assignment) => item.cohort?.name ?? say("common.everybody"),
                },
                {
                  title: say("common.state"),
                  cell: (item: Assignment) => (
                    <span class="flags">
                      {item.exam && <Badge tone="warning">{say("attempt_flag.exam")}</Badge>}
                      <PhaseBadge assignment={item} now={now} />
                    </span>
                  ),
                },
                { title: say("assignments.due"), cell: (item: Assignment) => dueText(item, now) },
                { title: say("assignments.allowed"), cell: limitText },
                {
                  title: say("grading.title"),
                  cell: (item: Assignment) => (
                    <a href={`/grading?assignment=${item.id}`}>
                      <Brief
                        shown={say("grading.grade")}
                        full={say("grading.grade_what", { title: exerciseTitle(item) })}
                      />
                    </a>
                  ),
                },
              ]}
            />
          </Card>
        ))}
      {adding && (
        <AssignmentEditor
          client={client}
          cohort={cohort}
          onClose={() => setAdding(false)}
          onMade={(made) => onOpen(made.id)}
        />
      )}
    </>
  );
}
