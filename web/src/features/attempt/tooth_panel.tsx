import { useMemo, useState } from "preact/hooks";
import type { ApiError } from "../../api/http";
import type { Surface } from "../../api/surface";
import type { Series } from "../../api/types";
import type { Loaded } from "../../api/use_request";
import { formatLimit, formatNumber, formatQuantity, formatSigned } from "../../base/format";
import { Card, ErrorNotice, Loading, Segmented } from "../../widgets/basics";
import { DeviationLegend, TissueLegend } from "../../widgets/tooth/legend";
import type { ColorMode, PointMm } from "../../widgets/tooth/scene";
import { tissuesPresent, tissueTitle, workpiece } from "../../widgets/tooth/tissue";
import { type LookHandle, type ToothPin, ToothView } from "../../widgets/tooth/tooth_view";
import { type DeviationSummary, outlook, summariseDeviation } from "./deviation";
import type { Mark } from "./moments";
import { PlaybackBar, playbackKey } from "./playback_bar";
import type { PlaybackControl } from "./use_playback";

const kPathSeconds = 3;                         // of the tool's way drawn behind it

interface Props {
  readonly surface: Loaded<Surface>;
  readonly toleranceMm: number;                 // of the rubric
  readonly early: Surface | undefined;          // the same without deviation, shown until it is there
  readonly control: PlaybackControl | undefined;
  readonly series: Series | undefined;
  readonly cursor: number | undefined;              // undefined: no tool is drawn
  readonly marks: readonly Mark[];
  readonly chosen: string | undefined;          // id of a remark
  readonly point: PointMm | undefined;          // for the remark that is being written
  readonly look: LookHandle;
  readonly onMark: (mark: Mark) => void;
  readonly onPoint: ((point: PointMm) => void) | undefined;
  readonly onRetry: () => void;
}

export function ToothPanel({ surface, early, onRetry, ...rest }: Props) {
  return (
    <Card className="tooth-card" title={rest.control?.playback.showing === true ? "During the attempt" : "After the attempt"}>
      {surface.state === "loading" && (early === undefined ? <Loading what="the picture" /> : <LoadedTooth surface={early} compared={false} {...rest} />)}
      {surface.state === "failed" && <SurfaceError error={surface.error} onRetry={onRetry} />}
      {surface.state === "ready" && <LoadedTooth surface={surface.value} compared {...rest} />}
    </Card>
  );
}

function LoadedTooth({ surface, toleranceMm, compared, control, series, cursor, marks, chosen, point, look, onMark, onPoint }: Omit<Props, "surface" | "early" | "onRetry"> & { readonly surface: Surface; readonly compared: boolean }) {
  const summary = useMemo(() => summariseDeviation(surface, toleranceMm), [surface, toleranceMm]);
  const angled = useMemo(() => outlook(surface, summary), [surface, summary?.sides[0]?.side]);
  const tissues = useMemo(() => tissuesPresent(surface.tissue), [surface]);
  const [wanted, setMode] = useState<ColorMode>("deviation");
  // On the way there is nothing to compare with: a reference is of a finished tooth.
  const playback = control?.playback.showing === true;
  const mode: ColorMode = summary === undefined || playback ? "tissue" : wanted;
  const path = useMemo(() => pathBefore(series, cursor), [series, cursor]);
  const pins = useMemo(() => pinsOf(marks, chosen, point), [marks, chosen, point]);
  return (
    <>
      {summary !== undefined && (
        <div style={{ visibility: playback ? "hidden" : "visible" }}>
          <Segmented legend="Colours show" name="tooth-mode" value={mode} onChange={setMode}
                     choices={[{ value: "deviation", title: "Deviation" }, { value: "tissue", title: "Tissues" }]} />
        </div>
      )}
      {control !== undefined && <PlaybackBar control={control} />}
      <div onKeyDown={(event) => { if (control !== undefined) playbackKey(event, control); }}>
        <ToothView film={control?.playback} surface={surface} mode={mode} label={playback ? "Picture during the attempt" : pictureText(summary, tissues)} angled={angled} tool={playback ? undefined : path.at(-1)} path={path} pins={pins} look={look} onPick={onPoint}
                   onPin={(key) => { const mark = marks.find((item) => item.annotation.id === key); if (mark !== undefined) onMark(mark); }} />
      </div>
      {mode === "deviation" ? <DeviationLegend /> : <TissueLegend tissues={tissues} />}
      {summary === undefined
        ? <p class="hint">{compared ? "No deviation to show: the attempt has no reference, or its score is not released yet." : "The deviation from the reference is being loaded."}</p>
        : <DeviationTable summary={summary} />}
    </>
  );
}

