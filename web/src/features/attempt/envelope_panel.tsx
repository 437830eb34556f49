import type { Client } from "../../api/client";
import type { Envelope, Score } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatNumber, formatQuantity } from "../../base/format";
import { metricTitle } from "../../base/metric_titles";
import { say } from "../../base/words";
import { Card, Folded } from "../../widgets/basics";
import { still } from "../../widgets/still";
import { DataTable } from "../../widgets/table";
import { isAmong, placeAmong } from "./envelope_place";

interface Props {
  readonly client: Client;
  readonly exercise: string;
  readonly envelope: Envelope;
  readonly metrics: Score["metrics"];
}

// Where the attempt lies among several dentists' cuts: first what is outside of theirs.
export const EnvelopePanel = still(function EnvelopePanel({ client, exercise, envelope, metrics }: Props) {
  const references = useRequest(exercise, (signal) =>
    client.all("/exercises/{id}/references", { id: exercise, signal }),
  );
  const known = references.loaded.state === "ready" ? references.loaded.value : [];
  const nameOf = (attempt: string, place: number) =>
    known.find((each) => each.attempt_id === attempt)?.dentist ??
    say("envelope.dentist", { number: String(place + 1) });
  const [nearest] = envelope.references;
  const rows = envelope.metrics.flatMap((place): Row[] => {
    const own = metrics.find(({ name }) => name === place.name);
    return own === undefined ? [] : [{ ...place, value: own.value }];
  });
  const outside = rows.filter((row) => !isAmong(row));
  return (
    <Card title={say("envelope.title", { count: envelope.references.length })}>
      {nearest !== undefined && (
        <p>
          {say("envelope.nearest", {
            name: nameOf(nearest.attempt, 0),
            percent: formatNumber(nearest.overlap_percent, 1),
          })}
        </p>
      )}
      <dl class="facts stacked">
        <div>
          <dt>{say("envelope.by_none")}</dt>
          <dd>{formatQuantity(envelope.taken_by_mm3[0] ?? 0, "mm3")}</dd>
        </div>
        <div>
          <dt>{say("envelope.by_all")}</dt>
          <dd>{formatQuantity(envelope.left_of_all_mm3, "mm3")}</dd>
        </div>
        <div>
          <dt>{say("envelope.differ")}</dt>
          <dd>{formatQuantity(envelope.disputed_mm3, "mm3")}</dd>
        </div>
      </dl>
      {outside.length === 0 ? (
        <p>{say("envelope.all_among")}</p>
      ) : (
        <Measurements label={say("envelope.criteria")} rows={outside} />
      )}
      {outside.length < rows.length && (
        <Folded
          title={say("envelope.every")}
          content={() => <Measurements label={say("envelope.every")} rows={rows} />}
        />
      )}
      <p class="hint">{say("envelope.points")}</p>
    </Card>
  );
});

type Row = Envelope["metrics"][number] & { readonly value: number };

function Measurements({ label, rows }: { readonly label: string; readonly rows: readonly Row[] }) {
  return (
    <DataTable
      label={label}
      items={rows}
      rowKey={(row) => row.name}
      dense
      columns={[
        { title: say("envelope.measurement"), cell: (row) => metricTitle(row.name, row.unit) },
        { title: say("editor.here"), number: true, cell: (row) => formatQuantity(row.value, row.unit) },
        {
          title: say("envelope.dentists"),
          number: true,
          cell: (row) =>
            say("marks.range", {
              low: formatQuantity(row.least, row.unit),
              high: formatQuantity(row.most, row.unit),
            }),
        },
        { title: say("envelope.place"), cell: placeAmong },
      ]}
    />
  );
}
