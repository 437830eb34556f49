import type { ComponentChildren } from "preact";
import { useEffect, useId, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Anatomy } from "../../api/tooth_number";
import { Disposables } from "../../base/disposables";
import { FrameScheduler } from "../../base/frame";
import { formatQuantity } from "../../base/format";
import type { Look } from "../../base/moment_link";
import { say } from "../../base/words";
import { type FilmLink, type ScreenLink, studio } from "../../tooth/link";
import type {
  AngledView,
  Body,
  CameraPreset,
  ColorMode,
  PointMm,
  ScreenState,
  ScreenTold,
  SectionPlane,
  SurfacePoint,
  ToothLines,
} from "../../tooth/messages";
import { Loading } from "../basics";
import { Button } from "../button";
import { type Drawn, kAxes, kDirections, place } from "./overlay";
import { tissueTitle } from "./tissue";
import { turnedBy } from "./turning";

// A numbered mark at a point of the tooth.
export interface ToothPin {
  readonly key: string;
  readonly text: string; // short: drawn in the mark
  readonly label: string;
  readonly pointMm: PointMm;
  readonly chosen: boolean;
}

// Lets the owner of a view read and set its camera, and say where to begin.
export interface LookHandle {
  readonly begin: Look | undefined;
  now: (() => Look) | undefined; // set while a picture is there
  set?: ((look: Look) => void) | undefined; // the same
  near?: ((point: PointMm) => void) | undefined; // the same: shows a place
  stream?: (() => MediaStream) | undefined; // the same: the picture as it moves, for a video
  profile?: ((from: PointMm, to: PointMm, samples: number) => Promise<Float32Array>) | undefined; // the same: ScreenLink
  pictureFrom?: ((preset: CameraPreset) => Promise<Blob | undefined>) | undefined; // the same: PNG, drawn in full
  drawn?: () => void; // called after something of it was drawn
  moved?: ((look: Look, caughtUp: boolean) => void) | undefined; // called after it was drawn; caughtUp: no wish is on its way
}

export type ToothPoint = Pick<ToothPin, "text" | "pointMm">; // the same, to look at

interface Props {
  readonly film: FilmLink;
  readonly anatomy: Anatomy | undefined; // undefined: not known yet, and its sides are not named
  readonly mode: ColorMode;
  readonly label: string; // what the picture shows, for who cannot see it
  readonly name?: string | undefined; // in the picture, where there are two
  readonly angled: AngledView; // what the view begins with
  readonly tool?: PointMm | undefined;
  readonly path?: readonly PointMm[];
  readonly burAt?: number | undefined; // ScreenState
  readonly lines?: ToothLines | undefined;
  readonly forceN?: PointMm | undefined; // on the hand, scene frame
  readonly section?: SectionPlane | undefined;
  readonly target?: Body | undefined; // outlined in the section
  readonly ghost?: FilmLink | undefined; // another tooth over it, translucent
  readonly led?: boolean; // from where to look is chosen elsewhere
  readonly follow?: boolean; // the camera stays at the bur
  readonly children?: ComponentChildren; // more to choose, beside where to look from
  readonly instead?: ComponentChildren; // shown where the browser draws no picture
  readonly busy?: boolean; // more of it comes soon
  readonly pins?: readonly ToothPin[];
  readonly points?: readonly ToothPoint[];
  readonly look?: LookHandle | undefined;
  readonly onPin?: (key: string) => void;
  readonly onPick?: ((point: SurfacePoint) => void) | undefined; // a click on the tooth that does not turn it
}

// Where there is little room the first letters stand for the word.
const kPresets: ReadonlyArray<readonly [CameraPreset, number]> = [
  ["cavity", 6],
  ["angled", 6],
  ["occlusal", 4],
  ["buccal", 3],
  ["lingual", 4],
  ["mesial", 3],
  ["distal", 4],
  ["apical", 4],
];
const kKeyStepRad = Math.PI / 24;
const kKeyPan = 0.1; // of half the picture's height, with Shift
const kKeyZoom = 1.15;
// To the right and down.
const kArrows: Readonly<Record<string, readonly [number, number]>> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};
const kVideoHz = 30;
const kSameMm = 0.005; // shown as no deviation: rounds to zero
const kClickMovesPx = 4; // more is a turn of the tooth
const kNoPins: readonly ToothPin[] = [];
const kNoPoints: readonly ToothPoint[] = [];
const kMinForceN = 0.05; // less is no contact
const kNoPath: readonly PointMm[] = [];

