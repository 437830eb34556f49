import type { ComponentChildren } from "preact";
import { useEffect, useId, useMemo, useRef, useState } from "preact/hooks";
import type { Surface } from "../../api/surface";
import { type Anatomy, toScene } from "../../api/tooth_number";
import { Disposables } from "../../base/disposables";
import { FrameScheduler } from "../../base/frame";
import { formatQuantity } from "../../base/format";
import type { Look } from "../../base/moment_link";
import { say } from "../../base/words";
import type { AngledView, CameraPreset, ColorMode, PointMm, SurfacePoint, ToothModel, ToothScene } from "./scene";
import type { Detail, Film } from "./film";
import type { ToothLines } from "./lines";
import type { SectionPlane } from "./section";
import { tissueTitle } from "./tissue";

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
  now: (() => Look) | undefined; // set while the picture is there
  set?: ((look: Look) => void) | undefined; // the same
  near?: ((point: PointMm) => void) | undefined; // the same: shows a place
  moved?: ((look: Look) => void) | undefined; // called after it was drawn
}

// A fixed surface, or a tooth in playback.
export type ToothSource = { readonly surface: Surface } | { readonly film: Film };

interface Props {
  readonly model: ToothSource;
  readonly anatomy: Anatomy | undefined; // undefined: not known yet, and its sides are not named
  readonly mode: ColorMode;
  readonly label: string; // what the picture shows, for who cannot see it
  readonly name?: string | undefined; // in the picture, where there are two
  readonly angled: AngledView; // what the view begins with
  readonly tool?: PointMm | undefined;
  readonly path?: readonly PointMm[];
  readonly lines?: ToothLines | undefined;
  readonly forceN?: PointMm | undefined; // on the hand, scene frame
  readonly section?: SectionPlane | undefined;
  readonly ghost?: Film | undefined; // another tooth over it, translucent
  readonly led?: boolean; // from where to look is chosen elsewhere
  readonly follow?: boolean; // the camera stays at the bur
  readonly children?: ComponentChildren; // more to choose, beside where to look from
  readonly busy?: boolean; // more of it comes soon
  readonly pins?: readonly ToothPin[];
  readonly look?: LookHandle | undefined;
  readonly onPin?: (key: string) => void;
  readonly onPick?: ((point: PointMm) => void) | undefined; // a click on the tooth that does not turn it
}

type Side = "mesial" | "distal" | "buccal" | "lingual";

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
// Mesial, buccal, occlusal.
const kDirections: ReadonlyArray<readonly [Side, PointMm]> = [
  ["mesial", [1, 0, 0]],
  ["distal", [-1, 0, 0]],
  ["buccal", [0, 1, 0]],
  ["lingual", [0, -1, 0]],
];
const kKeyStepRad = Math.PI / 24;
const kKeyZoom = 1.15;
const kSameMm = 0.005; // shown as no deviation: rounds to zero
const kLabelMarginPx = [38, 18] as const; // half a label and a little air
const kToolsPx = 66; // beside the tooth, where a wide picture has its buttons
const kWidePx = 560;
const kClickMovesPx = 4; // more is a turn of the tooth
const kNoPins: readonly ToothPin[] = [];
const kBesideTooth = 1.05; // of the radius of the ball around it
const kLeastForceN = 0.05; // less is no contact
const kLabelMinShare = 0.12; // of the picture's height: shorter points at the viewer

// Fetches the drawing code for a page that will show a tooth soon. Nobody waits for it.
export function prepareTooth(): void {
  import("./scene").catch(() => undefined); // told when a tooth is to be shown
}

