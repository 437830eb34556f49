import { useEffect, useMemo, useState } from "preact/hooks";
import type { Series } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { type Look, sameLook } from "../../base/moment_link";
import { keepTrying } from "../../base/keep_trying";
import { formatLimit, formatNumber, formatQuantity, formatSigned } from "../../base/format";
import { say } from "../../base/words";
import { Card, ErrorNotice, Folded, Waits } from "../../widgets/basics";
import { DeviationLegend, TissueLegend } from "../../widgets/tooth/legend";
import type { FilmLink } from "../../tooth/link";
import type { AngledView, ColorMode, Compared, PointMm, SurfacePoint } from "../../tooth/messages";
import { useStillFilm } from "../../widgets/tooth/still_film";
import { tissueTitle, workpiece } from "../../widgets/tooth/tissue";
import { type LookHandle, type ToothPin, type ToothPoint, ToothView } from "../../widgets/tooth/tooth_view";
import { attemptName, CompareChoice, comparable, referenceName } from "./compare_tooth";
import type { Placement } from "./compare";
import { type DeviationSummary, kLeewayMm, outlook, summariseDeviation } from "./deviation";
import { joinedLines, measuredLines, nameOfPoint, withPoint } from "./measure";
import type { Mark } from "./moments";
import { openFilm } from "./open_film";
import { PlaybackBar } from "./playback_bar";
import type { ToothChoices } from "./tooth_choices";
import { Closer, ToothTools } from "./tooth_tools";
import { useMoves } from "./use_moves";
import { useOther } from "./use_other";
import type { PlaybackControl } from "./use_playback";
import type { Review } from "./use_review";

const kLookMs = 1000;
const kPathSeconds = 3; // of the tool's way drawn behind it

export function ToothPanel({ review }: { readonly review: Review }) {
  const { control, surface } = review;
  useMoves(control?.playback);
  if (control === undefined) return null;
  const { playback } = control;
  const { state } = playback.state;
  const played = state === "ready" || state === "loading";
  return (
    <Card className="tooth-card" title={playback.showing ? say("tooth_card.during") : say("tooth_card.after")}>
      {played && playback.film !== undefined ? (
        <PlayedTooth review={review} control={control} film={playback.film} />
      ) : surface.loaded.state === "failed" ? (
        <ErrorNotice
          title={say("exercise_page.picture_failed")}
          message={surface.loaded.error.message}
          onRetry={surface.reload}
        />
      ) : (
        <StillTooth
          surface={surface.loaded.state === "ready" ? surface.loaded.value : undefined}
          review={review}
          control={control}
        />
      )}
    </Card>
  );
}

interface Shown {
  readonly review: Review;
  readonly control: PlaybackControl;
}

function PlayedTooth(props: Shown & { readonly film: FilmLink }) {
  const { playback } = props.control;
  const { deviation } = playback;
  const missing =
    deviation.state === "loading"
      ? say("tooth_card.deviation_loading")
      : deviation.state === "failed"
        ? say("tooth_card.deviation_failed", { reason: deviation.error.message })
        : say("tooth_card.nothing");
  return (
    <LoadedTooth
      {...props}
      played
      compared={deviation.state === "ready" ? deviation.compared : undefined}
      tissues={playback.tissues}
      missing={missing}
      busy={!playback.drawn}
    />
  );
}

// `surface`: undefined while it is loading.
function StillTooth({ surface, ...props }: Shown & { readonly surface: ArrayBuffer | undefined }) {
  const still = useStillFilm(surface);
  if (still.state !== "ready")
    return <Waits loaded={still} what={say("loading.picture")} failed={say("exercise_page.picture_failed")} />;
  const { film, tissues, compared } = still.value;
  return (
    <LoadedTooth
      {...props}
      film={film}
      played={false}
      compared={compared}
      tissues={tissues}
      missing={say("tooth_card.nothing")}
      busy={false}
    />
  );
}

interface Loaded3d extends Shown {
  readonly film: FilmLink;
  readonly played: boolean; // it has moments
  readonly compared: Compared | undefined;
  readonly tissues: readonly number[];
  readonly missing: string; // why there is no deviation
  readonly busy: boolean;
}