// Starts what draws teeth, for a page that will show one soon.
export function prepareTooth(): void {
  try {
    studio();
  } catch {
    // Told when a tooth is to be shown.
  }
}

// A tooth to turn: by mouse, fingers (turning.ts), keys, and the preset buttons.
export function ToothView({
  film,
  anatomy,
  mode,
  label,
  name,
  angled,
  busy = false,
  section,
  target,
  ghost,
  led = false,
  follow = false,
  children,
  instead,
  tool,
  path = kNoPath,
  burAt,
  forceN,
  lines,
  pins = kNoPins,
  points = kNoPoints,
  look,
  onPin,
  onPick,
}: Props) {
  const newton = forceN === undefined ? 0 : Math.hypot(...forceN);
  const felt = newton >= kMinForceN ? forceN : undefined;
  const keys = useId();
  const frame = useRef<HTMLDivElement>(null);
  const [problem, setProblem] = useState("");
  const [drawn, setDrawn] = useState(false); // something of it
  const [screen, setScreen] = useState<ScreenLink>();
  const [under, setUnder] = useState<SurfacePoint>();
  const state: ScreenState = {
    mode,
    angled,
    anatomy,
    tool,
    path,
    burAt,
    forceN: felt,
    lines,
    section,
    target,
    ghost: ghost?.number,
    follow,
  };
  const latest = useRef({ state, anatomy, look });
  latest.current = { state, anatomy, look };
  const sent = useRef(state);

  // Before the page is painted: the worker has the canvas when its size is known.
  useLayoutEffect(() => {
    const element = frame.current;
    if (element === null) return undefined;
    const cleanup = new Disposables();
    sent.current = latest.current.state;
    const shown = (told: Drawn, caughtUp: boolean) => {
      place(element, told, latest.current.anatomy);
      setDrawn(true);
      const handle = latest.current.look;
      if (handle === undefined) return;
      handle.now = () => told.look;
      handle.drawn?.();
      handle.moved?.(told.look, caughtUp);
    };
    try {
      const opened = openScreen(element, film, sent.current, latest.current.look?.begin, cleanup, shown, setProblem);
      const handle = latest.current.look;
      if (handle !== undefined) {
        handle.set = (wanted) => opened.look(wanted);
        handle.near = (point) => opened.near(point);
        handle.profile = (from, to, samples) => opened.profile(from, to, samples);
        handle.pictureFrom = (preset) => opened.picture(preset);
        handle.stream = () => (element.querySelector("canvas") as HTMLCanvasElement).captureStream(kVideoHz);
        cleanup.add(() => {
          handle.now = handle.set = handle.near = handle.stream = handle.profile = handle.pictureFrom = undefined;
        });
      }
      setScreen(opened);
    } catch {
      setProblem(say("tooth.no_webgl"));
    }
    return () => {
      setScreen(undefined);
      setDrawn(false);
      cleanup.dispose();
    };
  }, [film]);

  // Before the page is painted: the worker draws meanwhile.
  useLayoutEffect(() => {
    if (screen === undefined) return;
    const change = changeOf(sent.current, state);
    sent.current = state;
    if (change !== undefined) screen.set(change);
  });
  useEffect(() => screen?.redraw(), [pins, points, screen]);
  // Looked up once a frame, however often the pointer moves.
  const over = useRef<Place | undefined>(undefined);
  const looking = useMemo(
    () =>
      new FrameScheduler(() => {
        const asked = over.current;
        if (asked === undefined || screen === undefined) return setUnder(undefined);
        void screen.pick(...asked).then((point) => {
          if (over.current === asked) setUnder(point);
        });
      }),
    [screen],
  );
  useEffect(() => () => looking.cancel(), [looking]);
  const hover = (place: Place | undefined) => {
    over.current = place;
    looking.request();
  };
  const pressed = useRef<readonly [number, number]>([0, 0]);
  const pick = (event: MouseEvent) => {
    const [x, y] = pressed.current;
    if (event.detail > 1) return; // the second click looks at the place
    if (onPick === undefined || Math.hypot(event.clientX - x, event.clientY - y) > kClickMovesPx) return;
    if (!(event.target instanceof HTMLCanvasElement)) return;
    const box = event.target.getBoundingClientRect();
    void screen?.pick(event.clientX - box.left, event.clientY - box.top).then((hit) => {
      if (hit !== undefined) onPick(hit);
    });
  };
  // By keys: where the cross is.
  const pickMiddle = () => {
    const element = frame.current;
    if (onPick === undefined || element === null) return;
    void screen?.pick(element.clientWidth / 2, element.clientHeight / 2).then((hit) => {
      if (hit !== undefined) onPick(hit);
    });
  };
  const ready = drawn && problem === "";

  return (
    <div class="tooth">
      <div
        class={onPick === undefined ? "tooth-frame" : "tooth-frame picking"}
        ref={frame}
        // biome-ignore lint/a11y/noNoninteractiveTabindex: an application takes keys
        tabIndex={0}
        role="application"
        aria-roledescription={say("tooth.view")}
        aria-label={label}
        aria-describedby={keys}
        aria-busy={(!drawn || busy) && problem === ""}
        onKeyDown={(event) =>
          event.key === "Enter" && event.target === event.currentTarget ? pickMiddle() : handleKey(event, screen)
        }
        onPointerDown={(event) => {
          pressed.current = [event.clientX, event.clientY];
        }}
        onClick={pick}
        onPointerMove={(event) => hover(placeOf(event))}
        onPointerLeave={() => hover(undefined)}
      >
        {kDirections.map(([name]) => (
          <span key={name} class="tooth-direction" aria-hidden="true">
            {say(`side.${name}`)}
          </span>
        ))}
        {points.map((point, i) => (
          <span key={i} class="tooth-pin" aria-hidden="true" data-point={point.pointMm.join(" ")}>
            {point.text}
          </span>
        ))}
        {pins.map((pin) => (
          <button
            key={pin.key}
            type="button"
            class={pin.chosen ? "tooth-pin chosen" : "tooth-pin"}
            aria-label={pin.label}
            aria-pressed={pin.chosen}
            data-point={pin.pointMm.join(" ")}
            onClick={() => onPin?.(pin.key)}
          >
            {pin.text}
          </button>
        ))}
        <p class="tooth-scale" aria-hidden="true" />
        <svg class="tooth-axes" viewBox="-1.7 -1.7 3.4 3.4" aria-hidden="true">
          {kAxes.map(([name]) => (
            <g key={name}>
              <line x2="0" y2="0" />
              <text>{say(`view.${name}`).slice(0, 1)}</text>
            </g>
          ))}
        </svg>
        {name !== undefined && <p class="tooth-name">{name}</p>}
        {!drawn && problem === "" && (
          <div class="tooth-problem">
            <Loading what={say("loading.picture")} />
          </div>
        )}
        {problem !== "" && (
          <div class="tooth-problem">
            <p>{problem}</p>
            {instead}
          </div>
        )}
        {felt !== undefined && (
          <p class="tooth-force" title={say("tooth.force_arrow")}>
            <span class="swatch force" />
            {say("tooth.force", { force: formatQuantity(newton, "N") })}
          </p>
        )}
        {under !== undefined && (
          <p class="tooth-under" aria-hidden="true">
            {pointText(under)}
          </p>
        )}
      </div>
      <div class="tooth-tools">
        {!led && (
          <div class="button-row" role="group" aria-label={say("tooth.look_from")}>
            {kPresets.map(([preset, short]) => {
              const title = say(`view.${preset}`);
              return preset === "cavity" && angled.cavity === undefined ? null : (
                <Button
                  key={preset}
                  kind="small"
                  busy={!ready && problem === ""}
                  blocked={
                    problem !== ""
                      ? problem
                      : anatomy === undefined && (preset === "mesial" || preset === "distal")
                        ? say("view.no_anatomy")
                        : undefined
                  }
                  tip={title}
                  onClick={() => screen?.view(preset)}
                >
                  {title.slice(0, short)}
                  <span class="preset-rest">{title.slice(short)}</span>
                </Button>
              );
            })}
            <Button
              kind="small"
              busy={!ready && problem === ""}
              blocked={problem === "" ? undefined : problem}
              tip={say("view.reset")}
              onClick={() => screen?.reset()}
            >
              <span aria-hidden="true">⟲</span>
              <span class="hidden">{say("view.reset")}</span>
            </Button>
          </div>
        )}
        {problem === "" ? (
          children
        ) : (
          <fieldset class="tooth-off" disabled title={problem}>
            {children}
          </fieldset>
        )}
        <p class="hint" id={keys}>
          {onPick === undefined ? say("tooth.drag") : say("tooth.drag_and_enter")}
        </p>
      </div>
    </div>
  );
}

