import { useMemo } from "preact/hooks";
import type { Client } from "../../api/client";
import { strokesIn } from "../../api/strokes";
import { useRequest } from "../../api/use_request";
import { Card, ErrorNotice, Loading, Notice } from "../../widgets/basics";
import { StrokesView } from "../../widgets/strokes/strokes_view";

// What can be drawn of a qualification report: how it feels to press, stroke, reverse, lift, nick and slip out.
export function DrawnReport({ client, id, onClose }: { readonly client: Client; readonly id: string; readonly onClose: () => void }) {
  const { loaded, reload } = useRequest(id, (signal) => client.profiles.report(id, signal));
  const strokes = useMemo(() => (loaded.state === "ready" ? strokesIn(loaded.value) : undefined), [loaded]);
  return (
    <Card title="Force against time" aside={<button type="button" class="button small" onClick={onClose}>Close</button>}>
      {loaded.state === "loading" && <Loading what="the report" />}
      {loaded.state === "failed" && <ErrorNotice title="The report could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {strokes?.ok === false && (
        <Notice tone="neutral" title="Nothing to draw in this report">
          <p>{capital(strokes.error)}. A report with strokes is written by <code>enamel-station qualify --profile NAME --suite strokes --json FILE</code>.</p>
        </Notice>
      )}
      {strokes?.ok === true && <StrokesView strokes={strokes.value} />}
    </Card>
  );
}

function capital(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
