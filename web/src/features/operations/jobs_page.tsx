import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { failed } from "../../api/http";
import type { Job, JobState } from "../../api/types";
import { usePages } from "../../api/use_pages";
import { useRefresh } from "../../api/use_refresh";
import { say } from "../../base/words";
import { Badge, Card, PageTitle, Progress, type Tone } from "../../widgets/basics";
import { Confirm } from "../../widgets/dialog";
import { SelectField } from "../../widgets/form";
import { PagedList } from "../../widgets/pages";
import { type Column, DataTable } from "../../widgets/table";

const kPageSize = 50;
const kPollMs = 2000;
const kTones: Readonly<Record<Job["state"], Tone>> = {
  queued: "neutral",
  running: "neutral",
  done: "good",
  failed: "bad",
  cancelled: "warning",
};
const causes = (): Readonly<Record<string, string>> => ({
  seal: say("cause.seal"),
  reference: say("cause.reference"),
  rescore: say("cause.instructor"),
  appeal: say("cause.appeal"),
  rubric: say("cause.cohort"),
});

interface Props {
  readonly client: Client;
  readonly query: URLSearchParams;
  readonly onQuery: (query: Readonly<Record<string, string>>) => void;
}

// Background work of the server.
export function JobsPage({ client, query, onQuery }: Props) {
  const state = (query.get("state") ?? "") as JobState;
  const pages = usePages(state, (cursor, signal) => client.page("/jobs", { state, cursor, limit: kPageSize, signal }));
  const [cancelling, setCancelling] = useState<Job>();
  const polling = pages.onlyFirst && pages.items.some((job) => job.state === "queued" || job.state === "running");
  useRefresh(polling, kPollMs, pages.reload);
  const columns: readonly Column<Job>[] = [
    {
      title: say("jobs.job"),
      cell: (job) => <a href={`/attempts/${job.attempt_id}`}>{say("jobs.score", { id: job.attempt_id.slice(-8) })}</a>,
    },
    { title: say("jobs.why"), cell: (job) => causes()[job.cause] ?? job.cause },
    {
      title: say("common.state"),
      cell: (job) =>
        job.state === "running" ? (
          <Progress label={say("job_state.running")} share={job.progress} />
        ) : (
          <Badge tone={kTones[job.state]}>{say(`job_state.${job.state}`)}</Badge>
        ),
    },
    { title: say("jobs.tries"), number: true, cell: (job) => job.tries },
    { title: say("jobs.problem"), cell: (job) => (job.error === "" ? "–" : job.error) },
    {
      title: say("common.cancel"),
      hideTitle: true,
      cell: (job) =>
        job.state === "queued" || job.state === "running" ? (
          <div class="row-tools">
            <button type="button" class="button small" onClick={() => setCancelling(job)}>
              {say("jobs.cancel_ask")}
            </button>
          </div>
        ) : null,
    },
  ];
  return (
    <>
      <PageTitle document={say("nav.jobs")}>{say("nav.jobs")}</PageTitle>
      <div class="filters">
        <SelectField
          label={say("common.state")}
          value={state}
          onValue={(value) => onQuery({ state: value })}
          options={[
            { value: "", title: say("common.any") },
            ...(Object.keys(kTones) as JobState[]).map((value) => ({ value, title: say(`job_state.${value}`) })),
          ]}
        />
      </div>
      <PagedList pages={pages} list="jobs" empty={say("jobs.none")}>
        {(jobs) => (
          <Card className="flush">
            <DataTable label={say("nav.jobs")} items={jobs} rowKey={(job) => job.id} columns={columns} />
          </Card>
        )}
      </PagedList>
      {cancelling !== undefined && (
        <Confirm
          title={say("jobs.cancel_title")}
          action={say("jobs.cancel")}
          onClose={() => setCancelling(undefined)}
          onConfirm={() => failed(client.post("/jobs/{id}/cancel", { id: cancelling.id }), pages.reload)}
        >
          <p>{say("jobs.cancel_text")}</p>
        </Confirm>
      )}
    </>
  );
}