// A tooth to turn: by mouse, finger, arrow keys, + and −, and the preset buttons.
export function ToothView({
  model,
  anatomy,
  mode,
  label,
  name,
  angled,
  busy = false,
  section,
  ghost,
  led = false,
  follow = false,
  children,
  tool,
  path,
  forceN,
  lines,
  pins = kNoPins,
  look,
  onPin,
  onPick,
}: Props) {
  const film = "film" in model ? model.film : undefined;
  const source = "film" in model ? model.film : model.surface;
  const newton = forceN === undefined ? 0 : Math.hypot(...forceN);
  const felt = newton >= kLeastForceN ? forceN : undefined;
  const keys = useId();
  const frame = useRef<HTMLDivElement>(null);
  const scene = useRef<ToothScene | undefined>(undefined);
  const shownAnatomy = useRef(anatomy); // read as it is drawn
  shownAnatomy.current = anatomy;
  const [problem, setProblem] = useState("");
  const [ready, setReady] = useState(false);
  const [under, setUnder] = useState<SurfacePoint>();
  const begin = useRef({ model, angled, look });
  begin.current = { model, angled, look };

  useEffect(() => {
    const element = frame.current;
    if (element === null) return undefined;
    const { model, angled, look } = begin.current;
    const cleanup = new Disposables();
    let abandoned = false;
    cleanup.add(() => {
      abandoned = true;
    });
    import("./scene")
      .then((module) => {
        if (abandoned) return;
        scene.current = openScene(
          module.ToothScene,
          element,
          "film" in model ? { extent: model.film.extent } : model,
          angled,
          look,
          shownAnatomy,
          () => ("film" in model ? model.film.detail : "fine"),
          cleanup,
          setProblem,
        );
        const opened = scene.current;
        if (look !== undefined) {
          look.now = () => opened.look();
          look.set = (wanted) => opened.setLook(wanted);
          look.near = (point) => opened.near(point);
          if (look.begin !== undefined) opened.setLook(look.begin);
        }
        cleanup.add(() => {
          scene.current = undefined;
          if (look !== undefined) look.now = look.set = look.near = undefined;
        });
        setReady(true);
      })
      .catch(() => setProblem(say("tooth.no_webgl")));
    return () => {
      setReady(false);
      cleanup.dispose();
    };
  }, [source]);

  useEffect(() => scene.current?.setMode(mode), [mode, ready]);
  useEffect(() => scene.current?.setTool(tool, path ?? []), [tool, path, ready]);
  useEffect(() => scene.current?.setForce(felt), [felt, ready]);
  useEffect(() => scene.current?.setLines(lines), [lines, ready]);
  useEffect(() => {
    if (anatomy !== undefined) scene.current?.setAnatomy(anatomy);
  }, [anatomy, ready]);
  useEffect(() => scene.current?.setAngled(angled), [angled, ready]);
  useEffect(() => (ready && scene.current !== undefined ? film?.attach(scene.current) : undefined), [film, ready]);
  useEffect(() => scene.current?.setSection(section), [section, ready]);
  useEffect(() => scene.current?.setGhost(ghost), [ghost, ready]);
  useEffect(() => scene.current?.setFollow(follow), [follow, ready]);
  const detail = film?.detail;
  useEffect(() => scene.current?.redraw(), [pins, detail, ready]);
  // Looked up once a frame, however often the pointer moves.
  const over = useRef<Place | undefined>(undefined);
  const looking = useMemo(
    () =>
      new FrameScheduler(() => setUnder(over.current === undefined ? undefined : scene.current?.pick(...over.current))),
    [],
  );
  useEffect(() => () => looking.cancel(), [looking]);
  const hover = (place: Place | undefined) => {
    over.current = place;
    looking.request();
  };
  const pressed = useRef<readonly [number, number]>([0, 0]);
  const pick = (event: MouseEvent) => {
    const [x, y] = pressed.current;
    if (onPick === undefined || Math.hypot(event.clientX - x, event.clientY - y) > kClickMovesPx) return;
    if (!(event.target instanceof HTMLCanvasElement)) return;
    const box = event.target.getBoundingClientRect();
    const hit = scene.current?.pick(event.clientX - box.left, event.clientY - box.top);
    if (hit !== undefined) onPick(hit.pointMm);
  };

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
        aria-busy={(!ready || busy) && problem === ""}
        onKeyDown={(event) => handleKey(event, scene.current)}
        onFocus={() => scene.current?.setZoomEnabled(true)}
        onBlur={() => scene.current?.setZoomEnabled(false)}
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
        {name !== undefined && <p class="tooth-name">{name}</p>}
        {problem !== "" && <p class="tooth-problem">{problem}</p>}
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
                <button
                  key={preset}
                  type="button"
                  class="button small"
                  disabled={!ready || (anatomy === undefined && (preset === "mesial" || preset === "distal"))}
                  title={title}
                  onClick={() => scene.current?.view(preset)}
                >
                  {title.slice(0, short)}
                  <span class="preset-rest">{title.slice(short)}</span>
                </button>
              );
            })}
          </div>
        )}
        {children}
        <p class="hint" id={keys}>
          {say("tooth.drag")}
        </p>
      </div>
    </div>
  );
}

