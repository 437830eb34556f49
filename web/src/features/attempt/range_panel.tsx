import { useState } from "preact/hooks";
import type { Series } from "../../api/types";
import { csvText } from "../../base/csv";
import { downloadText, fileName } from "../../base/download";
import { formatMoment, formatNumber, formatQuantity } from "../../base/format";
import { TableFrame } from "../../widgets/basics";
import { seriesEndS, stepAt } from "./clock";
import { rangeRows, rangeTable, removedIn } from "./range";

interface Props {
  readonly series: Series;
  readonly range: readonly [number, number] | undefined;  // seconds, A to B; undefined: all of it
}

// Figures of a part of the attempt, and the part as a file.
export function RangePanel({ series, range }: Props) {
  const [open, setOpen] = useState(false);
  const [fromS, toS] = range ?? [0, seriesEndS(series)];
  const text = `${formatMoment(fromS)} to ${formatMoment(toS)}`;
  return (
    <details class="numbers" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>Figures of {range === undefined ? "all of it" : text}</summary>
      {open && <RangeFigures series={series} from={stepAt(series, fromS)} to={stepAt(series, toS)} text={text} />}
    </details>
  );
}

function RangeFigures({ series, from, to, text }: { readonly series: Series; readonly from: number; readonly to: number; readonly text: string }) {
  const save = () => {
    const { header, rows } = rangeTable(series, from, to);
    downloadText(`${fileName("attempt", text)}.csv`, "text/csv", csvText(header, rows));
  };
  const number = (value: number) => formatNumber(value, 2);
  return (
    <>
      <TableFrame label={`Figures of ${text}`}>
        <table class="dense">
          <thead><tr><th scope="col">{text}</th>{["Mean", "Peak", "RMS", "95 % below"].map((title) => <th key={title} scope="col" class="number">{title}</th>)}</tr></thead>
          <tbody>
            {rangeRows(series, from, to).map((row) => (
              <tr key={row.title}>
                <th scope="row">{row.title} ({row.unit})</th>
                <td class="number">{number(row.mean)}</td><td class="number">{number(row.peak)}</td><td class="number">{number(row.rms)}</td><td class="number">{number(row.p95)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </TableFrame>
      <p>Removed: {removedIn(series, from, to).map(([what, mm3]) => `${formatQuantity(mm3, "mm3")} ${what}`).join(", ")}.</p>
      <p class="hint">A and B beside the playback choose the part.</p>
      <button type="button" class="button small" onClick={save}>Save this part as CSV</button>
    </>
  );
}
