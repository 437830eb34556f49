import type { Client } from "../../api/client";
import type { ApiError } from "../../api/http";
import type { Surface } from "../../api/surface";
import type { Head, TimelinePlayer } from "../../api/timeline";
import type { BlockMesh, ToothMesher } from "../../api/tooth_mesh";
import type { Film, FilmScreen } from "../../widgets/tooth/film";

// An attempt with the tooth being cut. Loads its timeline: first what the tooth at the end needs, then the rest.

const kFirstBytes = 16_384;                     // the head of an attempt of six hours
const kSliceMs = 12;                            // of the page's thread at a time

export type PlaybackState =
  | { readonly state: "loading" }
  | { readonly state: "waiting"; readonly message: string }   // the server has not made it yet
  | { readonly state: "failed"; readonly error: ApiError }
  | { readonly state: "ready" };

// What reads timelines and makes triangles is fetched with the first of them: a page without a tooth does without.
const timelines = () => import("../../api/timeline");
const meshes = () => import("../../api/tooth_mesh");

const nextTask = () => new Promise<void>((resolve) => { setTimeout(resolve); });

export class Playback implements Film {
  state: PlaybackState = { state: "loading" };
  whole = false;                                // all segments are here
  position = 0;                                 // frames of the tooth that is shown or being made
  private player: TimelinePlayer | undefined;
  private mesher: ToothMesher | undefined;
  private readonly meshes = new Map<number, BlockMesh>();
  private readonly dirty = new Set<number>();
  private readonly screens = new Set<FilmScreen>();
  private wanted: number | undefined;
  private working = false;
  showing = false;                              // the tooth at `position`, not the one after the attempt
  private readonly abort = new AbortController();

  // `changed` is called whenever state, position or what is loaded has changed.
  constructor(private readonly client: Client, private readonly attempt: string, private readonly changed: () => void) {}

  dispose(): void {
    this.abort.abort();
    this.screens.clear();
  }

  get head(): Head | undefined {
    return this.player?.head;
  }
  get frames(): number {
    return this.player?.head.frames ?? 0;
  }

  async load(): Promise<void> {
    const error = await this.loadEnd();
    if (this.abort.signal.aborted) return;
    if (error !== undefined) {
      this.state = error.code === "unavailable" ? { state: "waiting", message: error.message } : { state: "failed", error };
      this.changed();
      return;
    }
    this.position = this.frames;
    this.state = { state: "ready" };
    this.changed();
    const rest = await this.loadRest();
    if (this.abort.signal.aborted) return;
    if (rest !== undefined) this.state = { state: "failed", error: rest };
    else this.whole = true;
    this.changed();
    // What was asked for meanwhile.
    void this.work();
  }

  private part(from: number, to: number) {
    return this.client.timeline(this.attempt, from, to, this.abort.signal);
  }
  private malformed(message: string): ApiError {
    return { code: "malformed", status: 0, field: "", message: `The playback was not understood: ${message}` };
  }

  // Head, start tooth and last segment: the tooth at the end.
  private async loadEnd(): Promise<ApiError | undefined> {
    const [first, code] = await Promise.all([this.part(0, kFirstBytes), Promise.all([timelines(), meshes()]).catch(() => undefined)]);
    if (!first.ok) return first.error;
    if (code === undefined) return { code: "unreachable", status: 0, field: "", message: "What reads it could not be loaded: load the page again" };
    const [{ decodeHead, TimelinePlayer }, { ToothMesher }] = code;
    const head = await decodeHead(first.value);
    if (!head.ok) return this.malformed(head.error);
    if (head.value === undefined) return this.malformed("its head is longer than this page reads");
    const last = head.value.segments.length - 1;
    const [start, segment] = await Promise.all([this.client.startTooth(head.value.start, this.abort.signal), this.segment(head.value, last)]);
    if (!start.ok) return start.error;
    if (segment !== undefined && "code" in segment) return segment;
    const player = new TimelinePlayer(head.value, start.value);
    if (segment !== undefined) player.add(last, segment);
    const found = player.seek(player.head.frames);
    if (!found.ok) return this.malformed(found.error);
    this.player = player;
    this.mesher = new ToothMesher(player);
    for (const block of this.mesher.allBlocks()) this.dirty.add(block);
    for (const block of this.mesher.blocksOf(found.value)) this.dirty.add(block);
    await this.meshDirty();
    return undefined;
  }
  private async segment(head: Head, index: number) {
    const segment = head.segments[index];
    if (segment === undefined) return undefined;
    const { decodeSegment, segmentBytes } = await timelines();
    const bytes = await this.part(segment.from, segment.from + segmentBytes(segment));
    if (!bytes.ok) return bytes.error;
    const open = await decodeSegment(head, index, new Uint8Array(bytes.value));
    return open.ok ? open.value : this.malformed(open.error);
  }

