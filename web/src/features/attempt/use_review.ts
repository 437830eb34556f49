import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Anatomy } from "../../api/tooth_number";
import type { Annotation, AttemptDetail, Series } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { scoreOf } from "../../api/worded";
import { draftOf } from "../../base/drafts";
import { momentOf, momentQuery } from "../../base/moment_link";
import { stoppedEarly } from "../../widgets/attempt_state";
import type { LookHandle } from "../../widgets/tooth/tooth_view";
import { seriesEndS, stepAt } from "./clock";
import type { FaultPlace } from "./deductions";
import { type Mark, marksOf, stepOfTick } from "./moments";
import { nextMark, spansOf } from "./spans";
import { kToothFirstMs } from "./playback";
import { usePlayback } from "./use_playback";

const kBeyondS = 0.05; // an address has hundredths; less is rounding
const kNoRemarks: readonly Annotation[] = [];

// The attempt under review, and the reviewer.
export interface Reviewed {
  readonly client: Client;
  readonly attempt: AttemptDetail;
  readonly personId: string; // the reviewer
  readonly teacher: boolean;
  readonly alone: boolean; // there is no server, and no other attempt
  readonly anatomy: Anatomy | undefined; // undefined: not known yet
  readonly rescored: number; // how often since the page was opened
}

// What the page's keys do with the picture of the tooth, and with the plots.
interface PlotKeys {
  target?: () => void; // each shows it and hides it again
  reference?: () => void;
  measure?: () => void;
  more?: () => void; // shows and hides the second plot
  zoom?: (direction: -1 | 0 | 1) => void; // 0: all
}

// The draft's name of a remark to an attempt.
export const remarkTo = (id: string) => `remark ${id}`;

export type Review = ReturnType<typeof useReview>;

// The review of a scored attempt: its data, and the one moment and place that picture, plots and
// remarks share. Every panel reads and moves it.
export function useReview(reviewed: Reviewed) {
  const { client, attempt, teacher, rescored } = reviewed;
  const { id } = attempt;
  const removed = attempt.recording_removed_ms > 0;
  // A release changes the answers that a student gets, a new score those for everybody.
  const key = `${id} ${teacher || attempt.released} ${attempt.computed_score} ${attempt.reference?.attempt_id} ${rescored}`;
  const score = useRequest(key, (signal) => scoreOf(client, id, signal));
  const [begun, setBegun] = useState(false); // something of the tooth was drawn: it comes first
  const series = useRequest(removed || !begun ? undefined : key, (signal) => client.series(id, signal));
  const remarks = useRequest(begun ? key : undefined, (signal) =>
    client.all("/attempts/{id}/annotations", { id, signal }),
  );
  const scored = score.loaded.state === "ready" ? score.loaded.value : undefined;
  const recorded = series.loaded.state === "ready" ? series.loaded.value : undefined;
  const said = remarks.loaded.state === "ready" ? remarks.loaded.value : kNoRemarks;
  const draft = useMemo(() => draftOf(remarkTo(id)), [id]);
  const moment = useMoment(client, removed ? undefined : id, key, recorded, draft?.seconds);
  const { momentS, control, setTimeS, setCursor } = moment;
  const there = removed || moment.drawn || control?.playback.state.state === "failed";
  useEffect(() => {
    if (there) setBegun(true);
    // Where it takes long the rest need not wait.
    const timer = setTimeout(() => setBegun(true), kToothFirstMs);
    return () => clearTimeout(timer);
  }, [there]);

  const plots = useMemo((): PlotKeys => ({}), []);
  const [noMark, setNoMark] = useState(false);
  const [chosen, setChosen] = useState<string>();
  const [point, setPoint] = useState(draft?.point);
  const picture = useRef<HTMLDivElement>(null);
  const [cameFrom, setCameFrom] = useState<HTMLElement>(); // what was pressed to see a place
  const marks = useMemo(() => (recorded === undefined ? [] : marksOf(recorded, said)), [recorded, said]);
  const clock = control?.playback.whole === true ? control.clock : undefined;
  const spans = useMemo(
    () => (recorded === undefined ? [] : spansOf(recorded, clock?.gaps ?? [], scored?.deductions ?? [])),
    [recorded, clock, scored],
  );
  // Shows the time or place of an item that was clicked anywhere on the page.
  const go = (step: number | undefined, held = false) => {
    if (step !== undefined) setCursor(step, held);
    picture.current?.scrollIntoView({ block: "nearest" });
  };
  const place = useRef<(fault: FaultPlace) => void>(undefined);
  place.current = (fault) => {
    setCameFrom(document.activeElement instanceof HTMLElement ? document.activeElement : undefined);
    const [x, y, z] = fault.position_mm;
    if (x !== undefined && y !== undefined && z !== undefined) {
      setPoint([x, y, z]);
      moment.look.near?.([x, y, z]);
    }
    // The deviation is of the finished tooth: it stays in view, and the tool is marked where it was.
    const deviation = control?.playback.deviation;
    const compared =
      deviation?.state === "loading" || (deviation?.state === "ready" && deviation.compared !== undefined);
    go(recorded !== undefined && fault.stroke_count > 0 ? stepOfTick(recorded, fault.first_tick) : undefined, compared);
  };
  const showPlace = useMemo(() => (fault: FaultPlace) => place.current?.(fault), []);
  return {
    ...reviewed,
    ...moment,
    showPlace, // the same at every moment
    key,
    begun,
    removed,
    score,
    scored,
    series,
    recorded,
    remarks,
    plots,
    marks,
    spans,
    done: scored === undefined ? undefined : stoppedEarly(scored), // percent of the work, where it was stopped early
    annotates: attempt.may.includes("annotate"),
    noMark, // somebody asked for the next one, and there is none
    chosen, // id of a remark
    draft, // of a remark, as it was when the attempt was opened
    point,
    setPoint, // clicked on the tooth, for the next remark
    picture,
    choose: (mark: Mark) => {
      setChosen(mark.annotation.id);
      go(mark.step);
    },
    back:
      cameFrom === undefined
        ? undefined
        : () => {
            setCameFrom(undefined);
            cameFrom.scrollIntoView({ block: "center" });
            cameFrom.focus({ preventScroll: true });
          },
    toMark: (direction: -1 | 1) => {
      const at = nextMark(spans, momentS, direction);
      setNoMark(at === undefined && scored !== undefined);
      if (at !== undefined) setTimeS(at);
    },
  };
}