function LoadedTooth({ film, played, compared, tissues, missing, busy, review, control }: Loaded3d) {
  const { client, attempt, anatomy, recorded: series, marks, chosen, point, look } = review;
  const cursor = series !== undefined && review.moved ? review.cursor : undefined; // undefined: no tool is drawn
  const mesial = anatomy?.mesial;
  const summary = useMemo(
    () => (compared === undefined ? undefined : summariseDeviation(compared, mesial)),
    [compared, mesial],
  );
  const { cut, start } = control.playback.head ?? {};
  const worst = summary?.sides[0]?.side;
  const angled = useMemo(
    (): AngledView => ({ ...outlook(compared, worst, mesial), cavity: cut }),
    [compared, worst, mesial, cut],
  );
  const [compareWith, setCompareWith] = useState<string>(); // id of another attempt
  const [otherName, setOtherName] = useState("");
  const [placement, setPlacement] = useState<Placement>("side");
  const otherLook = useMemo(
    (): LookHandle => ({ begin: look.now?.(), now: undefined }),
    [look, compareWith, placement],
  );
  useEffect(
    () => (compareWith === undefined ? undefined : togetherFrom(look, otherLook)),
    [look, otherLook, compareWith],
  );
  const shownS = control.clock?.timeOf(control.playback.position) ?? review.momentS;
  const other = useOther(client, compareWith, series, shownS);
  const beside = placement === "side" ? other : undefined;
  const besideFilm = beside?.ready ? beside.playback.film : undefined;
  const ghost = placement === "top" && other?.ready ? other.playback.film : undefined;
  const [choices, setChoices] = useState<ToothChoices>({
    mode: "deviation",
    section: undefined,
    follow: false,
    target: false,
  });
  // Asked for when somebody wants to see it, and so is what draws it.
  const { section } = choices;
  const aims = choices.target || section !== undefined;
  const { loaded: exercise } = useRequest(aims ? attempt.exercise.id : undefined, (signal) =>
    client.tagged("GET", "/exercises/{id}", { id: attempt.exercise.id, signal }),
  );
  const [draw, setDraw] = useState<typeof import("../../widgets/target_lines")>();
  useEffect(() => {
    if (!aims) return undefined;
    const shown = new AbortController();
    void keepTrying(() => import("../../widgets/target_lines"), shown.signal).then(setDraw);
    return () => shown.abort();
  }, [aims]);
  const wanted = exercise.state === "ready" ? exercise.value.value.target : undefined;
  const lines = useMemo(
    () => (choices.target && wanted !== undefined ? draw?.linesOfTarget(wanted) : undefined),
    [choices.target, wanted, draw],
  );
  const body = useMemo(() => (wanted === undefined ? undefined : draw?.bodyOfTarget(wanted)), [wanted, draw]);
  const [measured, setMeasured] = useState<readonly PointMm[]>(); // undefined: nobody measures
  const drawnLines = useMemo(
    () => joinedLines(lines, measured === undefined ? undefined : measuredLines(measured)),
    [lines, measured],
  );
  const reference = review.alone ? undefined : comparable(attempt, review.teacher);
  review.plots.target = () => setChoices({ ...choices, target: !choices.target });
  review.plots.measure = () => setMeasured(measured === undefined ? [] : undefined);
  review.plots.reference = () => {
    if (reference === undefined) return;
    setCompareWith(compareWith === undefined ? reference.attempt_id : undefined);
    setOtherName(referenceName(reference));
    setPlacement("top");
  };
  // On the way there is nothing to compare with: a reference is of a finished tooth. Two teeth side by side have the
  // same kind of colours.
  const during = control.playback.showing;
  const { playback: theirs } = beside ?? {};
  const alike = theirs === undefined || (theirs.deviation.state === "ready" && !theirs.showing);
  const coloured = summary !== undefined && !during && alike;
  const mode: ColorMode = coloured ? choices.mode : "tissue";
  // What lies inside shines through the surface once somebody looks at it for a while.
  const { whole } = control.playback;
  useEffect(() => {
    if (mode !== "tissue" || !played || !whole || start === undefined) return undefined;
    const timer = setTimeout(() => {
      for (const one of [film, besideFilm]) if (one !== undefined) void openFilm(client, one, start);
    }, kLookMs);
    return () => clearTimeout(timer);
  }, [mode, played, whole, start, client, film, besideFilm, shownS]);
  const after = useMemo(() => pictureText(summary, tissues), [summary, tissues]);
  const pictured = during ? say("tooth_card.picture_during") : after;
  const label = ghost === undefined ? pictured : `${pictured} ${say("compare.on_top")}`;
  const path = useMemo(() => pathBefore(series, cursor), [series, cursor]);
  const forceN = cursor === undefined ? undefined : (series?.force_vector_n[cursor] as PointMm | undefined);
  const pins = useMemo(() => pinsOf(marks, chosen, point), [marks, chosen, point]);
  const points = useMemo(
    () => measured?.map((pointMm, i): ToothPoint => ({ text: nameOfPoint(i), pointMm })),
    [measured],
  );
  const pick =
    measured !== undefined
      ? ({ planeMm, pointMm }: SurfacePoint) => setMeasured(withPoint(measured, planeMm ?? pointMm))
      : review.annotates
        ? ({ pointMm }: SurfacePoint) => review.setPoint(pointMm)
        : undefined;
  return (
    <>
      <PlaybackBar control={control} />
      <div class={other === undefined ? "teeth" : beside === undefined ? "teeth compared" : "teeth compared two"}>
        <ToothView
          film={film}
          anatomy={anatomy}
          busy={busy}
          mode={mode}
          label={label}
          name={beside === undefined ? undefined : attemptName(attempt)}
          angled={angled}
          tool={during ? undefined : path.at(-1)}
          path={path}
          burAt={control.held}
          forceN={forceN}
          lines={drawnLines}
          pins={pins}
          {...(points === undefined ? {} : { points })}
          look={look}
          onPick={pick}
          onPin={(key) => {
            const mark = marks.find((item) => item.annotation.id === key);
            if (mark !== undefined) review.choose(mark);
          }}
          section={section}
          target={body}
          ghost={ghost}
          follow={choices.follow}
          instead={<Instead review={review} />}
        >
          <ToothTools
            choices={choices}
            onChoices={setChoices}
            compared={coloured}
            played={played}
            measures={measured !== undefined}
            onMeasures={(on) => setMeasured(on ? [] : undefined)}
          >
            {series !== undefined && !review.alone && (
              <CompareChoice
                client={client}
                attempt={attempt}
                staff={review.teacher}
                chosen={compareWith}
                onChoose={(id, name) => {
                  setCompareWith(id);
                  setOtherName(name);
                }}
              />
            )}
          </ToothTools>
        </ToothView>
        {beside !== undefined && (
          <Closer
            key={compareWith}
            show={({ OtherTooth }) => (
              <OtherTooth
                name={otherName}
                other={beside}
                anatomy={anatomy}
                choices={choices}
                mode={mode}
                angled={angled}
                look={otherLook}
              />
            )}
          />
        )}
      </div>
      {other !== undefined && (
        <Closer
          show={({ CompareBar }) => (
            <CompareBar other={other} placement={placement} onPlacement={setPlacement} cut={!!section} />
          )}
        />
      )}
      {measured !== undefined && (
        <Closer
          show={({ Measured }) => <Measured points={measured} look={look} frames={control.playback.position} />}
        />
      )}
      {section !== undefined ? (
        <Closer
          show={({ SectionLegend }) => (
            <SectionLegend
              open={openFilm}
              client={client}
              film={film}
              beside={besideFilm}
              start={start}
              tissues={tissues}
              deviation={mode === "deviation"}
              target={body !== undefined}
              other={ghost !== undefined}
              reference={reference === undefined || compareWith !== undefined ? undefined : review.plots.reference}
            />
          )}
        />
      ) : mode === "deviation" ? (
        <DeviationLegend />
      ) : (
        <TissueLegend tissues={tissues} />
      )}
      {summary === undefined ? (
        <p class="hint">{missing}</p>
      ) : (
        <Folded
          title={say("tooth_card.numbers")}
          content={() => (
            <Closer
              show={({ DeviationFigures }) => <DeviationFigures summary={summary} said={deviationText(summary)} />}
            />
          )}
        />
      )}
    </>
  );
}

