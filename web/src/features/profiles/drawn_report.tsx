import { useMemo } from "preact/hooks";
import type { Client } from "../../api/client";
import { drawableIn } from "../../api/drawable";
import { useRequest } from "../../api/use_request";
import { Card, ErrorNotice, Loading, Notice } from "../../widgets/basics";
import { DrawnView } from "../../widgets/lab_report/drawn_view";

// What can be drawn of a qualification report: how it feels to press, stroke, reverse, lift, nick and slip out, and
// what else enamel-lab found.
export function DrawnReport({ client, id, onClose }: { readonly client: Client; readonly id: string; readonly onClose: () => void }) {
  const { loaded, reload } = useRequest(id, (signal) => client.profiles.report(id, signal));
  const drawable = useMemo(() => (loaded.state === "ready" ? drawableIn(loaded.value) : undefined), [loaded]);
  const close = <button type="button" class="button small" onClick={onClose}>Close</button>;
  if (drawable?.ok === true) return <DrawnView drawable={drawable.value} aside={close} />;
  return (
    <Card title="Force against time" aside={close}>
      {loaded.state === "loading" && <Loading what="the report" />}
      {loaded.state === "failed" && <ErrorNotice title="The report could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {drawable?.ok === false && (
        <Notice tone="neutral" title="Nothing to draw in this report">
          <p>{capital(drawable.error)}. A report is written by <code>enamel-lab qualify --profile NAME --suite strokes --json FILE</code>.</p>
        </Notice>
      )}
    </Card>
  );
}

function capital(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
