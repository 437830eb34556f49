import { kFirstBytes } from "../../api/ahead";
import type { Client } from "../../api/client";
import type { ApiError } from "../../api/http";
import { say } from "../../base/words";
import { type FilmLink, studio } from "../../tooth/link";
import type { Compared, Detail, FilmTold } from "../../tooth/messages";
import type { Head } from "../../tooth/timeline";

// An attempt with the tooth being cut. Loads its timeline, which begins with what shows the end, and hands it to the
// worker that draws it. What other moments need is asked for when the end is seen.

export type PlaybackState =
  | { readonly state: "loading" }
  | { readonly state: "waiting"; readonly message: string } // the server has not made it yet
  | { readonly state: "failed"; readonly error: ApiError }
  | { readonly state: "ready" };

// The tooth at its end against the reference.
export type DeviationState =
  | { readonly state: "loading" }
  | { readonly state: "none" } // nothing to compare with
  | { readonly state: "failed"; readonly error: ApiError }
  | { readonly state: "ready"; readonly compared: Compared };

// Until something has happened.
class Wait<T> {
  end: (value: T) => void = () => undefined;
  readonly over = new Promise<T>((resolve) => {
    this.end = resolve;
  });
}

export const kToothFirstMs = 1500; // what comes after the coarse tooth waits for its picture, and no longer than this

// Begun before the page that shows it is there; of one attempt at most.
let begun: { readonly client: Client; readonly attempt: string; readonly playback: Playback } | undefined;

export function beginPlayback(client: Client, attempt: string): void {
  begun?.playback.dispose();
  const playback = new Playback(client, attempt, () => undefined);
  begun = { client, attempt, playback };
  void playback.load(kToothFirstMs);
}

// The one that was begun, given out once; else a new one. `changed`: as the constructor's.
export function playbackOf(client: Client, attempt: string, changed: () => void): Playback {
  const ahead = begun;
  if (ahead?.client !== client || ahead.attempt !== attempt) return new Playback(client, attempt, changed);
  begun = undefined;
  // Refused perhaps because nobody was signed in yet; or for somebody else who was.
  if (ahead.playback.state.state === "failed" || client.ahead.forgotten) {
    ahead.playback.dispose();
    return new Playback(client, attempt, changed);
  }
  ahead.playback.changed = changed;
  return ahead.playback;
}

export class Playback {
  state: PlaybackState = { state: "loading" };
  deviation: DeviationState = { state: "loading" };
  detail: Detail = "none"; // of the tooth that was drawn
  tissues: readonly number[] = []; // that were seen at the surface
  whole = false; // every moment is here
  position = 0; // frames of the tooth that is shown or being made
  wanted = 0; // frames of the tooth that was asked for last
  head: Head | undefined;
  readonly moves = new Set<() => void>(); // called when another moment is shown
  readonly gaps: Uint32Array[] = []; // by segment: ticks that passed before each frame's end and were not recorded
  readonly film: FilmLink | undefined; // undefined: this browser draws none
  private asked = false; // for its bytes
  private readonly abort = new AbortController();
  private readonly headCame = new Wait<Head | undefined>(); // undefined: it cannot be read
  private readonly coarseSeen = new Wait<void>();
  private readonly endSeen = new Wait<void>();

  // `changed` is called whenever the state or what is loaded has changed.
  constructor(
    private readonly client: Client,
    private readonly attempt: string,
    public changed: () => void,
  ) {
    try {
      this.film = studio().film((told) => this.told(told));
    } catch {
      const error: ApiError = { code: "unreachable", status: 0, field: "", message: say("playback.no_worker") };
      this.state = { state: "failed", error };
    }
  }

  dispose(): void {
    this.abort.abort();
    this.film?.close();
  }

  get drawn(): boolean {
    return this.detail === "fine";
  }
  get frames(): number {
    return this.head?.frames ?? 0;
  }
  // The tooth at `position`, not the one after the attempt.
  get showing(): boolean {
    return this.position < this.frames;
  }

  // Something of it was drawn.
  seen(): void {
    this.coarseSeen.end();
  }