// Five still views, once it is known that this browser draws no picture.
function Instead({ review: { client, attempt, anatomy } }: { readonly review: Review }) {
  const { loaded } = useRequest(`still ${attempt.id}`, (signal) =>
    client.bytes("/attempts/{id}/surface", { id: attempt.id, signal }),
  );
  if (loaded.state !== "ready" || anatomy === undefined) return null;
  return <Closer show={({ StillViews }) => <StillViews bytes={loaded.value} anatomy={anatomy} />} />;
}

// Whichever of two pictures is turned, the other one follows.
function togetherFrom(one: LookHandle, other: LookHandle): () => void {
  let last: Look | undefined;
  let leader: LookHandle | undefined;
  const lead = (from: LookHandle, to: LookHandle) => (moved: Look, caughtUp: boolean) => {
    if (last !== undefined && sameLook(last, moved)) return;
    // One that follows and lags behind would lead back to where both were: they would chase each other for ever.
    if (!caughtUp && leader !== from) return;
    [leader, last] = [from, moved];
    to.set?.(moved);
  };
  one.moved = lead(one, other);
  other.moved = lead(other, one);
  return () => {
    one.moved = other.moved = undefined;
  };
}

const kNewPin = "new";

function pinsOf(marks: readonly Mark[], chosen: string | undefined, point: PointMm | undefined): ToothPin[] {
  const pins = marks.flatMap(({ annotation, number }): ToothPin[] => {
    const [x, y, z] = annotation.point_um ?? [];
    if (x === undefined || y === undefined || z === undefined) return [];
    return [
      {
        key: annotation.id,
        text: String(number),
        label: say("tooth_card.remark", { number: String(number) }),
        pointMm: [x / 1000, y / 1000, z / 1000],
        chosen: annotation.id === chosen,
      },
    ];
  });
  return point === undefined
    ? pins
    : [...pins, { key: kNewPin, text: "+", label: say("tooth_card.new_point"), pointMm: point, chosen: true }];
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
  const told = {
    within: percent(summary.withinShare),
    tolerance: formatLimit(kLeewayMm, "mm"),
    over: percent(summary.overShare),
    under: percent(summary.underShare),
    p95: formatQuantity(summary.p95Mm, "mm"),
  };
  return worst === undefined
    ? say("tooth_card.deviation", told)
    : say("tooth_card.deviation_worst", {
        ...told,
        side: say(`cavity_side.${worst.side}`),
        mean: formatSigned(worst.meanMm),
      });
}

function pictureText(summary: DeviationSummary | undefined, tissues: readonly number[]): string {
  const tooth = say(`tooth_card.shows_${workpiece(tissues)}`, { tissues: tissues.map(tissueTitle).join(", ") });
  return summary === undefined ? tooth : `${tooth} ${deviationText(summary)}`;
}
