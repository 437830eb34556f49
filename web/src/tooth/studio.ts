import { Film, type FilmOptions } from "./film";
import type { ScreenAsk, ScreenState, ScreenTold, ScreenWish, StudioAsk, StudioTold } from "./messages";
import { kSameMm } from "./scene/ghost";
import { Paint } from "./scene/paint";
import { ToothScene } from "./scene/scene";

// The worker's films and the screens that show them, by the numbers that the page gave them.

type Tell = (told: StudioTold, transfer?: readonly Transferable[]) => void;

export class Studio {
  private readonly films = new Map<number, Film>();
  private readonly screens = new Map<number, Screen>();
  private ahead: Paint | undefined;

  constructor(
    private readonly tell: Tell,
    private readonly options: FilmOptions,
  ) {}

  take(asked: StudioAsk): void {
    if ("film" in asked) {
      void this.film(asked.film).take(asked.message);
      if (asked.message.ask === "close") this.films.delete(asked.film);
      return;
    }
    if ("ahead" in asked) {
      this.ahead = paintOn(asked.ahead);
      this.ahead?.prepare();
      return;
    }
    const { screen, message } = asked;
    if (message.ask === "open") {
      const film = this.film(message.film);
      const opened = new Screen(
        message,
        this.ahead,
        film,
        (number) => this.film(number),
        (told) => this.tell({ screen, message: told }),
      );
      this.ahead = undefined;
      this.screens.set(screen, opened);
      return;
    }
    this.screens.get(screen)?.take(message);
    if (message.ask === "close") this.screens.delete(screen);
  }

  // Made when it is first named: a screen may be there before any of its tooth.
  private film(number: number): Film {
    const known = this.films.get(number);
    if (known !== undefined) return known;
    const made = new Film((message, transfer) => this.tell({ film: number, message }, transfer), this.options);
    this.films.set(number, made);
    return made;
  }
}

// Undefined: there is no WebGL 2.
function paintOn(canvas: OffscreenCanvas): Paint | undefined {
  try {
    return new Paint(canvas, kSameMm);
  } catch {
    return undefined;
  }
}

type Open = Extract<ScreenAsk, { ask: "open" }>;

class Screen {
  private readonly scene: ToothScene | undefined;
  private readonly detach: () => void = () => undefined;

  constructor(
    { state, look }: Open,
    paint: Paint | undefined,
    private readonly film: Film,
    private readonly film_: (number: number) => Film,
    private readonly tell: (told: ScreenTold) => void,
  ) {
    if (paint === undefined) {
      tell({ told: "lost", stopped: false });
      return;
    }
    this.scene = new ToothScene(paint, state, tell, () => void film.rest());
    paint.canvas.addEventListener("webglcontextlost", () => tell({ told: "lost", stopped: true }));
    this.set(state);
    if (look !== undefined) this.scene.look(look);
    this.detach = film.attach(this.scene);
  }

  private set(state: Partial<ScreenState>): void {
    this.scene?.set(state, this.film_);
    if ("burAt" in state) this.scene?.setGlass(this.film.burAt(state.burAt));
  }

  take(asked: Exclude<ScreenAsk, Open>): void {
    const { scene } = this;
    if (scene === undefined) return;
    switch (asked.ask) {
      case "settle":
        return scene.settle();
      case "pick":
        return this.tell({ told: "picked", id: asked.id, point: scene.pick(asked.x, asked.y) });
      case "picture":
        return void scene
          .picture(asked.preset)
          .catch(() => undefined)
          .then((png) => this.tell({ told: "picture", id: asked.id, png }));
      case "profile":
        return this.tell({
          told: "profile",
          id: asked.id,
          heightMm: scene.profile(asked.from, asked.to, asked.samples),
        });
      case "close":
        this.detach();
        return scene.dispose();
      default:
        scene.wishes++;
        return this.fulfil(scene, asked);
    }
  }
  private fulfil(scene: ToothScene, asked: ScreenWish): void {
    switch (asked.ask) {
      case "set":
        return this.set(asked.state);
      case "resize":
        return scene.resize(asked.width, asked.height, asked.ratio);
      case "view":
        return scene.sight.view(asked.preset);
      case "near":
        return scene.sight.near(asked.pointMm);
      case "middle":
        return scene.sight.follow(asked.pointMm);
      case "reset":
        return scene.sight.reset();
      case "look":
        return scene.look(asked.look);
      case "rotate":
        scene.sight.rotate(asked.azimuthRad, asked.polarRad);
        return asked.more ? scene.moved() : scene.redraw();
      case "zoom":
        return scene.sight.zoom(asked.factor);
      case "pan":
        return scene.sight.pan(asked.right, asked.up);
      case "redraw":
        return scene.redraw();
    }
  }
}
