import type { Client } from "../../api/client";
import type { Backups, ServerHealth } from "../../api/types";
import { useChange } from "../../api/use_change";
import { formatBytes, formatDateTime, formatNumber } from "../../base/format";
import { relativeTime } from "../../base/local_time";
import { say } from "../../base/words";
import { Card, ErrorNotice, Progress } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { Facts } from "./facts";
import { retentionText } from "./health_text";

// The last backup, one that runs, and the button that starts one. Why the last one failed is among the findings.
export function BackupCard({
  client,
  health,
  onStart,
}: {
  readonly client: Client;
  readonly health: ServerHealth;
  readonly onStart: () => void;
}) {
  const { backup, backups, retention } = health;
  const { running, failed, drill, folder } = backups;
  const change = useChange();
  const ago = (at: number) => <span title={formatDateTime(at)}>{relativeTime(at, health.now_ms)}</span>;
  const start = async () => {
    if ((await change.run(() => client.post("/backups")))?.ok === true) onStart();
  };
  return (
    <Card title={say("health.backup")}>
      <Facts
        rows={[
          [say("health.last_backup"), backup === null ? say("health.never") : ago(backup.at_ms)],
          ...(backup === null
            ? []
            : [
                [say("health.backup_size"), formatBytes(backup.bytes)] as const,
                [say("health.backup_place"), backup.place] as const,
              ]),
          [say("health.missing"), backup === null ? "–" : formatNumber(backup.missing, 0)],
          ...(running === null ? [] : [[say("health.backup_running"), ago(running.since_ms)] as const]),
          ...(failed === null
            ? []
            : [
                [
                  say("health.backup_failed"),
                  say("health.backup_failed_at", { when: relativeTime(failed.at_ms, health.now_ms) }),
                ] as const,
              ]),
          ...(drill === null
            ? []
            : [
                [
                  say("health.drill"),
                  say(drill.problem === "" ? "health.drill_passed_at" : "health.drill_failed_at", {
                    when: relativeTime(drill.at_ms, health.now_ms),
                  }),
                ] as const,
              ]),
          ...(retention.length === 0
            ? [[say("health.kept"), say("health.for_good")] as const]
            : retention.map(retentionText)),
        ]}
      />
      {running !== null && <Progress label={phaseText(running)} share={shareOf(running)} />}
      {change.error !== undefined && (
        <ErrorNotice title={say("health.backup_not_started")} message={change.error.message} />
      )}
      {folder === "" ? (
        <p class="hint">{say("health.backup_nowhere")}</p>
      ) : (
        <>
          <Button
            kind=""
            busy={change.busy}
            blocked={running === null ? undefined : phaseText(running)}
            onClick={() => void start()}
          >
            {say("health.back_up")}
          </Button>
          <p class="hint">{say("health.backup_folder", { folder })}</p>
        </>
      )}
    </Card>
  );
}

type Running = NonNullable<Backups["running"]>;

function phaseText({ here, phase }: Running): string {
  if (!here) return say("health.backing_up_elsewhere");
  switch (phase) {
    case "database":
      return say("health.backing_up_database");
    case "blobs":
      return say("health.backing_up_files");
    case "keys":
      return say("health.backing_up_keys");
    case "":
      return say("health.backing_up");
  }
}

function shareOf({ done, all }: Running): number | undefined {
  return all > 0 ? done / all : undefined;
}
