import type { Anatomy } from "../api/tooth_number";
import type { Look } from "../base/moment_link";
import type { Result } from "../base/result";
import type { Extent, PointMm } from "./places";
import type { Head } from "./timeline";

// What the page and the worker that draws its teeth tell each other. A film is a tooth: the moments of an attempt, or
// a surface that stays as it is. A screen is a picture of one. The page numbers both.

export type { Extent, PointMm };

// Vertices that were compared with the reference. NaN: it was not.
export interface Compared {
  readonly positionMm: Float32Array; // (n x 3)
  readonly normal: Int8Array; // (n x 4), x y z 0, /127, outward
  readonly deviationMm: Float32Array; // (n), + = more removed than in the reference
}

// How much of a tooth is there.
export type Detail = "none" | "coarse" | "fine";

export type ModelFormat = "stl" | "glb";

export type Axis = 0 | 1 | 2;

// Two axes of the scene: which points right in a picture, and which up.
export interface Plane {
  readonly right: Axis;
  readonly up: Axis;
  readonly against?: readonly [boolean, boolean]; // the scene's other way along each
}

// A tooth seen straight along an axis of its scene (tooth_plan.ts).
export interface ToothPlan {
  readonly shade: Uint8Array; // rows from the top; 0: no tooth there, else how bright
  readonly frontMm: Float32Array; // how far towards the eye its surface is; -Infinity: no tooth there
  readonly width: number;
  readonly height: number;
  readonly cellMm: number;
  // Of the picture's left lower corner, along the plane's `right` and `up`.
  readonly lowMm: readonly [number, number];
}

export type FilmAsk =
  | { readonly ask: "bytes"; readonly bytes: ArrayBuffer } // more of a timeline's file
  | { readonly ask: "surface"; readonly bytes: ArrayBuffer } // instead of one (surface.ts)
  | { readonly ask: "deviation"; readonly bytes: ArrayBuffer } // after the file's last segment
  | { readonly ask: "seek"; readonly frames: number } // the latest one counts
  | { readonly ask: "interior"; readonly bytes: ArrayBuffer } // what is inside (interior.ts)
  | { readonly ask: "model"; readonly as: ModelFormat } // of what is shown
  | { readonly ask: "plans"; readonly bytes: ArrayBuffer; readonly planes: readonly Plane[] } // of a surface, not kept
  | { readonly ask: "close" };

export type FilmTold =
  | { readonly told: "head"; readonly head: Head }
  | { readonly told: "gaps"; readonly segment: number; readonly ticks: Uint32Array } // before each frame's end
  | { readonly told: "ready" } // the end can be shown
  | { readonly told: "whole" } // and every other moment
  | { readonly told: "detail"; readonly detail: Detail; readonly extent: Extent; readonly tissues: readonly number[] }
  | { readonly told: "compared"; readonly compared: Result<Compared | undefined, string> } // undefined: with nothing
  | { readonly told: "shown"; readonly frames: number; readonly tissues: readonly number[] } // on all its screens
  | { readonly told: "model"; readonly model: Result<ArrayBuffer, string> }
  | { readonly told: "interior"; readonly tissues: Result<readonly number[], string> } // all that are in it
  | { readonly told: "plans"; readonly plans: Result<readonly ToothPlan[], string> } // in the order that was asked for
  | { readonly told: "failed"; readonly message: string }; // the file is damaged there

export type ColorMode = "tissue" | "deviation";
export type CameraPreset = "angled" | "cavity" | "occlusal" | "buccal" | "lingual" | "mesial" | "distal" | "apical";
export type Effort = "quick" | "full";

// The view into the cavity: direction and target.
export interface AngledView {
  readonly direction: PointMm;
  readonly centre: PointMm | undefined; // undefined: the middle of the tooth
  readonly closer?: number; // share of the distance at which the whole tooth is in view; .8 without
  readonly cavity?: Extent | undefined; // what "cavity" frames; undefined: as "angled"
}

// A plane that hides what is in front of it.
export interface SectionPlane {
  readonly across: "x" | "y" | "z" | "view"; // what the plane stands across: an axis of the scene, or the line of sight
  readonly share: number; // 0: through the middle of the cavity; −1 and 1: past the tooth's ends
  readonly flipped: boolean; // hides the other side
}

