import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Exercise, Reference } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatDateTime } from "../../base/format";
import { Badge, Card, Empty, ErrorNotice, Loading } from "../../widgets/basics";
import { Confirm } from "../../widgets/dialog";
import { DataTable } from "../../widgets/table";
import { kStateTexts, versionText } from "./exercise_text";

interface Props {
  readonly client: Client;
  readonly exercise: Exercise;
}

// Every version of the exercise, the draft first.
export function VersionsCard({ client, exercise }: Props) {
  const { loaded, reload } = useRequest(`${exercise.id} ${exercise.revision} ${exercise.state}`, (signal) => client.teaching.versions(exercise.id, signal));
  return (
    <Card title="Versions">
      {loaded.state === "loading" && <Loading what="the versions" />}
      {loaded.state === "failed" && <ErrorNotice title="The versions could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && (
        <DataTable label="Versions" items={loaded.value} rowKey={(version) => version.id} dense columns={[
          { title: "Version", cell: (version) => version.id === exercise.id ? <b>{versionText(version)}, shown here</b> : <a href={`/exercises/${version.id}`}>{versionText(version)}</a> },
          { title: "State", cell: (version) => <Badge tone={kStateTexts[version.state].tone}>{kStateTexts[version.state].title}</Badge> },
          { title: "Since", cell: (version) => formatDateTime(version.published_ms) },
          { title: "Document", cell: (version) => <a href={client.teaching.documentAddress(version.id)} download={`${exercise.name}_${version.version}.json`}>JSON<span class="hidden"> of {versionText(version)}</span></a> },
        ]} />
      )}
    </Card>
  );
}

// The dentists' cuts that attempts are compared with; the newest that is not withdrawn counts.
export function ReferencesCard({ client, exercise }: Props) {
  const { loaded, reload } = useRequest(exercise.id, (signal) => client.teaching.references(exercise.id, signal));
  const [leaving, setLeaving] = useState<Reference>();
  const references = loaded.state === "ready" ? loaded.value : [];
  const counting = references.find((reference) => reference.withdrawn_ms === 0);
  return (
    <Card title="Reference cuts">
      {loaded.state === "loading" && <Loading what="the references" />}
      {loaded.state === "failed" && <ErrorNotice title="The references could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && (references.length === 0 ? <Empty>None yet. Open a scored attempt of a dentist and mark it as reference.</Empty> : (
        <DataTable label="References" items={references} rowKey={(reference) => reference.id} dense columns={[
          { title: "Dentist", cell: (reference) => (
            <><a href={`/attempts/${reference.attempt_id}`}>{reference.dentist ?? "Not named"}</a><span class="sub">{reference.consent ? "Name shown to students" : "Name not shown to students"}</span></>) },
          { title: "Since", cell: (reference) => <>{formatDateTime(reference.created_ms)}<span class="sub">version {reference.version}</span></> },
          { title: "State", cell: (reference) => reference === counting ? <Badge tone="good">Counts</Badge>
            : reference.withdrawn_ms > 0 ? <Badge tone="neutral">Withdrawn</Badge> : <Badge tone="neutral">Earlier</Badge> },
          { title: "Withdraw", hideTitle: true, cell: (reference) => reference.withdrawn_ms > 0 ? null
            : <div class="row-tools"><button type="button" class="button small" onClick={() => setLeaving(reference)}>Withdraw…<span class="hidden"> version {reference.version}</span></button></div> },
        ]} />
      ))}
      {leaving !== undefined && (
        <Confirm title="Withdraw this reference?" action="Withdraw" onClose={() => setLeaving(undefined)}
                 onConfirm={async () => {
                   const result = await client.teaching.withdrawReference(leaving.id);
                   if (!result.ok) return result.error.message;
                   reload();
                   return undefined;
                 }}>
          <p>The one before it counts again for attempts scored from now on. Scores made with it stay until they are made again. To use it again, mark its attempt as reference again.</p>
        </Confirm>
      )}
    </Card>
  );
}