type Lost = Extract<ScreenTold, { told: "lost" }>;

// Throws where the browser has no such canvas or worker.
function openScreen(
  element: HTMLElement,
  film: FilmLink,
  state: ScreenState,
  look: Look | undefined,
  cleanup: Disposables,
  shown: (told: Drawn, caughtUp: boolean) => void,
  report: (problem: string) => void,
): ScreenLink {
  // For tests: how it is drawn; nothing: a wish is not in the picture yet.
  const mark = (effort = "") => {
    canvas.dataset["drawn"] = effort;
  };
  const take = (told: Drawn | Lost) => {
    if (told.told === "lost") return report(say(told.stopped ? "tooth.driver_stopped" : "tooth.no_webgl"));
    const caughtUp = told.wishes === screen.wishes;
    if (caughtUp) mark(told.effort);
    shown(told, caughtUp);
  };
  const [screen, canvas] = studio().screen(film, state, look, take, () => mark());
  canvas.setAttribute("aria-hidden", "true");
  element.prepend(canvas);
  cleanup.add(() => canvas.remove());
  cleanup.add(() => screen.close());
  const observer = new ResizeObserver(() =>
    screen.resize(element.clientWidth, element.clientHeight, window.devicePixelRatio),
  );
  observer.observe(element);
  cleanup.add(() => observer.disconnect());
  cleanup.add(
    turnedBy(
      canvas,
      {
        turn: (azimuthRad, polarRad) => screen.rotate(azimuthRad, polarRad, true),
        pan: (right, up) => screen.pan(right, up),
        zoom: (factor) => screen.zoom(factor),
        lookAt: (x, y) =>
          void screen.pick(x, y).then((point) => {
            if (point !== undefined) screen.middle(point.planeMm ?? point.pointMm);
          }),
      },
      // Wheel zoom takes over the page's own scrolling, so only while the view has the focus.
      () => document.activeElement === element,
    ),
  );
  cleanup.listen(window, "beforeprint", () => screen.settle()); // paper gets what was drawn last
  return screen;
}

