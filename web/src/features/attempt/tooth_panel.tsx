import { useMemo, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ApiError } from "../../api/http";
import type { Surface } from "../../api/surface";
import type { AttemptDetail, Series } from "../../api/types";
import type { Loaded } from "../../api/use_request";
import { formatLimit, formatNumber, formatQuantity, formatSigned } from "../../base/format";
import { Card, ErrorNotice, Loading } from "../../widgets/basics";
import { DeviationLegend, TissueLegend } from "../../widgets/tooth/legend";
import type { AngledView, ColorMode, PointMm } from "../../widgets/tooth/scene";
import { tissuesPresent, tissueTitle, workpiece } from "../../widgets/tooth/tissue";
import { type LookHandle, type ToothPin, type ToothSource, ToothView } from "../../widgets/tooth/tooth_view";
import { CompareChoice, OtherTooth } from "./compare_tooth";
import { type Compared, type DeviationSummary, outlook, summariseDeviation } from "./deviation";
import type { Mark } from "./moments";
import { PlaybackBar } from "./playback_bar";
import { type ToothChoices, ToothTools } from "./tooth_tools";
import type { PlaybackControl } from "./use_playback";

const kPathSeconds = 3;                         // of the tool's way drawn behind it

interface Props {
  readonly surface: Loaded<Surface>;            // where nothing can be played back
  readonly toleranceMm: number;                 // of the rubric
  readonly control: PlaybackControl;
  readonly series: Series | undefined;
  readonly cursor: number | undefined;          // undefined: no tool is drawn
  readonly marks: readonly Mark[];
  readonly chosen: string | undefined;          // id of a remark
  readonly point: PointMm | undefined;          // for the remark that is being written
  readonly look: LookHandle;
  readonly client: Client;
  readonly attempt: AttemptDetail;
  readonly staff: boolean;
  readonly timeS: number | undefined;
  readonly onMark: (mark: Mark) => void;
  readonly onPoint: ((point: PointMm) => void) | undefined;
  readonly onRetry: () => void;
}

export function ToothPanel({ surface, onRetry, ...rest }: Props) {
  const { playback } = rest.control;
  const played = playback.state.state === "ready";
  const waits = playback.state.state === "loading" || (!played && surface.state === "loading");
  return (
    <Card className="tooth-card" title={playback.showing ? "During the attempt" : "After the attempt"}>
      {waits && <Loading what="the picture" />}
      {!played && !waits && surface.state === "failed" && <SurfaceError error={surface.error} onRetry={onRetry} />}
      {played ? <PlayedTooth {...rest} /> : !waits && surface.state === "ready" && <StillTooth surface={surface.value} {...rest} />}
    </Card>
  );
}

type Shown = Omit<Props, "surface" | "onRetry">;

function PlayedTooth(props: Shown) {
  const { playback } = props.control;
  const { deviation } = playback;
  const tissues = useMemo(() => [...playback.tissues].sort((a, b) => a - b), [playback, playback.tissues.size]);
  const missing = deviation.state === "loading" ? "The deviation from the reference is being loaded."
    : deviation.state === "failed" ? `The deviation from the reference could not be loaded: ${deviation.error.message}` : kNothingToCompare;
  return <LoadedTooth {...props} model={{ film: playback }} compared={deviation.state === "ready" ? deviation.compared : undefined} tissues={tissues} missing={missing} busy={!playback.drawn} />;
}

function StillTooth({ surface, ...props }: Shown & { readonly surface: Surface }) {
  const tissues = useMemo(() => tissuesPresent(surface.tissue), [surface]);
  return <LoadedTooth {...props} model={{ surface }} compared={surface.deviationMm === undefined ? undefined : surface} tissues={tissues} missing={kNothingToCompare} busy={false} />;
}

const kNothingToCompare = "No deviation to show: the attempt has no reference, or its score is not released yet.";

interface Loaded3d extends Shown {
  readonly model: ToothSource;
  readonly compared: Compared | undefined;
  readonly tissues: readonly number[];
  readonly missing: string;                     // why there is no deviation
  readonly busy: boolean;
}

function LoadedTooth({ model, compared, tissues, missing, busy, toleranceMm, control, series, cursor, marks, chosen, point, look, onMark, onPoint, client, attempt, staff, timeS }: Loaded3d) {
  const summary = useMemo(() => compared === undefined ? undefined : summariseDeviation(compared, toleranceMm), [compared, toleranceMm]);
  const { cut } = control.playback;
  const angled = useMemo((): AngledView => ({ ...outlook(compared, summary), cavity: cut }), [compared, summary?.sides[0]?.side, cut]);
  const [beside, setBeside] = useState<string>();   // id of the attempt that is shown beside it
  const otherLook = useMemo((): LookHandle => ({ begin: undefined, now: undefined }), []);
  look.moved = beside === undefined ? undefined : (moved) => otherLook.set?.(moved);
  const shownS = control.clock?.timeOf(control.playback.position) ?? timeS ?? 0;
  const [choices, setChoices] = useState<ToothChoices>({ mode: "deviation", section: undefined, follow: false });
  // On the way there is nothing to compare with: a reference is of a finished tooth.
  const during = control.playback.showing;
  const mode: ColorMode = summary === undefined || during ? "tissue" : choices.mode;
  const path = useMemo(() => pathBefore(series, cursor), [series, cursor]);
  const pins = useMemo(() => pinsOf(marks, chosen, point), [marks, chosen, point]);
  return (
    <>
      <PlaybackBar control={control} />
      <div class={beside === undefined ? "teeth" : "teeth two"}>
      <ToothView model={model} busy={busy} mode={mode} label={during ? "Picture during the attempt" : pictureText(summary, tissues)} angled={angled} tool={during ? undefined : path.at(-1)} path={path} pins={pins} look={look} onPick={onPoint}
                 onPin={(key) => { const mark = marks.find((item) => item.annotation.id === key); if (mark !== undefined) onMark(mark); }} section={choices.section} follow={choices.follow}>
        <ToothTools choices={choices} onChoices={setChoices} compared={summary !== undefined && !during} played={"film" in model}>
          {series !== undefined && <CompareChoice client={client} attempt={attempt} staff={staff} chosen={beside} onChoose={setBeside} />}
        </ToothTools>
      </ToothView>
      {beside !== undefined && series !== undefined && <OtherTooth key={beside} client={client} id={beside} series={series} timeS={shownS} choices={choices} look={otherLook} />}
      </div>
      {mode === "deviation" ? <DeviationLegend /> : <TissueLegend tissues={tissues} />}
      {summary === undefined ? <p class="hint">{missing}</p> : <DeviationTable summary={summary} />}
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