const kNewPin = "new";

function pinsOf(marks: readonly Mark[], chosen: string | undefined, point: PointMm | undefined): ToothPin[] {
  const pins = marks.flatMap(({ annotation, number }): ToothPin[] => {
    const [x, y, z] = annotation.point_um ?? [];
    if (x === undefined || y === undefined || z === undefined) return [];
    return [{ key: annotation.id, text: String(number), label: `Remark ${number}`, pointMm: [x / 1000, y / 1000, z / 1000], chosen: annotation.id === chosen }];
  });
  return point === undefined ? pins : [...pins, { key: kNewPin, text: "+", label: "Point of the new remark", pointMm: point, chosen: true }];
}

function DeviationTable({ summary }: { readonly summary: DeviationSummary }) {
  return (
    <details class="numbers">
      <summary>Deviation in numbers</summary>
      <p>{deviationText(summary)}</p>
      <table>
        <caption class="hidden">Deviation from the reference by side of the cavity</caption>
        <thead><tr><th scope="col">Side</th><th scope="col" class="number">Mean (mm)</th><th scope="col" class="number">Largest (mm)</th></tr></thead>
        <tbody>
          {summary.sides.map((side) => (
            <tr key={side.side}>
              <th scope="row">{side.side}</th><td class="number">{formatSigned(side.meanMm)}</td><td class="number">{formatSigned(side.mostMm)}</td>
            </tr>
          ))}
        </tbody>
      </table>
      <p class="hint">Plus: more removed than in the reference. Minus: less.</p>
    </details>
  );
}

function SurfaceError({ error, onRetry }: { readonly error: ApiError; readonly onRetry: () => void }) {
  return <ErrorNotice title="The picture could not be loaded" message={error.message} onRetry={onRetry} />;
}

function pathBefore(series: Series | undefined, cursor: number | undefined): PointMm[] {
  const end = cursor === undefined ? undefined : series?.t_s[cursor];
  if (series === undefined || cursor === undefined || end === undefined) return [];
  let first = cursor;
  while (first > 0 && series.t_s[first - 1]! > end - kPathSeconds) --first;
  return series.anchor_mm.slice(first, cursor + 1);
}

function deviationText(summary: DeviationSummary): string {
  const percent = (share: number) => `${formatNumber(100 * share, 0)} %`;
  const worst = summary.sides[0];
  const where = worst === undefined ? "" : ` Furthest off on average: ${worst.side.toLowerCase()}, ${formatSigned(worst.meanMm)} mm.`;
  return `Of the surface that was cut, ${percent(summary.withinShare)} lies within ${formatLimit(summary.toleranceMm, "mm")} of the reference, ` +
         `${percent(summary.overShare)} is cut further and ${percent(summary.underShare)} less far; 95 % is within ${formatQuantity(summary.p95Mm, "mm")}.${where}`;
}

function pictureText(summary: DeviationSummary | undefined, tissues: readonly number[]): string {
  const tooth = `${workpiece(tissues) === "tooth" ? "Tooth" : "Block"} after the attempt, showing ${tissues.map(tissueTitle).join(", ").toLowerCase()}.`;
  return summary === undefined ? tooth : `${tooth} ${deviationText(summary)}`;
}