  // Once more while the state is "waiting". `patienceMs`: for the picture of the coarse tooth, before more is asked for.
  async load(patienceMs = 0): Promise<void> {
    if (this.film === undefined || this.asked) return;
    this.asked = true;
    const error = (await this.part(0, kFirstBytes)) ?? (await this.rest(patienceMs));
    if (error === undefined || this.abort.signal.aborted) return;
    this.asked = false;
    const waits = error.code === "unavailable" && this.head === undefined;
    this.state = waits ? { state: "waiting", message: error.message } : { state: "failed", error };
    this.changed();
  }
  // What the end needs, then all else.
  private async rest(patienceMs: number): Promise<ApiError | undefined> {
    const head = await this.headCame.over;
    if (head === undefined) return undefined;
    await Promise.race([this.coarseSeen.over, new Promise((resolve) => setTimeout(resolve, patienceMs))]);
    const error = head.endsAt > kFirstBytes ? await this.part(kFirstBytes, head.endsAt) : undefined;
    if (error !== undefined) return error;
    await this.endSeen.over;
    const from = Math.max(head.endsAt, kFirstBytes);
    return from < head.fileBytes ? this.part(from, head.fileBytes) : undefined;
  }
  private async part(from: number, to: number): Promise<ApiError | undefined> {
    const bytes = await this.client.stream("/attempts/{id}/timeline", [from, to], {
      id: this.attempt,
      signal: this.abort.signal,
    });
    if (!bytes.ok) return bytes.error;
    const reader = bytes.value.getReader();
    try {
      for (;;) {
        const { done, value } = await reader.read();
        if (done) return undefined;
        // Its buffer is its own, or it would be handed over with what others hold.
        const own = value.byteLength === value.buffer.byteLength ? value.buffer : value.slice().buffer;
        this.film?.bytes(own);
      }
    } catch {
      return { code: "unreachable", status: 0, field: "", message: say("error.unreachable") };
    }
  }

  private malformed(message: string): ApiError {
    return { code: "malformed", status: 0, field: "", message: say("playback.malformed", { reason: message }) };
  }

  private told(told: FilmTold): void {
    switch (told.told) {
      case "head":
        this.head = told.head;
        this.position = this.wanted = told.head.frames;
        this.headCame.end(told.head);
        break;
      case "gaps":
        this.gaps[told.segment] = told.ticks;
        return; // all are known at the end
      case "ready":
        this.state = { state: "ready" };
        void this.loadDeviation();
        break;
      case "whole":
        this.whole = true;
        break;
      case "detail":
        this.detail = told.detail;
        this.tissues = told.tissues;
        if (this.drawn) this.endSeen.end();
        break;
      case "compared":
        this.deviation = !told.compared.ok
          ? { state: "failed", error: this.malformed(told.compared.error) }
          : told.compared.value === undefined
            ? { state: "none" }
            : { state: "ready", compared: told.compared.value };
        break;
      case "shown":
        if (told.frames === this.position && told.tissues.length === this.tissues.length) return;
        this.position = told.frames;
        this.tissues = told.tissues;
        for (const moved of this.moves) moved();
        return;
      case "failed":
        this.headCame.end(undefined);
        this.state = { state: "failed", error: this.malformed(told.message) };
        break;
    }
    this.changed();
  }

  private async loadDeviation(): Promise<void> {
    const bytes = await this.client.bytes("/attempts/{id}/deviation", {
      id: this.attempt,
      signal: this.abort.signal,
      kept: true,
    });
    if (this.abort.signal.aborted) return;
    if (bytes.ok) return this.film?.deviation(bytes.value);
    this.deviation = bytes.error.code === "not_found" ? { state: "none" } : { state: "failed", error: bytes.error };
    this.changed();
  }

  // Shows the tooth after so many frames; the latest wish counts.
  show(frames: number): void {
    const wanted = Math.max(0, Math.min(Math.round(frames), this.frames));
    if (wanted === this.wanted) return;
    this.wanted = wanted;
    this.endSeen.end(); // it may need the rest
    this.film?.seek(wanted);
  }
}