// Ways through the picture of a tooth, drawn over it.
export interface ToothLines {
  readonly solid: readonly (readonly PointMm[])[];
  readonly faint: readonly (readonly PointMm[])[]; // dashed
}

// A body that a section cuts: triangles, counter-clockwise seen from outside.
export interface Body {
  readonly positionMm: Float32Array;
  readonly triangle: Uint16Array;
}

export interface SurfacePoint {
  readonly tissue: number | undefined; // undefined: on the plane of a section, and not known
  readonly deviationMm: number | undefined; // NaN: untouched; undefined: nothing to compare with
  readonly pointMm: PointMm; // where exactly
  readonly planeMm: PointMm | undefined; // the same place of the picture on the plane of a section, where there is one
}

// What a picture shows beside its tooth.
export interface ScreenState {
  readonly mode: ColorMode;
  readonly angled: AngledView; // what it begins with
  readonly anatomy: Anatomy | undefined; // undefined: not known yet
  readonly tool: PointMm | undefined;
  readonly path: readonly PointMm[];
  readonly burAt: number | undefined; // frames: over the tooth at its end, the bur as it was then, like glass
  readonly forceN: PointMm | undefined; // on the hand
  readonly lines: ToothLines | undefined;
  readonly section: SectionPlane | undefined;
  readonly target: Body | undefined; // outlined in a section
  readonly ghost: number | undefined; // another film over it
  readonly follow: boolean; // the camera stays at the bur
}

// What changes the picture.
export type ScreenWish =
  | { readonly ask: "set"; readonly state: Partial<ScreenState> }
  | { readonly ask: "resize"; readonly width: number; readonly height: number; readonly ratio: number } // CSS pixels
  | { readonly ask: "view"; readonly preset: CameraPreset }
  | { readonly ask: "near"; readonly pointMm: PointMm }
  | { readonly ask: "middle"; readonly pointMm: PointMm } // turned and as near as now
  | { readonly ask: "reset" } // as it began
  | { readonly ask: "look"; readonly look: Look }
  | { readonly ask: "rotate"; readonly azimuthRad: number; readonly polarRad: number; readonly more: boolean } // more: motion follows
  | { readonly ask: "zoom"; readonly factor: number }
  | { readonly ask: "pan"; readonly right: number; readonly up: number } // of half the picture's height
  | { readonly ask: "redraw" }; // what lies over it has moved

export type ScreenAsk =
  | ScreenWish
  | {
      readonly ask: "open"; // on the canvas that was given last
      readonly film: number;
      readonly state: ScreenState;
      readonly look: Look | undefined;
    }
  | { readonly ask: "settle" } // in full now
  | { readonly ask: "picture"; readonly id: number; readonly preset: CameraPreset } // and is looked at as before
  | {
      readonly ask: "profile";
      readonly id: number;
      readonly from: PointMm;
      readonly to: PointMm;
      readonly samples: number;
    }
  | { readonly ask: "pick"; readonly id: number; readonly x: number; readonly y: number } // CSS pixels from the top left
  | { readonly ask: "close" };

export type ScreenTold =
  | {
      readonly told: "drawn";
      readonly wishes: number; // that it fulfils, of all so far
      readonly effort: Effort;
      readonly detail: Detail;
      readonly projection: readonly number[]; // 4 × 4, columns: from the scene to −1 … 1
      readonly look: Look;
      readonly middle: PointMm; // what is in its middle: the plane of a section, or what is looked at
      readonly extent: Extent;
    }
  | { readonly told: "picked"; readonly id: number; readonly point: SurfacePoint | undefined }
  | { readonly told: "picture"; readonly id: number; readonly png: Blob | undefined }
  | { readonly told: "profile"; readonly id: number; readonly heightMm: Float32Array } // NaN: no surface there
  | { readonly told: "lost"; readonly stopped: boolean }; // there is no picture: no WebGL, or the driver has stopped

export type StudioAsk =
  | { readonly film: number; readonly message: FilmAsk }
  | { readonly screen: number; readonly message: ScreenAsk }
  | { readonly ahead: OffscreenCanvas }; // of the screen that is opened next
export type StudioTold =
  | { readonly film: number; readonly message: FilmTold }
  | { readonly screen: number; readonly message: ScreenTold };