// What has changed; undefined: nothing.
function changeOf(was: ScreenState, now: ScreenState): Partial<ScreenState> | undefined {
  const keys = (Object.keys(now) as (keyof ScreenState)[]).filter((key) => was[key] !== now[key]);
  if (keys.length === 0) return undefined;
  const change = Object.fromEntries(keys.map((key) => [key, now[key]]));
  // They are one picture.
  return "tool" in change || "path" in change ? { ...change, tool: now.tool, path: now.path } : change;
}

function handleKey(event: KeyboardEvent, screen: ScreenLink | undefined): void {
  if (screen === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
  const arrow = kArrows[event.key];
  if (arrow !== undefined) {
    const [right, down] = arrow;
    if (event.shiftKey) screen.pan(kKeyPan * right, -kKeyPan * down);
    else screen.rotate(kKeyStepRad * right, kKeyStepRad * down);
    event.preventDefault();
    return;
  }
  switch (event.key) {
    case "+":
    case "=":
      screen.zoom(1 / kKeyZoom);
      break;
    case "-":
      screen.zoom(kKeyZoom);
      break;
    case "0":
      screen.reset();
      break;
    default:
      return;
  }
  event.preventDefault();
}

type Place = readonly [number, number]; // CSS pixels from the picture's top left corner

// Of a pointer that hovers; undefined for one that turns the tooth, or cannot hover.
function placeOf(event: PointerEvent): Place | undefined {
  if (event.buttons !== 0 || event.pointerType === "touch") return undefined;
  const box = (event.currentTarget as HTMLElement).getBoundingClientRect();
  return [event.clientX - box.left, event.clientY - box.top];
}

function pointText({ tissue, deviationMm }: SurfacePoint): string {
  if (tissue === undefined) return say("tooth.cut");
  if (deviationMm === undefined) return tissueTitle(tissue);
  if (Number.isNaN(deviationMm)) return say("tooth.untouched", { tissue: tissueTitle(tissue) });
  const size = Math.abs(deviationMm);
  if (size < kSameMm) return say("tooth.as_reference", { tissue: tissueTitle(tissue) });
  return deviationMm > 0
    ? say("tooth.more_removed", { tissue: tissueTitle(tissue), size: formatQuantity(size, "mm") })
    : say("tooth.less_removed", { tissue: tissueTitle(tissue), size: formatQuantity(size, "mm") });
}
