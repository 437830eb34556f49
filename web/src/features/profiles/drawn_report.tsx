import { useMemo } from "preact/hooks";
import type { Client } from "../../api/client";
import { drawableIn } from "../../api/drawable";
import { useRequest } from "../../api/use_request";
import { say, sayWith } from "../../base/words";
import { Card, Notice, Waits } from "../../widgets/basics";
import { DrawnView } from "../../widgets/lab_report/drawn_view";

// What can be drawn of a qualification report: how it feels to press, stroke, reverse, lift, nick
// and slip out, and what else enamel-lab found.
export function DrawnReport({
  client,
  id,
  onClose,
}: {
  readonly client: Client;
  readonly id: string;
  readonly onClose: () => void;
}) {
  const { loaded, reload } = useRequest(id, (signal) => client.get("/profile-reports/{id}", { id, signal }));
  const drawable = useMemo(() => (loaded.state === "ready" ? drawableIn(loaded.value) : undefined), [loaded]);
  const close = (
    <button type="button" class="button small" onClick={onClose}>
      {say("common.close")}
    </button>
  );
  if (drawable?.ok === true) return <DrawnView drawable={drawable.value} aside={close} />;
  return (
    <Card title={say("strokes.title")} aside={close}>
      <Waits loaded={loaded} reload={reload} what={say("loading.report")} failed={say("drawn.failed")} />
      {drawable?.ok === false && (
        <Notice tone="neutral" title={say("drawn.nothing")}>
          <p>
            {sayWith("drawn.nothing_text", {
              reason: capital(drawable.error),
              command: <code>enamel-lab qualify --profile NAME --suite withdrawal --json FILE</code>,
            })}
          </p>
        </Notice>
      )}
    </Card>
  );
}

function capital(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
