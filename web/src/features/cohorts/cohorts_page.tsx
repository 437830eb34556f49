import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { useChange } from "../../api/use_change";
import { usePages } from "../../api/use_pages";
import { say } from "../../base/words";
import { Badge, Card, ErrorNotice, PageTitle } from "../../widgets/basics";
import { Dialog, FormButtons } from "../../widgets/dialog";
import { TextField } from "../../widgets/form";
import { PagedList } from "../../widgets/pages";
import { DataTable } from "../../widgets/table";

const kPageSize = 100;

export function CohortsPage({ client, admin }: { readonly client: Client; readonly admin: boolean }) {
  const pages = usePages("cohorts", (cursor, signal) => client.page("/cohorts", { cursor, limit: kPageSize, signal }));
  const [adding, setAdding] = useState(false);
  return (
    <>
      <div class="toolbar">
        <PageTitle document={say("nav.cohorts")}>{say("nav.cohorts")}</PageTitle>
        {admin && (
          <button type="button" class="button primary" onClick={() => setAdding(true)}>
            {say("cohorts.add_ask")}
          </button>
        )}
      </div>
      <PagedList pages={pages} list="cohorts" empty={admin ? say("cohorts.none") : say("cohorts.none_assigned")}>
        {(cohorts) => (
          <Card className="flush">
            <DataTable
              label={say("nav.cohorts")}
              items={cohorts}
              rowKey={(cohort) => cohort.id}
              columns={[
                { title: say("common.cohort"), cell: (cohort) => <a href={`/cohorts/${cohort.id}`}>{cohort.name}</a> },
                { title: say("cohorts.students"), number: true, cell: (cohort) => cohort.students },
                {
                  title: say("cohorts.instructors"),
                  cell: (cohort) => cohort.instructors.join(", ") || "–",
                },
                {
                  title: say("common.state"),
                  cell: (cohort) =>
                    cohort.archived_ms > 0 ? (
                      <Badge tone="neutral">{say("cohort.archived")}</Badge>
                    ) : (
                      <Badge tone="good">{say("cohorts.in_use")}</Badge>
                    ),
                },
              ]}
            />
            <p class="hidden">{say("cohorts.count", { count: cohorts.length })}</p>
          </Card>
        )}
      </PagedList>
      {adding && <AddCohort client={client} onClose={() => setAdding(false)} onAdded={pages.reload} />}
    </>
  );
}

function AddCohort({
  client,
  onClose,
  onAdded,
}: {
  readonly client: Client;
  readonly onClose: () => void;
  readonly onAdded: () => void;
}) {
  const [name, setName] = useState("");
  const change = useChange();
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await change.run(() => client.post("/cohorts", { body: { name: name.trim() } }));
    if (result?.ok !== true) return;
    onAdded();
    onClose();
  };
  return (
    <Dialog title={say("cohorts.add_title")} onClose={onClose}>
      <form class="form" onSubmit={(event) => void submit(event)}>
        <TextField
          label={say("account.name")}
          value={name}
          onValue={setName}
          required
          maxLength={200}
          problem={change.error?.field === "name" ? change.error.message : undefined}
        />
        {change.error !== undefined && change.error.field !== "name" && (
          <ErrorNotice title={say("common.not_added")} message={change.error.message} />
        )}
        <FormButtons action={say("common.add")} busy={change.busy} onCancel={onClose} />
      </form>
    </Dialog>
  );
}