function openScene(
  Scene: typeof ToothScene,
  element: HTMLElement,
  model: ToothModel,
  angled: AngledView,
  look: LookHandle | undefined,
  anatomy: { readonly current: Anatomy | undefined },
  detail: () => Detail,
  cleanup: Disposables,
  report: (problem: string) => void,
): ToothScene {
  const canvas = document.createElement("canvas");
  canvas.setAttribute("aria-hidden", "true");
  const labels = [...element.querySelectorAll<HTMLElement>(".tooth-direction")];
  const scene = new Scene(canvas, model, angled, (project, centre, radius) => {
    placeLabels(labels, element, anatomy.current, project, centre, radius);
    placePins(element, project);
    element.dataset["tooth"] = detail();
    if (look?.now !== undefined) look.moved?.(look.now());
  });
  element.prepend(canvas);
  cleanup.add(() => canvas.remove());
  cleanup.add(() => scene.dispose());
  cleanup.listen(canvas, "webglcontextlost", () => report(say("tooth.driver_stopped")));
  const observer = new ResizeObserver(() => scene.resize(element.clientWidth, element.clientHeight));
  observer.observe(element);
  cleanup.add(() => observer.disconnect());
  return scene;
}

// Names of the sides at the edge of the picture, in the direction in which they lie; hidden where
// they lie towards the viewer or away.
function placeLabels(
  labels: readonly HTMLElement[],
  frame: HTMLElement,
  anatomy: Anatomy | undefined,
  project: (point: PointMm) => PointMm,
  centre: PointMm,
  radius: number,
): void {
  const [cx, cy] = project(centre);
  kDirections.forEach(([, direction], i) => {
    const label = labels[i];
    if (label === undefined) return;
    const [x, y, z] = anatomy === undefined ? [0, 0, 0] : toScene(anatomy, direction);
    const at = project([centre[0] + x * radius, centre[1] + y * radius, centre[2] + z * radius]);
    const [dx, dy] = [at[0] - cx, at[1] - cy];
    const half = [frame.clientWidth / 2, frame.clientHeight / 2] as const;
    // At the edge of the picture, or beside the tooth where that is nearer.
    const toEdge = Math.min(
      kBesideTooth,
      (half[0] - kLabelMarginPx[0] - (frame.clientWidth > kWidePx ? kToolsPx : 0)) / Math.abs(dx),
      (half[1] - kLabelMarginPx[1]) / Math.abs(dy),
    );
    const visible = Math.hypot(dx, dy) > kLabelMinShare * frame.clientHeight && Number.isFinite(toEdge);
    label.style.visibility = visible ? "visible" : "hidden";
    if (visible)
      label.style.transform = `translate(-50%, -50%) translate(${half[0] + dx * toEdge}px, ${half[1] + dy * toEdge}px)`;
  });
}

function placePins(frame: HTMLElement, project: (point: PointMm) => PointMm): void {
  for (const pin of frame.querySelectorAll<HTMLElement>(".tooth-pin")) {
    const [x = 0, y = 0, z = 0] = (pin.dataset["point"] ?? "").split(" ").map(Number);
    const [left, top] = project([x, y, z]);
    pin.style.transform = `translate(-50%, -50%) translate(${left.toFixed(1)}px, ${top.toFixed(1)}px)`;
  }
}

function handleKey(event: KeyboardEvent, scene: ToothScene | undefined): void {
  if (scene === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
  switch (event.key) {
    case "ArrowLeft":
      scene.rotate(-kKeyStepRad, 0);
      break;
    case "ArrowRight":
      scene.rotate(kKeyStepRad, 0);
      break;
    case "ArrowUp":
      scene.rotate(0, -kKeyStepRad);
      break;
    case "ArrowDown":
      scene.rotate(0, kKeyStepRad);
      break;
    case "+":
    case "=":
      scene.zoom(1 / kKeyZoom);
      break;
    case "-":
      scene.zoom(kKeyZoom);
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
  if (deviationMm === undefined) return tissueTitle(tissue);
  if (Number.isNaN(deviationMm)) return say("tooth.untouched", { tissue: tissueTitle(tissue) });
  const size = Math.abs(deviationMm);
  if (size < kSameMm) return say("tooth.as_reference", { tissue: tissueTitle(tissue) });
  return deviationMm > 0
    ? say("tooth.more_removed", { tissue: tissueTitle(tissue), size: formatQuantity(size, "mm") })
    : say("tooth.less_removed", { tissue: tissueTitle(tissue), size: formatQuantity(size, "mm") });
}
