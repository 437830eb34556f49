import type { Look } from "../base/moment_link";
import type { Result } from "../base/result";
import { canvasAhead } from "./canvas_ahead";
import type {
  CameraPreset,
  FilmAsk,
  FilmTold,
  ModelFormat,
  Plane,
  PointMm,
  ScreenAsk,
  ScreenState,
  ScreenTold,
  ScreenWish,
  StudioAsk,
  StudioTold,
  SurfacePoint,
  ToothPlan,
} from "./messages";
import type { Drawer } from "./start_worker";

// The page's end of the worker that reads and draws teeth (studio.ts): the page's thread hands over bytes, a canvas
// and wishes, and never meshes or draws.

// A worker, or what stands for one.
export interface StudioPort {
  postMessage(asked: StudioAsk, transfer: Transferable[]): void;
  onmessage: ((event: { readonly data: StudioTold }) => void) | null;
  onerror: ((event: { readonly message?: string }) => void) | null;
  terminate(): void;
}

export class StudioLink {
  private next = 0;
  private readonly films = new Map<number, (told: FilmTold) => void>();
  private readonly screens = new Map<number, (told: ScreenTold) => void>();
  lost = false; // nothing answers any more

  // `ahead`: the canvas that the worker has already.
  constructor(
    private readonly port: StudioPort,
    private ahead: HTMLCanvasElement | undefined,
  ) {
    port.onmessage = ({ data }) => {
      if ("film" in data) this.films.get(data.film)?.(data.message);
      else this.screens.get(data.screen)?.(data.message);
    };
    port.onerror = () => {
      this.lost = true;
      const message = "what reads it could not be loaded or has stopped: load the page again";
      for (const told of [...this.films.values()]) told({ told: "failed", message });
      for (const told of [...this.screens.values()]) told({ told: "lost", stopped: false });
    };
  }

  film(told: (told: Exclude<FilmTold, { told: "model" | "interior" | "plans" }>) => void): FilmLink {
    const film = this.next++;
    const link = new FilmLink(
      film,
      (message, transfer = []) => this.port.postMessage({ film, message }, transfer),
      () => this.films.delete(film),
    );
    this.films.set(film, (message) => {
      if (message.told === "model") link.gave(message.model);
      else if (message.told === "interior") link.opened(message.tissues);
      else if (message.told === "plans") link.drew(message.plans);
      else told(message);
    });
    return link;
  }

  // Throws where the browser has no such canvas.
  screen(
    film: FilmLink,
    state: ScreenState,
    look: Look | undefined,
    told: (told: Exclude<ScreenTold, { told: "picked" | "picture" | "profile" }>) => void,
    wished: () => void, // another picture, which comes as soon as it is drawn
  ): readonly [ScreenLink, HTMLCanvasElement] {
    const canvas = this.ahead ?? canvasAhead(this.port);
    this.ahead = undefined;
    const screen = this.next++;
    const link = new ScreenLink(
      (message, transfer = []) => this.port.postMessage({ screen, message }, transfer),
      () => this.screens.delete(screen),
      wished,
    );
    this.screens.set(screen, (message) => {
      if (message.told === "picked") link.picked(message.id, message.point);
      else if (message.told === "profile") link.profiled(message.id, message.heightMm);
      else if (message.told === "picture") link.pictured(message.id, message.png);
      else told(message);
    });
    this.port.postMessage({ screen, message: { ask: "open", film: film.number, state, look } }, []);
    return [link, canvas];
  }
}

export class FilmLink {
  private readonly waiting: ((model: Result<ArrayBuffer, string>) => void)[] = [];
  opened: (tissues: Result<readonly number[], string>) => void = () => undefined;
  drew: (plans: Result<readonly ToothPlan[], string>) => void = () => undefined;

  constructor(
    readonly number: number,
    private readonly ask: (message: FilmAsk, transfer?: Transferable[]) => void,
    private readonly ended: () => void,
  ) {}

