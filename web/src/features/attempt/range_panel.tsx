import { useEffect, useState } from "preact/hooks";
import type { Series } from "../../api/types";
import { csvText } from "../../base/csv";
import { downloadFile, fileName } from "../../base/download";
import { keepTrying } from "../../base/keep_trying";
import { formatMoment, formatNumber, formatQuantity } from "../../base/format";
import { say, sayIf } from "../../base/words";
import { Folded, Loading, TableFrame } from "../../widgets/basics";
import { seriesEndS, stepAt } from "./clock";
import { speeds } from "./speed";

interface Props {
  readonly series: Series;
  readonly range: readonly [number, number] | undefined; // seconds, A to B; undefined: all of it
}

// Figures of a part of the attempt, and the part as a file.
export function RangePanel({ series, range }: Props) {
  const [fromS, toS] = range ?? [0, seriesEndS(series)];
  const text = say("range.moments", { from: formatMoment(fromS), to: formatMoment(toS) });
  return (
    <Folded
      title={range === undefined ? say("range.figures_all") : say("range.figures", { range: text })}
      content={() => <RangeFigures series={series} from={stepAt(series, fromS)} to={stepAt(series, toS)} text={text} />}
    />
  );
}

function RangeFigures({
  series,
  from,
  to,
  text,
}: {
  readonly series: Series;
  readonly from: number;
  readonly to: number;
  readonly text: string;
}) {
  const [made, setMade] = useState<typeof import("./range")>();
  useEffect(() => {
    const shown = new AbortController();
    void keepTrying(() => import("./range"), shown.signal).then(setMade);
    return () => shown.abort();
  }, []);
  if (made === undefined) return <Loading what={say("loading.page")} />;
  const speed = speeds(series);
  const save = () => {
    const { header, rows } = made.rangeTable(series, speed, from, to);
    downloadFile(`${fileName("attempt", text)}.csv`, "text/csv", csvText(header, rows));
  };
  const number = (value: number) => formatNumber(value, 2);
  return (
    <>
      <TableFrame label={say("range.figures", { range: text })}>
        <table class="dense">
          <thead>
            <tr>
              <th scope="col">{text}</th>
              {[say("range.mean"), say("range.peak"), "RMS", say("range.p95")].map((title) => (
                <th key={title} scope="col" class="number">
                  {title}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {made.rangeRows(series, speed, from, to).map((row) => (
              <tr key={row.what}>
                <th scope="row">
                  {say(`plot.${row.what}`)} ({row.unit})
                </th>
                <td class="number">{number(row.mean)}</td>
                <td class="number">{number(row.peak)}</td>
                <td class="number">{number(row.rms)}</td>
                <td class="number">{number(row.p95)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </TableFrame>
      <p>
        {say("range.removed", {
          list: made
            .removedIn(series, from, to)
            .map(([what, mm3]) =>
              what === "all"
                ? say("range.in_all", { volume: formatQuantity(mm3, "mm3") })
                : say("range.of_tissue", {
                    volume: formatQuantity(mm3, "mm3"),
                    tissue: sayIf(`tooth_tissue.${what}`) ?? what,
                  }),
            )
            .join(", "),
        })}
      </p>
      <p class="hint">{say("range.hint")}</p>
      <button type="button" class="button small" onClick={save}>
        {say("range.save")}
      </button>
    </>
  );
}