  // All other segments, in one answer: together they are smaller than a photograph.
  private async loadRest(): Promise<ApiError | undefined> {
    const player = this.player;
    const last = player?.head.segments.at(-1);
    if (player === undefined || last === undefined || last.from === player.head.bytes) return undefined;
    const { decodeSegment, segmentBytes } = await timelines();
    const bytes = await this.part(player.head.bytes, last.from);
    if (!bytes.ok) return bytes.error;
    for (const [i, segment] of player.head.segments.entries()) {
      if (player.has(i)) continue;
      const at = segment.from - player.head.bytes;
      const open = await decodeSegment(player.head, i, new Uint8Array(bytes.value.slice(at, at + segmentBytes(segment))));
      if (!open.ok) return this.malformed(open.error);
      player.add(i, open.value);
    }
    return undefined;
  }

  // The tooth as it is at the end, for who wants it before its deviation is here.
  surface(): Surface {
    const meshes = [...this.meshes.values()];
    const count = (of: (mesh: BlockMesh) => number) => meshes.reduce((sum, mesh) => sum + of(mesh), 0);
    const vertices = count((mesh) => mesh.tissue.length);
    const out = { positionMm: new Float32Array(3 * vertices), normal: new Int8Array(4 * vertices), tissue: new Uint8Array(vertices), deviationMm: undefined,
                  triangle: new Uint32Array(count((mesh) => mesh.triangle.length)) };
    let first = 0;
    let at = 0;
    for (const mesh of meshes) {
      out.positionMm.set(mesh.positionMm, 3 * first);
      out.normal.set(mesh.normal, 4 * first);
      out.tissue.set(mesh.tissue, first);
      for (const index of mesh.triangle) out.triangle[at++] = first + index;
      first += mesh.tissue.length;
    }
    return out;
  }

  attach(screen: FilmScreen): () => void {
    this.screens.add(screen);
    for (const [block, mesh] of this.meshes) screen.setBlock(block, mesh);
    this.tell(screen);
    return () => { this.screens.delete(screen); };
  }

  private tell(screen: FilmScreen): void {
    screen.showFilm(this.showing);
    screen.setBur(this.head?.outline ?? [], this.showing ? this.player?.pose(this.position) : undefined);
  }

  // Shows the tooth after so many frames; the latest wish counts.
  show(frames: number): void {
    this.wanted = Math.max(0, Math.min(Math.round(frames), this.frames));
    void this.work();
  }
  private async work(): Promise<void> {
    const player = this.player;
    if (this.working || player === undefined) return;
    this.working = true;
    while (this.wanted !== undefined && !this.abort.signal.aborted) {
      const frames = this.wanted;
      const found = player.seek(frames);
      // A part that is not here yet: it is asked for again when it is.
      if (!found.ok) break;
      this.wanted = undefined;
      for (const block of this.mesher?.blocksOf(found.value) ?? []) this.dirty.add(block);
      await this.meshDirty();
      this.position = frames;
      // At the end the picture of the whole attempt is the better one: it has the deviation.
      this.showing = frames < this.frames;
      for (const screen of this.screens) this.tell(screen);
      this.changed();
    }
    this.working = false;
  }

  private async meshDirty(): Promise<void> {
    let until = performance.now() + kSliceMs;
    for (const block of this.dirty) {
      this.dirty.delete(block);
      const mesh = this.mesher?.mesh(block);
      if (mesh === undefined) this.meshes.delete(block);
      else this.meshes.set(block, mesh);
      for (const screen of this.screens) screen.setBlock(block, mesh);
      if (performance.now() < until) continue;
      await nextTask();
      if (this.abort.signal.aborted) return;
      until = performance.now() + kSliceMs;
    }
  }
}