// The moment, the playback that shows it, and the picture without one. `id` undefined: there is no
// recording. `beginS`: where to begin, unless the address names a moment.
function useMoment(
  client: Client,
  id: string | undefined,
  key: string,
  recorded: Series | undefined,
  beginS: number | undefined,
) {
  const [timeS, setTimeS] = useState<number>(); // undefined until first moved: the end
  const asked = useMemo(() => {
    const { seconds, look } = momentOf(new URLSearchParams(window.location.search));
    return { seconds: seconds ?? beginS, look };
  }, [beginS]);
  const askedDone = useRef(false); // later data no longer changes the moment
  const [drawn, setDrawn] = useState(false); // something of the tooth
  const seen = useRef<() => void>(undefined); // tells the playback that its tooth was drawn
  const look = useMemo((): LookHandle => {
    const drawn = () => {
      setDrawn(true);
      seen.current?.();
    };
    return { begin: asked.look, now: undefined, drawn };
  }, [asked]);
  const [heldS, setHeldS] = useState<number>(); // the tooth stays at its end there
  const control = usePlayback(client, id, key, timeS, setTimeS, heldS);
  seen.current = () => control?.playback.seen();
  const { state } = control?.playback.state ?? { state: "loading" };
  // Some megabytes more, and nothing moves.
  const still = state === "waiting" || state === "failed";
  const surface = useRequest(still ? key : undefined, (signal) =>
    client.bytes("/attempts/{id}/surface", { id: id ?? "", signal }),
  );
  const endS = control?.clock?.endS ?? (recorded === undefined ? undefined : seriesEndS(recorded));
  const settled = control?.playback.whole === true || still;
  // A link may name the moment; it is opened as soon as the recording is there.
  useEffect(() => {
    if (endS !== undefined && asked.seconds !== undefined && !askedDone.current)
      setTimeS(Math.min(asked.seconds, endS));
    if (settled) askedDone.current = true;
  }, [endS, asked, settled]);
  const momentS = timeS ?? endS ?? 0;
  const { loop, clock } = control ?? {};
  return {
    control,
    surface,
    look,
    drawn,
    endS,
    momentS,
    setTimeS,
    moved: timeS !== undefined,
    cursor: recorded === undefined ? 0 : stepAt(recorded, momentS), // the step that the moment lies in
    setCursor: (step: number, held = false) => {
      if (recorded === undefined) return;
      const at = step >= recorded.t_s.length - 1 ? endS : recorded.t_s[step];
      setHeldS(held ? at : undefined);
      setTimeS(at);
    },
    // A to B, seconds
    range:
      loop?.to === undefined || clock === undefined
        ? undefined
        : ([clock.timeOf(loop.from), clock.timeOf(loop.to)] as const),
    // What the address asks for, where that is after the end
    beyondS:
      endS !== undefined && asked.seconds !== undefined && asked.seconds > endS + kBeyondS ? asked.seconds : undefined,
    // The address of this moment, looked at as now
    link: () => new URL(momentQuery({ seconds: momentS, look: look.now?.() }), window.location.href).href,
  };
}
