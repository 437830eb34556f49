import type { Client } from "../../api/client";
import type { Envelope, Score } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatNumber, formatQuantity, metricTitle } from "../../base/format";
import { Card } from "../../widgets/basics";
import { DataTable } from "../../widgets/table";
import { placeAmong } from "./envelope_place";

interface Props {
  readonly client: Client;
  readonly exercise: string;
  readonly envelope: Envelope;
  readonly metrics: Score["metrics"];
  readonly judged: readonly string[];           // metrics of the rubric, in its order
}

// Where the attempt lies among several dentists' cuts. Points come from the newest of them alone.
export function EnvelopePanel({ client, exercise, envelope, metrics, judged }: Props) {
  const references = useRequest(exercise, (signal) => client.teaching.references(exercise, signal));
  const known = references.loaded.state === "ready" ? references.loaded.value : [];
  const nameOf = (attempt: string, place: number) => known.find((each) => each.attempt_id === attempt)?.dentist ?? `Dentist ${place + 1}`;
  const [nearest] = envelope.references;
  const rows = judged.flatMap((name) => {
    const place = envelope.metrics.find((each) => each.name === name);
    const own = metrics.find((each) => each.name === name);
    return place === undefined || own === undefined ? [] : [{ ...place, value: own.value }];
  });
  return (
    <Card title={`Among ${envelope.references.length} dentists`}>
      {nearest !== undefined && <p>Nearest is the cut of {nameOf(nearest.attempt, 0)}: {formatNumber(nearest.overlap_percent, 1)} % of what both took is the same.</p>}
      <dl class="facts stacked">
        <div><dt>Taken by no dentist</dt><dd>{formatQuantity(envelope.taken_by_mm3[0] ?? 0, "mm3")}</dd></div>
        <div><dt>Taken by all of them, and left here</dt><dd>{formatQuantity(envelope.left_of_all_mm3, "mm3")}</dd></div>
        <div><dt>Where the dentists differ</dt><dd>{formatQuantity(envelope.disputed_mm3, "mm3")}</dd></div>
      </dl>
      <DataTable label="Criteria among the dentists" items={rows} rowKey={(row) => row.name} dense columns={[
        { title: "Criterion", cell: (row) => metricTitle(row.name, row.unit) },
        { title: "Here", number: true, cell: (row) => formatQuantity(row.value, row.unit) },
        { title: "Dentists", number: true, cell: (row) => `${formatQuantity(row.least, row.unit)} to ${formatQuantity(row.most, row.unit)}` },
        { title: "Place", cell: placeAmong },
      ]} />
      <p class="hint">Points come from the newest reference alone.</p>
    </Card>
  );
}
