import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { addressOf, failed } from "../../api/http";
import type { Exercise, Reference } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatDateTime } from "../../base/format";
import { say } from "../../base/words";
import { Badge, Brief, Card, Empty, Waits } from "../../widgets/basics";
import { Confirm } from "../../widgets/dialog";
import { DataTable } from "../../widgets/table";
import { stateText, versionText } from "./exercise_text";

interface Props {
  readonly client: Client;
  readonly exercise: Exercise;
}

// Every version of the exercise, the draft first.
export function VersionsCard({ client, exercise }: Props) {
  const { loaded, reload } = useRequest(`${exercise.id} ${exercise.revision} ${exercise.state}`, (signal) =>
    client.all("/exercises/{id}/versions", { id: exercise.id, signal }),
  );
  return (
    <Card title={say("version.title")}>
      <Waits loaded={loaded} reload={reload} what={say("loading.versions")} failed={say("version.failed")} />
      {loaded.state === "ready" && (
        <DataTable
          label={say("version.title")}
          items={loaded.value}
          rowKey={(version) => version.id}
          dense
          columns={[
            {
              title: say("version.one"),
              cell: (version) =>
                version.id === exercise.id ? (
                  <b>{say("version.shown", { version: versionText(version) })}</b>
                ) : (
                  <a href={`/exercises/${version.id}`}>{versionText(version)}</a>
                ),
            },
            {
              title: say("common.state"),
              cell: (version) => <Badge tone={stateText(version.state).tone}>{stateText(version.state).title}</Badge>,
            },
            { title: say("listed.since"), cell: (version) => formatDateTime(version.published_ms) },
            {
              title: say("version.document"),
              cell: (version) => (
                <a
                  href={addressOf("/exercises/{id}/document", { id: version.id })}
                  download={`${exercise.name}_${version.version}.json`}
                >
                  <Brief shown="JSON" full={say("version.json_of", { version: versionText(version) })} />
                </a>
              ),
            },
          ]}
        />
      )}
    </Card>
  );
}

const kMaxCounting = 8; // as ReferenceRows::kMaxCounting of the server

// The dentists' cuts that attempts are compared with: those that are not withdrawn.
export function ReferencesCard({ client, exercise }: Props) {
  const { loaded, reload } = useRequest(exercise.id, (signal) =>
    client.all("/exercises/{id}/references", { id: exercise.id, signal }),
  );
  const [leaving, setLeaving] = useState<Reference>();
  const references = loaded.state === "ready" ? loaded.value : [];
  const counting = references.filter((reference) => reference.withdrawn_ms === 0).slice(0, kMaxCounting);
  return (
    <Card title={say("references.title")}>
      <Waits loaded={loaded} reload={reload} what={say("loading.references")} failed={say("references.failed")} />
      {loaded.state === "ready" &&
        (references.length === 0 ? (
          <Empty>{say("references.none")}</Empty>
        ) : (
          <DataTable
            label={say("references.list")}
            items={references}
            rowKey={(reference) => reference.id}
            dense
            columns={[
              {
                title: say("references.dentist"),
                cell: (reference) => (
                  <>
                    <a href={`/attempts/${reference.attempt_id}`}>{reference.dentist ?? say("references.not_named")}</a>
                    <span class="sub">
                      {reference.consent ? say("references.name_shown") : say("references.name_hidden")}
                    </span>
                  </>
                ),
              },
              {
                title: say("listed.since"),
                cell: (reference) => (
                  <>
                    {formatDateTime(reference.created_ms)}
                    <span class="sub">{say("version.number", { number: String(reference.version) })}</span>
                  </>
                ),
              },
              {
                title: say("common.state"),
                cell: (reference) =>
                  counting.includes(reference) ? (
                    <Badge tone="good">{say("references.counts")}</Badge>
                  ) : reference.withdrawn_ms > 0 ? (
                    <Badge tone="neutral">{say("references.withdrawn")}</Badge>
                  ) : (
                    <Badge tone="neutral">{say("references.earlier")}</Badge>
                  ),
              },
              {
                title: say("references.withdraw"),
                hideTitle: true,
                cell: (reference) =>
                  reference.withdrawn_ms > 0 ? null : (
                    <div class="row-tools">
                      <button type="button" class="button small" onClick={() => setLeaving(reference)}>
                        <Brief
                          shown={say("references.withdraw_ask")}
                          full={say("references.withdraw_which", { version: String(reference.version) })}
                        />
                      </button>
                    </div>
                  ),
              },
            ]}
          />
        ))}
      {leaving !== undefined && (
        <Confirm
          title={say("references.withdraw_title")}
          action={say("references.withdraw")}
          onClose={() => setLeaving(undefined)}
          onConfirm={() => failed(client.post("/references/{id}/withdraw", { id: leaving.id }), reload)}
        >
          <p>{say("references.withdraw_text")}</p>
        </Confirm>
      )}
    </Card>
  );
}