  // The bytes are handed over: whoever gave them has them no longer.
  bytes(bytes: ArrayBuffer): void {
    this.ask({ ask: "bytes", bytes }, [bytes]);
  }
  surface(bytes: ArrayBuffer): void {
    this.ask({ ask: "surface", bytes }, [bytes]);
  }
  deviation(bytes: ArrayBuffer): void {
    this.ask({ ask: "deviation", bytes }, [bytes]);
  }
  // The latest wish counts. Where that part is not here yet it is fulfilled when it is.
  seek(frames: number): void {
    this.ask({ ask: "seek", frames });
  }
  // The tooth as it is shown, as STL (stl.ts) or GLB (glb.ts).
  model(as: ModelFormat): Promise<Result<ArrayBuffer, string>> {
    this.ask({ ask: "model", as });
    return new Promise((resolve) => this.waiting.push(resolve));
  }
  gave(model: Result<ArrayBuffer, string>): void {
    this.waiting.shift()?.(model);
  }
  // The start tooth, whose tissues fill sections from then on. Resolves to those that are in it.
  interior(bytes: ArrayBuffer): Promise<Result<readonly number[], string>> {
    this.ask({ ask: "interior", bytes }, [bytes]);
    return new Promise((resolve) => {
      this.opened = resolve;
    });
  }
  // Of a surface, which is not kept; one question at a time.
  plans(bytes: ArrayBuffer, planes: readonly Plane[]): Promise<Result<readonly ToothPlan[], string>> {
    this.ask({ ask: "plans", bytes, planes }, [bytes]);
    return new Promise((resolve) => {
      this.drew = resolve;
    });
  }
  // Afterwards nothing is reported.
  close(): void {
    this.ask({ ask: "close" });
    this.ended();
  }
}

export class ScreenLink {
  wishes = 0; // for another picture, so far
  private next = 0;
  private readonly profiles = new Map<number, (heightMm: Float32Array) => void>();
  private readonly pictures = new Map<number, (png: Blob | undefined) => void>();
  private readonly picks = new Map<number, (point: SurfacePoint | undefined) => void>();

  constructor(
    private readonly ask: (message: ScreenAsk, transfer?: Transferable[]) => void,
    private readonly ended: () => void,
    private readonly wished: () => void,
  ) {}

  private wish(message: ScreenWish): void {
    this.wishes++;
    this.ask(message);
    this.wished();
  }

  set(state: Partial<ScreenState>): void {
    this.wish({ ask: "set", state });
  }
  resize(width: number, height: number, ratio: number): void {
    this.wish({ ask: "resize", width, height, ratio });
  }
  view(preset: CameraPreset): void {
    this.wish({ ask: "view", preset });
  }
  near(pointMm: PointMm): void {
    this.wish({ ask: "near", pointMm });
  }
  middle(pointMm: PointMm): void {
    this.wish({ ask: "middle", pointMm });
  }
  reset(): void {
    this.wish({ ask: "reset" });
  }
  look(look: Look): void {
    this.wish({ ask: "look", look });
  }
  // `more`: the motion goes on.
  rotate(azimuthRad: number, polarRad: number, more = false): void {
    this.wish({ ask: "rotate", azimuthRad, polarRad, more });
  }
  zoom(factor: number): void {
    this.wish({ ask: "zoom", factor });
  }
  // Of half the picture's height: where one looks from then on.
  pan(right: number, up: number): void {
    this.wish({ ask: "pan", right, up });
  }
  redraw(): void {
    this.wish({ ask: "redraw" });
  }
  settle(): void {
    this.ask({ ask: "settle" });
  }
  // What is under a point of the picture, in CSS pixels from its top left corner.
  pick(x: number, y: number): Promise<SurfacePoint | undefined> {
    const id = this.next++;
    this.ask({ ask: "pick", id, x, y });
    return new Promise((resolve) => this.picks.set(id, resolve));
  }
  picked(id: number, point: SurfacePoint | undefined): void {
    this.picks.get(id)?.(point);
    this.picks.delete(id);
  }
  // Of the surface above the line between two points, mm towards the eye; NaN: there is none.
  profile(from: PointMm, to: PointMm, samples: number): Promise<Float32Array> {
    const id = this.next++;
    this.ask({ ask: "profile", id, from, to, samples });
    return new Promise((resolve) => this.profiles.set(id, resolve));
  }
  profiled(id: number, heightMm: Float32Array): void {
    this.profiles.get(id)?.(heightMm);
    this.profiles.delete(id);
  }
  // PNG from that side, drawn in full; undefined: it could not be made.
  picture(preset: CameraPreset): Promise<Blob | undefined> {
    const id = this.next++;
    this.ask({ ask: "picture", id, preset });
    return new Promise((resolve) => this.pictures.set(id, resolve));
  }
  pictured(id: number, png: Blob | undefined): void {
    this.pictures.get(id)?.(png);
    this.pictures.delete(id);
  }
  close(): void {
    this.ask({ ask: "close" });
    this.ended();
  }
}

let newWorker: () => Drawer = () => {
  throw new Error("nothing starts workers here");
};
// What starts the worker; the page says it before anything is drawn.
export function drawTeethWith(start: () => Drawer): void {
  newWorker = start;
}

let only: StudioLink | undefined;

// The one of this page, which starts its worker. Throws where the browser refuses workers.
export function studio(): StudioLink {
  if (only === undefined || only.lost) {
    const { worker, canvas } = newWorker();
    only = new StudioLink(worker as unknown as StudioPort, canvas);
  }
  return only;
}
