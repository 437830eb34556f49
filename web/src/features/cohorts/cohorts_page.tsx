import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Cohort } from "../../api/types";
import { useChange } from "../../api/use_change";
import { usePages } from "../../api/use_pages";
import { plural } from "../../base/format";
import { Badge, Card, ErrorNotice, PageTitle } from "../../widgets/basics";
import { Dialog, FormButtons } from "../../widgets/dialog";
import { TextField } from "../../widgets/form";
import { PagedList } from "../../widgets/pages";
import { DataTable } from "../../widgets/table";

const kPageSize = 100;

export function CohortsPage({ client, admin }: { readonly client: Client; readonly admin: boolean }) {
  const pages = usePages("cohorts", (cursor, signal) => client.people.cohorts({ cursor, limit: kPageSize }, signal));
  const [adding, setAdding] = useState(false);
  const students = (cohort: Cohort) => cohort.members.filter((member) => member.role === "student").length;
  return (
    <>
      <div class="toolbar">
        <PageTitle document="Cohorts">Cohorts</PageTitle>
        {admin && <button type="button" class="button primary" onClick={() => setAdding(true)}>Add a cohort…</button>}
      </div>
      <PagedList pages={pages} what="cohorts" empty={admin ? "There is no cohort yet." : "No cohort is assigned to you. An administrator adds instructors to cohorts."}>
        {(cohorts) => (
          <Card className="flush">
            <DataTable label="Cohorts" items={cohorts} rowKey={(cohort) => cohort.id} columns={[
              { title: "Cohort", cell: (cohort) => <a href={`/cohorts/${cohort.id}`}>{cohort.name}</a> },
              { title: "Students", number: true, cell: (cohort) => students(cohort) },
              { title: "Instructors", cell: (cohort) => cohort.members.filter((member) => member.role === "instructor").map((member) => member.display_name).join(", ") || "–" },
              { title: "State", cell: (cohort) => cohort.archived_ms > 0 ? <Badge tone="neutral">Archived</Badge> : <Badge tone="good">In use</Badge> },
            ]} />
            <p class="hidden">{plural(cohorts.length, "cohort")}</p>
          </Card>
        )}
      </PagedList>
      {adding && <AddCohort client={client} onClose={() => setAdding(false)} onAdded={pages.reload} />}
    </>
  );
}

function AddCohort({ client, onClose, onAdded }: { readonly client: Client; readonly onClose: () => void; readonly onAdded: () => void }) {
  const [name, setName] = useState("");
  const change = useChange();
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await change.run(() => client.people.addCohort(name.trim()));
    if (result?.ok !== true) return;
    onAdded();
    onClose();
  };
  return (
    <Dialog title="Add a cohort" onClose={onClose}>
      <form class="form" onSubmit={(event) => void submit(event)}>
        <TextField label="Name" value={name} onValue={setName} required maxLength={200} problem={change.error?.field === "name" ? change.error.message : undefined} />
        {change.error !== undefined && change.error.field !== "name" && <ErrorNotice title="Not added" message={change.error.message} />}
        <FormButtons action="Add" disabled={change.busy} onCancel={onClose} />
      </form>
    </Dialog>
  );
}
