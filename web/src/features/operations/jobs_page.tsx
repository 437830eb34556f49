import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Job } from "../../api/types";
import { usePages } from "../../api/use_pages";
import { useRefresh } from "../../api/use_refresh";
import { Badge, Card, PageTitle, Progress, type Tone } from "../../widgets/basics";
import { Confirm } from "../../widgets/dialog";
import { SelectField } from "../../widgets/form";
import { PagedList } from "../../widgets/pages";
import { type Column, DataTable } from "../../widgets/table";

const kPageSize = 50;
const kPollMs = 2000;
const kTones: Readonly<Record<Job["state"], Tone>> = { queued: "neutral", running: "neutral", done: "good", failed: "bad", cancelled: "warning" };
const kTitles: Readonly<Record<Job["state"], string>> = { queued: "Waiting", running: "Running", done: "Done", failed: "Failed", cancelled: "Cancelled" };
const kCauses: Readonly<Record<string, string>> = {
  seal: "Attempt was finished", reference: "New reference", rescore: "Asked for by an instructor", appeal: "Appeal", rubric: "Cohort scored again",
};

interface Props {
  readonly client: Client;
  readonly query: URLSearchParams;
  readonly onQuery: (query: Readonly<Record<string, string>>) => void;
}

// Background work of the server.
export function JobsPage({ client, query, onQuery }: Props) {
  const state = query.get("state") ?? "";
  const pages = usePages(state, (cursor, signal) => client.operations.jobs({ state, cursor, limit: kPageSize }, signal));
  const [cancelling, setCancelling] = useState<Job>();
  const polling = pages.onlyFirst && pages.items.some((job) => job.state === "queued" || job.state === "running");
  useRefresh(polling, kPollMs, pages.reload);
  const columns: readonly Column<Job>[] = [
    { title: "Job", cell: (job) => <a href={`/attempts/${job.attempt_id}`}>Score attempt {job.attempt_id.slice(-8)}</a> },
    { title: "Why", cell: (job) => kCauses[job.cause] ?? job.cause },
    { title: "State", cell: (job) => job.state === "running" ? <Progress label="Running" share={job.progress} /> : <Badge tone={kTones[job.state]}>{kTitles[job.state]}</Badge> },
    { title: "Tries", number: true, cell: (job) => job.tries },
    { title: "Problem", cell: (job) => job.error === "" ? "–" : job.error },
    { title: "Cancel", hideTitle: true, cell: (job) => job.state === "queued" || job.state === "running"
      ? <div class="row-tools"><button type="button" class="button small" onClick={() => setCancelling(job)}>Cancel…</button></div> : null },
  ];
  return (
    <>
      <PageTitle document="Jobs">Jobs</PageTitle>
      <div class="filters">
        <SelectField label="State" value={state} onValue={(value) => onQuery({ state: value })}
                     options={[{ value: "", title: "Any" }, ...Object.entries(kTitles).map(([value, title]) => ({ value, title }))]} />
      </div>
      <PagedList pages={pages} what="jobs" empty="There is no such job.">
        {(jobs) => <Card className="flush"><DataTable label="Jobs" items={jobs} rowKey={(job) => job.id} columns={columns} /></Card>}
      </PagedList>
      {cancelling !== undefined && (
        <Confirm title="Cancel this job?" action="Cancel the job" onClose={() => setCancelling(undefined)}
                 onConfirm={async () => {
                   const result = await client.operations.cancelJob(cancelling.id);
                   if (!result.ok) return result.error.message;
                   pages.reload();
                   return undefined;
                 }}>
          <p>The attempt stays unscored until somebody chooses “Score again” at it.</p>
        </Confirm>
      )}
    </>
  );
}
